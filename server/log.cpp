#include "server/log.hpp"

#include <unistd.h>

#include <nlohmann/json.hpp>
#include <string>

#include "server/clock.hpp"

namespace vacuform {

void log_event(std::string_view event, const nlohmann::ordered_json& fields) {
  nlohmann::ordered_json line = {{"time", rfc3339(wall_clock())}, {"event", event}};
  line.update(fields);
  const std::string text = line.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  // One write a line, so that lines of several threads never mix. A log that cannot be written stops no job.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text.data(), text.size());
}

}  // namespace vacuform
