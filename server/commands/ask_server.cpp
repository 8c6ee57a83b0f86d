#include "server/commands/ask_server.hpp"

#include "api/base/file.hpp"
#include "api/client/http.hpp"

namespace vacuform {

using nlohmann::ordered_json;

namespace {

Result<std::string> line_of(const std::filesystem::path& file) {
  VACUFORM_TRY(line, read_text_file(file, 1024));
  line.erase(line.find_last_not_of('\n') + 1);
  return line;
}

}  // namespace

Result<std::string> server_url(const std::filesystem::path& data, const Error& unopened) {
  auto url = line_of(data / "server-url");
  return url ? std::move(url) : tl::make_unexpected(unopened);
}

Result<ordered_json> ask_server(const std::filesystem::path& data, const Error& unopened,
                                const std::string& method, const std::string& path, const std::string& body,
                                std::chrono::seconds limit) {
  VACUFORM_TRY(url, server_url(data, unopened));
  VACUFORM_TRY(token, line_of(data / "admin-token"));
  VACUFORM_TRY(http, Http::to(url, token));
  HttpRequest request;
  request.method = method;
  request.path = path;
  request.body = body;
  if (!body.empty()) request.headers = {{"Content-Type", "application/json"}};
  request.limit = limit;
  VACUFORM_TRY(response, http.send(request));
  if (response.status < 200 || response.status > 299) return tl::make_unexpected(error_of(response));
  auto answer = ordered_json::parse(response.body, nullptr, false);
  return answer.is_discarded() ? ordered_json::object() : answer;
}

}  // namespace vacuform
