#include "worker/pattern/svg_style.hpp"

#include <algorithm>

#include "api/base/text.hpp"
#include "worker/pattern/svg_values.hpp"

namespace vacuform {

namespace {

struct Described {
  Property property;
  std::string_view name, initial;
};

constexpr std::array<Described, static_cast<std::size_t>(Property::count)> described{{
    {Property::fill, "fill", "black"},
    {Property::fill_opacity, "fill-opacity", "1"},
    {Property::fill_rule, "fill-rule", "nonzero"},
    {Property::stroke, "stroke", "none"},
    {Property::stroke_width, "stroke-width", "1"},
    {Property::stroke_opacity, "stroke-opacity", "1"},
    {Property::stroke_linecap, "stroke-linecap", "butt"},
    {Property::stroke_linejoin, "stroke-linejoin", "miter"},
    {Property::stroke_miterlimit, "stroke-miterlimit", "4"},
    {Property::stroke_dasharray, "stroke-dasharray", "none"},
    {Property::stroke_dashoffset, "stroke-dashoffset", "0"},
    {Property::color, "color", "black"},
    {Property::visibility, "visibility", "visible"},
    {Property::paint_order, "paint-order", "normal"},
    {Property::marker_start, "marker-start", "none"},
    {Property::marker_mid, "marker-mid", "none"},
    {Property::marker_end, "marker-end", "none"},
    {Property::opacity, "opacity", "1"},
    {Property::display, "display", "inline"},
    {Property::clip_path, "clip-path", "none"},
    {Property::mask, "mask", "none"},
    {Property::filter, "filter", "none"},
    {Property::mix_blend_mode, "mix-blend-mode", "normal"},
    {Property::vector_effect, "vector-effect", "none"},
    {Property::transform, "transform", "none"},
    {Property::transform_origin, "transform-origin", ""},
}};
constexpr std::size_t first_own = static_cast<std::size_t>(Property::opacity);

const Described* find(std::string_view name) {
  const auto at =
      std::find_if(described.begin(), described.end(), [&](const Described& d) { return d.name == name; });
  return at == described.end() ? nullptr : &*at;
}

bool is_paint(std::string_view value) {
  const auto first = value.substr(0, value.find(' '));
  return value == "none" || value == "currentColor" || value == "currentcolor" || value.starts_with("url(") ||
         value.starts_with("context-") || svg_colour(value) || svg_colour(first);
}

// A value with invalid syntax for its property is not a declaration, and another one applies.
bool valid(Property property, std::string_view value) {
  const Eigen::Vector2d viewport(1, 1);
  switch (property) {
    case Property::fill:
    case Property::stroke:
      return is_paint(value);
    case Property::color:
      return svg_colour(value).has_value();
    case Property::opacity:
    case Property::fill_opacity:
    case Property::stroke_opacity:
      return svg_opacity(value).has_value();
    case Property::stroke_miterlimit: {
      const auto number = svg_numbers(value);
      return number && number->size() == 1 && number->front() >= 1;
    }
    case Property::fill_rule:
      return value == "nonzero" || value == "evenodd";
    case Property::stroke_linecap:
      return value == "butt" || value == "round" || value == "square";
    default:
      return !value.empty();
  }
}

std::string without_comments(std::string_view text) {
  std::string out;
  while (true) {
    const auto begin = text.find("/*");
    out += text.substr(0, begin);
    if (begin == std::string_view::npos) return out;
    const auto end = text.find("*/", begin + 2);
    if (end == std::string_view::npos) return out;
    text.remove_prefix(end + 2);
  }
}

std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> out;
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    const auto end = std::min(text.find_first_of(" \t\r\n\f"), text.size());
    out.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return out;
}

}  // namespace

Style::Style() {
  for (const Described& d : described) values_[static_cast<std::size_t>(d.property)] = d.initial;
}

std::string Style::inherited() const {
  std::string out;
  for (std::size_t p = 0; p < first_own; ++p) out.append(values_[p]).append(1, '\n');
  return out;
}

std::string_view local_name(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  return name.substr(name.find(':') + 1);
}

StyleSheets::StyleSheets(const pugi::xml_document& document) {
  document.find_node([&](const pugi::xml_node& node) {
    if (local_name(node) != "style") return false;
    std::string text;
    for (const pugi::xml_node child : node.children()) text += child.value();
    texts_.push_back(without_comments(text));
    return false;
  });
  for (const std::string& text : texts_) read(text);
}

void StyleSheets::read(std::string_view text) {
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    if (text.starts_with('@')) {
      const auto end = text.find_first_of(";{");
      const bool harmless = text.starts_with("@charset") || text.starts_with("@namespace");
      complete_ &= harmless;
      if (end == std::string_view::npos || text[end] == '{') return;
      text.remove_prefix(end + 1);
      continue;
    }
    const auto open = text.find('{');
    const auto close = text.find('}', open == std::string_view::npos ? 0 : open);
    if (open == std::string_view::npos || close == std::string_view::npos) return;
    const std::size_t first = declarations_.size();
    parse(text.substr(open + 1, close - open - 1), declarations_);
    std::string_view selectors = text.substr(0, open);
    while (true) {
      const auto comma = selectors.find(',');
      if (declarations_.size() > first)
        complete_ &= add_rule(trimmed(selectors.substr(0, comma)), first, declarations_.size());
      if (comma == std::string_view::npos) break;
      selectors.remove_prefix(comma + 1);
    }
    text.remove_prefix(close + 1);
  }
}

