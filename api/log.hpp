// The log of the server and of the workers: one JSON object a line on stderr. It names jobs, requests and tokens by
// their ids and routes by their patterns; names of files and people, settings, addresses and secrets never reach it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace vacuform {

// log_event("job-created", {{"job", id}}) writes {"time": ..., "event": "job-created", "job": ...} and the request
// that this thread works for, where there is one. From any thread.
void log_event(std::string_view event, const nlohmann::ordered_json& fields);

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
