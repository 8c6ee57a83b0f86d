#include "server/commands/ask_server.hpp"

#include "api/base/file.hpp"
#include "api/client/http.hpp"

namespace vacuform {

using nlohmann::ordered_json;

Result<ordered_json> ask_server(const std::filesystem::path& data, const Error& unopened,
                                const std::string& method, const std::string& path, const std::string& body,
                                std::chrono::seconds limit) {
  auto address = read_text_file(data / "server-url", 1024);
  if (!address) return tl::make_unexpected(unopened);
  std::string url = std::move(*address);
  VACUFORM_TRY(token, read_text_file(data / "admin-token", 1024));
  for (std::string* line : {&url, &token}) line->erase(line->find_last_not_of('\n') + 1);
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
