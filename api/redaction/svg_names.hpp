// The ids and classes of an SVG that becomes a part of another drawing. Internal to api/redaction.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace vacuform::redaction {

using Names = std::set<std::string, std::less<>>;
using NewName = std::function<std::string(std::string_view)>;

// A list of words, such as the attribute `class`, with what `name` gives for each of them.
std::string with_words(std::string_view list, const NewName& name);

// Selectors of CSS with what `name` gives for each class and id in them. Nothing if one of them has neither.
std::optional<std::string> with_names(std::string_view selectors, const NewName& name);

// Gives a name that another part has, too, a number of its own. Linear in both.
class OwnNames {
 public:
  OwnNames() = default;
  OwnNames(const Names& own, const Names& of_others);
  std::string operator()(std::string_view name) const;

 private:
  std::map<std::string, std::string, std::less<>> renamed_;
};

}  // namespace vacuform::redaction
