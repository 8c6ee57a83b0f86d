// The outlines of SVG's shapes as cubic Beziers. Internal to worker/pattern.
#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

// Appends segments one after another, in user units. Elliptical arcs lie within 3e-4 of their radius.
class CurveBuilder {
 public:
  void move_to(const Eigen::Vector2d& p);
  void line_to(const Eigen::Vector2d& p);
  void cubic_to(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p);
  void quadratic_to(const Eigen::Vector2d& a, const Eigen::Vector2d& p);
  // SVG 1.1, appendix F.6.
  void arc_to(const Eigen::Vector2d& radii, double turned_deg, bool large, bool sweep,
              const Eigen::Vector2d& p);
  void close();  // the next segment starts where this curve did

  const Eigen::Vector2d& at() const { return at_; }
  std::size_t segments() const { return segments_; }
  std::vector<Curve> finish();  // curves of at least one segment

 private:
  void begin();
  Eigen::Vector2d at_{0, 0}, start_{0, 0};
  bool open_ = false;
  std::size_t segments_ = 0;
  std::vector<Curve> curves_;
};

// Path data. What precedes an error is kept, as SVG 1.1 (appendix F.2) asks. Stops at `most` segments or a few more.
std::vector<Curve> svg_path(std::string_view d, std::size_t most);

// The basic shapes, with the start and the direction that SVG specifies; dashes show both.
std::vector<Curve> svg_ellipse(const Eigen::Vector2d& centre, const Eigen::Vector2d& radii);
std::vector<Curve> svg_rectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size,
                                 const Eigen::Vector2d& radii);
std::vector<Curve> svg_polyline(const std::vector<double>& coordinates, bool closed);

}  // namespace vacuform
