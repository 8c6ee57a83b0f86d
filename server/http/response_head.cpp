#include "server/http/response_head.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace vacuform::http {

namespace {

constexpr std::array<std::pair<int, std::string_view>, 30> reasons{{
    {200, "OK"},
    {201, "Created"},
    {202, "Accepted"},
    {204, "No Content"},
    {206, "Partial Content"},
    {303, "See Other"},
    {304, "Not Modified"},
    {400, "Bad Request"},
    {401, "Unauthorized"},
    {403, "Forbidden"},
    {404, "Not Found"},
    {405, "Method Not Allowed"},
    {408, "Request Timeout"},
    {409, "Conflict"},
    {410, "Gone"},
    {411, "Length Required"},
    {412, "Precondition Failed"},
    {413, "Content Too Large"},
    {414, "URI Too Long"},
    {415, "Unsupported Media Type"},
    {416, "Range Not Satisfiable"},
    {417, "Expectation Failed"},
    {421, "Misdirected Request"},
    {422, "Unprocessable Content"},
    {423, "Locked"},
    {429, "Too Many Requests"},
    {431, "Request Header Fields Too Large"},
    {500, "Internal Server Error"},
    {501, "Not Implemented"},
    {503, "Service Unavailable"},
}};

// Empty where HTTP has none, as for the 460 of tus.
std::string_view reason(int status) {
  const auto* const found =
      std::find_if(reasons.begin(), reasons.end(), [&](const auto& entry) { return entry.first == status; });
  return found == reasons.end() ? "" : found->second;
}

}  // namespace

std::string response_head(const Request& request, const Response& response, bool keep) {
  std::string text = "HTTP/1.1 " + std::to_string(response.status) + " ";
  text.append(reason(response.status)).append("\r\n");
  const auto add = [&](std::string_view name, std::string_view value) {
    text.append(name).append(": ").append(value).append("\r\n");
  };
  for (const Header& header : response.headers) {
    // It is about what is sent, and that is nothing here.
    if (request.head_only && header.name == "Content-Digest") continue;
    add(header.name, header.value);
  }
  add("X-Request-Id", request.id);
  if (!keep) add("Connection", "close");
  if (response.status != 204 && response.status != 304) {
    if (!response.media_type.empty()) add("Content-Type", response.media_type);
    const std::uint64_t bytes = response.file ? response.file->bytes : response.text.size();
    if (!response.stream) add("Content-Length", std::to_string(bytes));
  }
  return text += "\r\n";
}

}  // namespace vacuform::http
