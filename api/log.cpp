#include "api/log.hpp"

#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "api/clock.hpp"

namespace vacuform {

namespace {
thread_local std::string request;
}

LoggedRequest::LoggedRequest(std::string id) : outer_(std::exchange(request, std::move(id))) {}
LoggedRequest::~LoggedRequest() { request = std::move(outer_); }

const std::string& logged_request() { return request; }

bool is_request_id(std::string_view text) {
  return text.size() == 32 && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

void log_event(std::string_view event, const nlohmann::ordered_json& fields) {
  nlohmann::ordered_json line = {{"time", rfc3339(wall_clock())}, {"event", event}};
  line.update(fields);
  if (!request.empty()) line["request"] = request;
  const std::string text = line.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  // One write a line, so that lines of several threads and processes never mix. A log that cannot be written stops
  // no job.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text.data(), text.size());
}

}  // namespace vacuform
