#include "server/access/token_json.hpp"

#include <nlohmann/json.hpp>

namespace vacuform {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

constexpr Millis day = 24LL * 3600 * 1000;
constexpr double most_days = 3650;

ordered_json time_or_null(const std::optional<Millis>& time) {
  return time ? ordered_json(rfc3339(*time)) : ordered_json();
}

}  // namespace

ordered_json scopes_json(const Scopes& scopes) {
  ordered_json names = ordered_json::array();
  for (std::size_t i = 0; i < scope_names.size(); ++i)
    if (scopes.has(static_cast<Scope>(i))) names.push_back(scope_names[i]);
  return names;
}

ordered_json token_json(const Token& token) {
  return {{"id", token.id},
          {"owner", token.owner},
          {"scopes", scopes_json(token.scopes)},
          {"created", rfc3339(token.created)},
          {"expires", time_or_null(token.expires)},
          {"revoked", time_or_null(token.revoked)}};
}

Result<NewToken> new_token_from(const json& object, Millis now) {
  const auto refuse = [](const char* what, const char* where) {
    return fail(Code::bad_usage, what, where,
                R"(send {"owner": "station-3", "scopes": ["submit", "read"], "days": 90})");
  };
  if (!object.is_object()) return refuse("the body is not a JSON object", "request body");
  NewToken wanted;
  for (const auto& [key, value] : object.items()) {
    if (key == "owner" && value.is_string()) {
      wanted.owner = value.get<std::string>();
    } else if (key == "scopes" && value.is_array()) {
      for (const json& item : value) {
        const auto scope = item.is_string() ? Scopes::from(item.get<std::string>()) : std::nullopt;
        if (!scope) return refuse("there is no such scope", "scopes");
        for (std::size_t i = 0; i < scope_names.size(); ++i)
          if (scope->has(static_cast<Scope>(i))) wanted.scopes.add(static_cast<Scope>(i));
      }
    } else if (key == "days" && value.is_number() && value.get<double>() > 0 &&
               value.get<double>() <= most_days) {
      wanted.expires = now + static_cast<Millis>(value.get<double>() * day);
    } else if (key != "days" || !value.is_null()) {
      return refuse("unknown, or not of the documented type and range", "owner, scopes, days");
    }
  }
  return wanted;
}

}  // namespace vacuform
