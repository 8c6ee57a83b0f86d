// One id a request, by which it is found again in the logs of everyone that it reaches.
#pragma once

#include <string>
#include <vector>

#include "server/messages/message.hpp"

namespace vacuform::http {

// The trace id of a traceparent (W3C Trace Context, version 00), else an X-Request-Id that is a UUID or 32
// hexadecimal digits, else a random one. Always of the form that is_request_id() knows.
std::string request_id(const std::vector<Header>& headers);

}  // namespace vacuform::http
