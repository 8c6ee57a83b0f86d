#include "api/redaction/svg_names.hpp"

#include <algorithm>
#include <utility>

namespace vacuform::redaction {

std::string with_words(std::string_view list, const NewName& name) {
  std::string out;
  while (!list.empty()) {
    const std::size_t end = std::min(list.find_first_of(" \t\r\n"), list.size());
    if (end > 0) out += name(list.substr(0, end));
    out += list.substr(end, 1);
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return out;
}

std::optional<std::string> with_names(std::string_view selectors, const NewName& name) {
  std::string out;
  bool named = false;
  for (std::size_t at = 0; at < selectors.size();) {
    const char c = selectors[at++];
    out += c;
    if (c == ',' && !std::exchange(named, false)) return std::nullopt;
    if (c != '.' && c != '#') continue;
    const std::size_t end = std::min(selectors.find_first_of(" \t\r\n.#:,>+~[]()*", at), selectors.size());
    out += name(selectors.substr(at, end - at));
    named |= end > at;
    at = end;
  }
  if (!named) return std::nullopt;
  return out;
}

OwnNames::OwnNames(const Names& own, const Names& of_others) {
  Names ends;  // of all of them, from the last underscore on
  for (const Names* names : {&own, &of_others})
    for (const std::string& word : *names)
      if (const std::size_t end = word.rfind('_'); end != word.npos) ends.insert(word.substr(end));
  int number = 2;
  const auto number_end = [&] { return std::string("_").append(std::to_string(number)); };
  while (ends.contains(number_end())) ++number;
  for (const std::string& word : own)
    if (of_others.contains(word)) renamed_.emplace(word, word + number_end());
}

std::string OwnNames::operator()(std::string_view name) const {
  const auto at = renamed_.find(name);
  return at == renamed_.end() ? std::string(name) : at->second;
}

}  // namespace vacuform::redaction
