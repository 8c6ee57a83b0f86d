// The head of an answer as it is sent.
#pragma once

#include <string>

#include "server/http/message.hpp"

namespace vacuform::http {

// The status line and the header lines, with the empty line behind them. `keep`: the connection stays open.
// Content-Length is that of the body, also for HEAD; a stream has none.
std::string response_head(const Request& request, const Response& response, bool keep);

}  // namespace vacuform::http
