#include "server/messages/request_id.hpp"

#include "api/base/log.hpp"
#include "api/base/secrets.hpp"

namespace vacuform::http {

namespace {

// "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01" -> the second piece; of zeros alone it is invalid.
std::string trace_id(std::string_view traceparent) {
  if (traceparent.size() != 55 || !traceparent.starts_with("00-") || traceparent[35] != '-') return {};
  const std::string id(traceparent.substr(3, 32));
  return is_request_id(id) && id.find_first_not_of('0') != std::string::npos ? id : std::string();
}

std::string without_dashes(std::string_view uuid) {
  std::string id;
  for (const char c : uuid)
    if (c != '-') id += static_cast<char>(c >= 'A' && c <= 'F' ? c - 'A' + 'a' : c);
  return uuid.size() <= 36 && is_request_id(id) ? id : std::string();
}

}  // namespace

std::string request_id(const std::vector<Header>& headers) {
  Request request;
  request.headers = headers;
  std::string id = trace_id(request.header("traceparent"));
  if (id.empty()) id = without_dashes(request.header("X-Request-Id"));
  return id.empty() ? random_hex(16) : id;
}

}  // namespace vacuform::http
