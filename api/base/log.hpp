// The log of the server and of the workers: one JSON object per line on stderr. It contains the ids of jobs, requests
// and tokens and the patterns of routes, but never names of files and people, settings, addresses or secrets.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "api/base/error.hpp"

namespace vacuform {

// log_event("job-created", {{"job", id}}) writes {"time": ..., "event": "job-created", "job": ...} and the current
// request of this thread, if there is one. From any thread.
void log_event(std::string_view event, const nlohmann::ordered_json& fields);

// Redirects standard error, of this program and of programs started by it, to this file, which is created if absent.
// Errors: unreadable.
Result<void> log_into(const std::filesystem::path& file);
// When the log file `file` has reached so many bytes, copies it to FILE.1 and truncates it; lines that are written at
// that moment may be lost. Call it regularly; an empty name does nothing.
void bound_log(const std::filesystem::path& file, std::uint64_t most_bytes = 32u << 20);

// While it exists, the lines of this thread contain {"request": id}: in the server the current request, in its worker
// the request that created the job. So one id connects both logs. The innermost object counts; an empty id means no
// request.
class LoggedRequest {
 public:
  explicit LoggedRequest(std::string id);
  ~LoggedRequest();
  LoggedRequest(const LoggedRequest&) = delete;
  LoggedRequest& operator=(const LoggedRequest&) = delete;

 private:
  std::string outer_;
};

// The id of the request that this thread works for; empty without one.
const std::string& logged_request();

// Whether a text may appear as an id in the log: 32 lower-case hexadecimal digits (a trace id of W3C Trace Context),
// which cannot spell a name.
bool is_request_id(std::string_view text);

}  // namespace vacuform
