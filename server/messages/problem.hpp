// JSON input and output: objects in requests, answers, and errors as RFC 9457 problems. All errors leave the server in
// this form.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "server/messages/message.hpp"

namespace vacuform {

// {type, title, status, detail, what, where, fix, proposals}. `status` 0 means the default status of the code.
nlohmann::ordered_json problem_json(const Error& error, int status = 0);
http::Response problem_response(const Error& error, int status = 0);

// The Retry-After of every 429 and 503, in a problem or a page.
void set_retry_after(http::Response& response);
// Replaces that value.
void set_retry_after(http::Response& response, std::int64_t seconds);

// JSON text; bytes that are not UTF-8 become U+FFFD.
std::string dump(const nlohmann::ordered_json& json);
http::Response json_response(const nlohmann::ordered_json& json, int status = 200);
http::Response json_text_response(std::string text, int status = 200);  // from text that is already JSON

// The body as JSON text; empty if there is no body. Errors: unsupported_format unless Content-Type is JSON; those of
// read_text().
Result<std::string> read_json_text(http::Request& request, std::uint64_t limit);
// The body as a JSON object (strict_json.hpp); empty if there is no body. Errors: as above; bad_usage.
Result<nlohmann::json> read_object(http::Request& request, std::uint64_t limit);

}  // namespace vacuform
