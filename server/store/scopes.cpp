#include "server/store/scopes.hpp"

#include <algorithm>

namespace vacuform {

std::optional<Scopes> Scopes::from(std::string_view text) {
  Scopes scopes;
  for (;;) {
    const std::size_t comma = text.find(',');
    const auto named = std::find(scope_names.begin(), scope_names.end(), text.substr(0, comma));
    if (named == scope_names.end()) return std::nullopt;
    scopes.add(static_cast<Scope>(named - scope_names.begin()));
    if (comma == std::string_view::npos) return scopes;
    text.remove_prefix(comma + 1);
  }
}

std::string Scopes::text() const {
  std::string text;
  for (std::size_t i = 0; i < scope_names.size(); ++i)
    if (has(static_cast<Scope>(i))) text.append(text.empty() ? "" : ",").append(scope_names[i]);
  return text;
}

}  // namespace vacuform