bool StyleSheets::add_rule(std::string_view selector, std::size_t first, std::size_t last) {
  Rule rule{.element = {}, .id = {}, .classes = {}, .order = 0, .first = first, .last = last};
  if (selector.empty() || selector.find_first_of(" \t\r\n>+~[:\\") != std::string_view::npos) return false;
  int specificity = 0;
  std::string_view key = "*";
  for (std::string_view left = selector; !left.empty();) {
    const auto end = std::min(left.find_first_of(".#", 1), left.size());
    const std::string_view part = left.substr(0, end);
    left.remove_prefix(end);
    if (part == "*") continue;
    if (part.size() < 2 && (part[0] == '.' || part[0] == '#')) return false;
    if (part[0] == '.') {
      rule.classes.push_back(part.substr(1));
      specificity += 100;
    } else if (part[0] == '#') {
      rule.id = part.substr(1);
      specificity += 10000;
    } else {
      rule.element = part;
      specificity += 1;
    }
    key = part;
  }
  rule.order = std::min(specificity, 100'000);
  of_key_[key].push_back(rules_.size());
  rules_.push_back(std::move(rule));
  return true;
}

std::size_t StyleSheets::parse(std::string_view block, std::vector<Declaration>& out) {
  std::size_t count = 0;
  const auto add = [&](std::string_view name, std::string_view value, bool important) {
    const Described* d = find(name);
    if (!d || value.empty()) return;
    if (value != "inherit" && value != "initial" && !valid(d->property, value)) return;
    out.push_back({d->property, value, important});
    ++count;
  };
  while (!block.empty()) {
    const auto end = std::min(block.find(';'), block.size());
    const std::string_view one = block.substr(0, end);
    block.remove_prefix(std::min(end + 1, block.size()));
    const auto colon = one.find(':');
    if (colon == std::string_view::npos) continue;
    const std::string_view name = trimmed(one.substr(0, colon));
    std::string_view value = trimmed(one.substr(colon + 1));
    bool important = false;
    if (const auto mark = value.find('!'); mark != std::string_view::npos) {
      important = trimmed(value.substr(mark + 1)) == "important";
      value = trimmed(value.substr(0, mark));
    }
    if (name == "marker") {
      for (const char* end_name : {"marker-start", "marker-mid", "marker-end"})
        add(end_name, value, important);
    } else {
      add(name, value, important);
    }
  }
  return count;
}

Style StyleSheets::of(const pugi::xml_node& node, const Style& parent, std::size_t& work) const {
  struct Claim {
    Declaration declaration;
    int order;
    std::size_t place;  // among those of equal order, the last in the file wins
  };
  std::vector<Claim> all;
  const auto take = [&](const Declaration& d, int order, std::size_t place) {
    all.push_back({d, order + (d.important ? 10'000'000 : 0), place});
  };
  std::string_view id, classes, inlined;
  for (const pugi::xml_attribute attribute : node.attributes()) {
    const std::string_view name = attribute.name(), value = trimmed(attribute.value());
    work += 1 + value.size() / 16;
    if (name == "id") id = value;
    if (name == "class") classes = value;
    if (name == "style") inlined = value;
    const Described* d = find(name);
    // The attribute transform has a form of its own, read where it is used.
    if (!d || d->property == Property::transform) continue;
    if (value == "inherit" || valid(d->property, value)) take({d->property, value, false}, -1, 0);
  }

  const std::vector<std::string_view> of_class = words(classes);
  const auto match = [&](std::string_view key) {
    const auto at = of_key_.find(key);
    if (at == of_key_.end()) return;
    for (const std::size_t r : at->second) {
      const Rule& rule = rules_[r];
      work += 1 + rule.classes.size() * of_class.size();
      const bool has_all =
          std::all_of(rule.classes.begin(), rule.classes.end(), [&](std::string_view wanted) {
            return std::find(of_class.begin(), of_class.end(), wanted) != of_class.end();
          });
      if (!has_all || (!rule.id.empty() && rule.id != id) ||
          (!rule.element.empty() && rule.element != local_name(node)))
        continue;
      work += rule.last - rule.first;
      for (std::size_t i = rule.first; i < rule.last; ++i) take(declarations_[i], rule.order, i);
    }
  };
  if (!of_key_.empty()) {
    match("*");
    match(local_name(node));
    for (const std::string_view one : of_class) match(std::string(".").append(one));
    if (!id.empty()) match(std::string("#").append(id));
  }
  if (!inlined.empty()) {
    std::vector<Declaration> own;
    work += parse(inlined, own) + inlined.size() / 16;
    for (std::size_t i = 0; i < own.size(); ++i) take(own[i], 1'000'000, i);
  }

  std::stable_sort(all.begin(), all.end(), [](const Claim& a, const Claim& b) {
    return std::pair(a.order, a.place) < std::pair(b.order, b.place);
  });
  Style style = parent;
  const Style initial;
  for (std::size_t p = first_own; p < style.values_.size(); ++p) style.values_[p] = initial.values_[p];
  for (const Claim& w : all) {
    const auto p = static_cast<std::size_t>(w.declaration.property);
    style.values_[p] = w.declaration.value == "inherit"   ? parent.values_[p]
                       : w.declaration.value == "initial" ? initial.values_[p]
                                                          : w.declaration.value;
  }
  return style;
}

}  // namespace vacuform
