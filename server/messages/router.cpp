#include "server/messages/router.hpp"

#include <algorithm>

namespace vacuform::http {

namespace {

// Takes the text up to the next '/', and that too.
std::string_view take_piece(std::string_view& text) {
  const std::size_t slash = text.find('/');
  const std::string_view piece = text.substr(0, slash);
  text.remove_prefix(slash == std::string_view::npos ? text.size() : slash + 1);
  return piece;
}

bool fits(std::string_view pattern, std::string_view path, std::map<std::string, std::string>& captures) {
  captures.clear();
  while (!pattern.empty() || !path.empty()) {
    if (pattern.empty() || path.empty() || (pattern.back() == '/') != (path.back() == '/')) return false;
    const std::string_view wanted = take_piece(pattern), piece = take_piece(path);
    if (wanted.starts_with('{') && !piece.empty())
      captures.emplace(wanted.substr(1, wanted.size() - 2), piece);
    else if (wanted != piece)
      return false;
  }
  return true;
}

std::optional<Refusal> query_refusal(const Route& route,
                                     const std::multimap<std::string, std::string>& query) {
  std::string known;
  for (const std::string& name : route.query) known += (known.empty() ? "" : ", ") + name;
  for (const auto& [name, value] : query) {
    const std::string shown = name.substr(0, 64);
    if (std::find(route.query.begin(), route.query.end(), name) == route.query.end())
      return Refusal{400,
                     {Code::bad_usage, "unknown query parameter: " + shown, "query",
                      known.empty() ? "send no query" : "send only " + known}};
    if (query.count(name) > 1)
      return Refusal{400,
                     {Code::bad_usage, "query parameter given twice: " + shown, "query", "send it once"}};
  }
  return std::nullopt;
}

}  // namespace

Admission everybody(Handler handler) {
  return [handler = std::move(handler)](const Request&) -> Result<Admitted> { return Admitted{{}, handler}; };
}

void Router::add(std::string method, std::string pattern, Handler handler) {
  add(Route{std::move(method), std::move(pattern), everybody(std::move(handler))});
}

void Router::add(Route route) {
  const std::string whole = route.pattern;
  route.pattern = whole.substr(0, whole.find('?'));
  for (std::size_t at = whole.find('?'); at != std::string::npos;) {
    const std::size_t next = whole.find('&', at + 1);
    route.query.push_back(whole.substr(at + 1, next == std::string::npos ? next : next - at - 1));
    at = next;
  }
  routes_.push_back(std::move(route));
}

Router::Match Router::match(std::string_view method, std::string_view path) const {
  Match match;
  for (const Route& route : routes_) {
    if (!fits(route.pattern, path, match.captures)) continue;
    if (route.method == method) {
      match.route = &route;
      return match;
    }
    match.allowed +=
        (match.allowed.empty() ? "" : ", ") + route.method + (route.method == "GET" ? ", HEAD" : "");
  }
  return match;
}

std::optional<Refusal> unserved(const Router::Match& match, const Request& request) {
  const auto refuse = [](int status, Code code, std::string what, std::string where, std::string fix) {
    return Refusal{status, {code, std::move(what), std::move(where), std::move(fix)}};
  };
  if (!match.route && !match.allowed.empty())
    return refuse(405, Code::bad_usage, "this address does not answer to that method", {},
                  "use " + match.allowed);
  if (!match.route) return refuse(404, Code::not_found, "there is nothing at this address", {}, "see /");
  if (auto refusal = query_refusal(*match.route, request.query)) return refusal;
  const std::uint64_t most = match.route->most_body;
  if (request.content_length <= most) return std::nullopt;
  return refuse(413, Code::too_large,
                "the body is larger than " +
                    (most >= 1 << 20 ? std::to_string(most >> 20) + " MiB" : std::to_string(most) + " bytes"),
                "request body", "send less");
}

}  // namespace vacuform::http
