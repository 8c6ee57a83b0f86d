// The properties of SVG elements by the cascade of CSS 2.1: presentation attributes, style sheets of simple selectors,
// the style attribute, !important, inheritance. Internal to worker/pattern.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace vacuform {

enum class Property {
  fill,
  fill_opacity,
  fill_rule,
  stroke,
  stroke_width,
  stroke_opacity,
  stroke_linecap,
  stroke_linejoin,
  stroke_miterlimit,
  stroke_dasharray,
  stroke_dashoffset,
  color,
  visibility,
  paint_order,
  marker_start,
  marker_mid,
  marker_end,
  // Not inherited from here on.
  opacity,
  display,
  clip_path,
  mask,
  filter,
  mix_blend_mode,
  vector_effect,
  transform,
  transform_origin,
  count
};

// The computed value of each property, as text, without white space around it.
class Style {
 public:
  Style();  // the initial values
  std::string_view operator[](Property p) const { return values_[static_cast<std::size_t>(p)]; }
  std::string inherited() const;  // the same for styles that give an element's children the same

 private:
  friend class StyleSheets;
  std::array<std::string_view, static_cast<std::size_t>(Property::count)> values_;
};

// The name without its namespace's prefix.
std::string_view local_name(const pugi::xml_node& node);

// Texts are referred to, not copied: the document must outlive all styles.
class StyleSheets {
 public:
  // Reads every <style> of the document. Supported selectors are names, classes, ids, "*", and these joined without
  // white space. Any other selector, an @import or an @media makes complete() false.
  explicit StyleSheets(const pugi::xml_document& document);
  bool complete() const { return complete_; }

  // The style of an element whose parent has the style `parent`. `work` grows by the number of rules examined.
  Style of(const pugi::xml_node& node, const Style& parent, std::size_t& work) const;

 private:
  struct Declaration {
    Property property;
    std::string_view value;
    bool important;
  };
  struct Rule {
    std::string_view element, id;  // empty: any
    std::vector<std::string_view> classes;
    int order;  // by specificity, then place in the file
    std::size_t first, last;
  };
  void read(std::string_view text);
  bool add_rule(std::string_view selector, std::size_t first, std::size_t last);
  static std::size_t parse(std::string_view block, std::vector<Declaration>& out);

  bool complete_ = true;
  std::vector<std::string> texts_;  // the sheets, without comments
  std::vector<Declaration> declarations_;
  std::vector<Rule> rules_;
  std::map<std::string_view, std::vector<std::size_t>>
      of_key_;  // rules by their ".class", "#id", name or "*"
};

}  // namespace vacuform
