// The parts of one shape of an SVG: its curves, its fill, its line. Internal to worker/pattern.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "worker/pattern/drawing.hpp"
#include "worker/pattern/svg_style.hpp"
#include "worker/pattern/svg_values.hpp"

namespace vacuform {

// Why a drawing cannot be represented as vectors, and how to fix it. The first reason is kept.
class Refusal {
 public:
  void because(const std::string& what, const std::string& fix) {
    if (given()) return;
    what_ = what;
    fix_ = fix;
  }
  bool given() const { return !what_.empty(); }
  const std::string& what() const { return what_; }
  const std::string& fix() const { return fix_; }

 private:
  std::string what_, fix_;
};

// A length among the attributes of the node; nothing if it is absent, "auto" or rejected.
std::optional<double> length_of(const pugi::xml_node& node, const char* name, LengthOf of,
                                const Eigen::Vector2d& viewport, Refusal& refusal);

// In user units; for a path at most `most` segments and a few more. Empty for anything that is not a shape, or draws
// nothing.
std::vector<Curve> curves_of(const pugi::xml_node& node, const Eigen::Vector2d& viewport, std::size_t most,
                             Refusal& refusal);

// Nothing if nothing is painted. `opacity` is that of the element and its ancestors.
std::optional<Colour> fill_of(const Style& style, double opacity, Refusal& refusal);
// In pattern coordinates. Rejected under a transform that squeezes lines a thousandfold in one direction.
std::optional<Stroke> stroke_of(const Style& style, double opacity, const Eigen::Affine2d& to_pattern,
                                const Eigen::Vector2d& viewport, Refusal& refusal);

}  // namespace vacuform
