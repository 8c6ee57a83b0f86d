// Errors as RFC 9457 problems: the one way in which an error leaves the server.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "server/http/message.hpp"

namespace vacuform {

// {type, title, status, detail, what, where, mend}. `status` 0 takes the code's own.
nlohmann::ordered_json problem_json(const Error& error, int status = 0);
http::Response problem_response(const Error& error, int status = 0);

// JSON text; bytes that are no UTF-8 become U+FFFD.
std::string dump(const nlohmann::ordered_json& json);
http::Response json_response(const nlohmann::ordered_json& json, int status = 200);

}  // namespace vacuform
