// JSON in and out: objects in requests, answers, and errors as RFC 9457 problems, the one way in which an error leaves the
// server.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "server/http/message.hpp"

namespace vacuform {

// {type, title, status, detail, what, where, fix}. `status` 0 takes the code's own.
nlohmann::ordered_json problem_json(const Error& error, int status = 0);
http::Response problem_response(const Error& error, int status = 0);

// The Retry-After that every 429 and 503 has, in a problem or a page.
void set_retry_after(http::Response& response);
// Another one in its place.
void set_retry_after(http::Response& response, std::int64_t seconds);

// JSON text; bytes that are no UTF-8 become U+FFFD.
std::string dump(const nlohmann::ordered_json& json);
http::Response json_response(const nlohmann::ordered_json& json, int status = 200);
http::Response json_text_response(std::string text, int status = 200);  // of JSON that is written already

// The body as JSON text, empty when there is none. Errors: unsupported_format unless Content-Type says so; those of
// read_text().
Result<std::string> read_json_text(http::Request& request, std::uint64_t limit);
// The body as a JSON object (strict_json.hpp), empty when there is none. Errors: as above; bad_usage.
Result<nlohmann::json> read_object(http::Request& request, std::uint64_t limit);

}  // namespace vacuform
