#include "api/base/log.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "api/base/clock.hpp"

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

Result<void> log_into(const std::filesystem::path& file) {
  const int opened = ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  const bool taken = opened >= 0 && ::dup2(opened, STDERR_FILENO) == STDERR_FILENO;
  if (opened >= 0) ::close(opened);
  if (taken) return {};
  return fail(Code::unreadable, "the log cannot be written to", file.string(),
              "give --log a file that may be written to");
}

void bound_log(const std::filesystem::path& file, std::uint64_t most_bytes) {
  struct stat info {};
  if (file.empty() || ::fstat(STDERR_FILENO, &info) != 0 ||
      static_cast<std::uint64_t>(info.st_size) < most_bytes)
    return;
  // The workers hold the same file open: it is emptied, not replaced.
  std::error_code error;
  std::filesystem::copy_file(file, std::filesystem::path(file).concat(".1"),
                             std::filesystem::copy_options::overwrite_existing, error);
  [[maybe_unused]] const int emptied =
      ::ftruncate(STDERR_FILENO, 0);  // on a full disk too, where there is no copy
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
