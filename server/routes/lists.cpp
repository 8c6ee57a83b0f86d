#include "server/routes/lists.hpp"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "server/messages/problem.hpp"

namespace vacuform {

using http::Request;
using http::Response;
using nlohmann::ordered_json;

Result<std::int64_t> query_number(const Request& request, const std::string& name, std::int64_t fallback,
                                  std::int64_t least, std::int64_t most) {
  const std::string text = request.query_value(name);
  if (text.empty()) return fallback;
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < least || number > most)
    return fail(
        Code::bad_usage,
        name + " is not a number from " + std::to_string(least) + " to " + std::to_string(most) + ": " + text,
        name, "give for example " + std::to_string(fallback));
  return number;
}

Result<PageAsked> page_asked(const Request& request) {
  VACUFORM_TRY(limit, query_number(request, "limit", 20, 1, 100));
  std::string cursor = request.query_value("cursor");
  const bool plain = std::all_of(cursor.begin(), cursor.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
  if (!plain || cursor.size() > 64)
    return fail(Code::bad_usage, "this cursor is not from a list", "cursor",
                "give the value of next from the page before");
  return PageAsked{static_cast<int>(limit), std::move(cursor)};
}

Response page_response(const char* name, ordered_json items, const std::optional<std::string>& next) {
  return json_response({{name, std::move(items)}, {"next", next ? ordered_json(*next) : ordered_json()}});
}

Response no_content() {
  Response response;
  response.status = 204;
  return response;
}

}  // namespace vacuform
