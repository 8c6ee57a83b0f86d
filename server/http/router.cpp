#include "server/http/router.hpp"

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

}  // namespace

void Router::add(std::string method, std::string pattern, Handler handler) {
  add(Route{std::move(method), std::move(pattern), std::move(handler)});
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

}  // namespace vacuform::http
