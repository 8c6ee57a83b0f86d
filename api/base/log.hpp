// The log of the server and of the workers: one JSON object a line on stderr. It names jobs, requests and tokens by
// their ids and routes by their patterns; names of files and people, settings, addresses and secrets never reach it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "api/base/error.hpp"

namespace vacuform {

// log_event("job-created", {{"job", id}}) writes {"time": ..., "event": "job-created", "job": ...} and the request
// that this thread works for, where there is one. From any thread.
void log_event(std::string_view event, const nlohmann::ordered_json& fields);

// From now on standard error, here and in the programs that are started from here, is this file, which is made when absent.
// Errors: unreadable.
Result<void> log_into(const std::filesystem::path& file);
// When `file`, in which the log is, has grown to so many bytes, copies it to FILE.1 and begins it again; lines that are
// written in that moment may be lost. Call it now and then; an empty name does nothing.
void bound_log(const std::filesystem::path& file, std::uint64_t most_bytes = 32u << 20);

// While it lives, the lines of this thread carry {"request": id}: the request that they come of, in the server, and
// the request that made the job, in its worker. So one id leads through both logs. The innermost counts; an empty id
// is none.
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

// Whether a text may stand as an id in the log: 32 lower-case hexadecimal digits (a trace id of W3C Trace Context),
// which cannot spell a name.
bool is_request_id(std::string_view text);

}  // namespace vacuform
