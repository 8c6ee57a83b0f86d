#include "worker/placement/length_errors.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <set>

#include "api/base/decimal.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double piece_mm = 10, step_mm = 1, square_mm_side = 5;
constexpr double far_off = 0.1;

// Where patches map points of the pattern or of the flat sheet to, the first that holds a point.
class Domains {
 public:
  enum class By { pattern, sheet };

  void add(const Patch& patch, By by = By::pattern) {
    domains_.push_back(
        {&patch, std::make_unique<PlaneLocator>(patch.triangles, by == By::pattern ? patch.uv : patch.rest)});
  }

  struct Found {
    Vector3d place;
    const Patch* patch;
    int triangle;
  };
  std::optional<Found> find(const Vector2d& point) const {
    for (const Domain& domain : domains_)
      if (const auto at = domain.locator->find(point))
        return Found{interpolate(domain.patch->triangles, *at, domain.patch->inked), domain.patch,
                     at->triangle};
    return std::nullopt;
  }

 private:
  struct Domain {
    const Patch* patch;
    std::unique_ptr<PlaneLocator> locator;
  };
  std::vector<Domain> domains_;
};

// By how much a right angle may be off under the map of a triangle, degrees.
double angle_error(const Domains::Found& at) {
  const Triangle& t = at.patch->triangles[index(at.triangle)];
  const auto uv = [&](std::size_t k) -> const Vector2d& { return at.patch->uv[index(t[k])]; };
  const auto place = [&](std::size_t k) -> const Vector3d& { return at.patch->inked[index(t[k])]; };
  Eigen::Matrix2d flat;
  flat << uv(1) - uv(0), uv(2) - uv(0);
  if (!(std::abs(flat.determinant()) > 0)) return 0;
  Eigen::Matrix<double, 3, 2> space;
  space << place(1) - place(0), place(2) - place(0);
  const Eigen::Matrix<double, 3, 2> J = space * flat.inverse();
  const double sum = J.squaredNorm(), product = Vector3d(J.col(0)).cross(Vector3d(J.col(1))).norm();
  const double both = std::sqrt(std::max(0.0, sum + 2 * product)),
               apart = std::sqrt(std::max(0.0, sum - 2 * product));
  return both > 0 ? 2 * std::atan(apart / both) * 180 / M_PI : 0;
}

// Measures lines piece by piece.
class Pieces {
 public:
  // `size` formed millimetres for one that is drawn.
  void measure(const std::vector<Vector2d>& drawn, const std::vector<Vector2d>& laid, const Domains& domains,
               double size, int element) {
    std::optional<Domains::Found> before;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      const auto at = domains.find(laid[i]);
      const bool joined = at && before && at->patch == before->patch;
      if (joined) add(size, drawn[i - 1], drawn[i], (at->place - before->place).norm(), *at);
      if (!joined || drawn_ >= piece_mm) finish(element);
      before = at;
    }
    finish(element);
  }

  std::vector<LengthErrors::Piece> found;

 private:
  void add(double size, const Vector2d& from, const Vector2d& to, double formed_mm,
           const Domains::Found& at) {
    const double drawn_mm = size * (to - from).norm();
    if (line_.empty()) line_.push_back(from);
    line_.push_back(to);
    drawn_ += drawn_mm;
    formed_ += formed_mm;
    angle_ += drawn_mm * angle_error(at);
    if (!middle_ || drawn_ <= piece_mm / 2) middle_ = at.place;
  }

  void finish(int element) {
    if (drawn_ > 0.5 * step_mm && middle_)
      found.push_back({formed_ / drawn_ - 1, angle_ / drawn_, drawn_, element, std::move(line_), *middle_});
    drawn_ = formed_ = angle_ = 0;
    middle_.reset();
    line_.clear();
  }

  double drawn_ = 0, formed_ = 0, angle_ = 0;
  std::optional<Vector3d> middle_;
  std::vector<Vector2d> line_;
};

std::vector<Vector2d> points_of(const Curve& curve) {
  std::vector<Vector2d> line;
  for (const CurvePoint& p : flatten(curve, {.tolerance_mm = 0.02, .turn = 0.2, .longest_mm = step_mm}))
    line.push_back(p.at);
  return line;
}

void add_lines(const Drawing& drawing, const Placement& placement, const std::vector<TiedPoints>& tied,
               double scale, const Domains& charts, Pieces& out) {
  Domains sheet;
  for (const Segment& chart : placement.charts) sheet.add(chart.patch, Domains::By::sheet);
  std::set<std::array<std::size_t, 3>> measured;
  for (const TiedPoints& line : tied) {
    out.measure(line.drawn, line.rest, sheet, scale, static_cast<int>(line.element));
    measured.insert({line.element, line.shape, line.curve});
  }
  for (std::size_t e = 0; e < drawing.elements.size(); ++e) {
    const Element& element = drawing.elements[e];
    const auto placed =
        std::find_if(placement.elements.begin(), placement.elements.end(),
                     [&](const PlacedElement& p) { return p.element == static_cast<int>(e); });
    const bool own = placed != placement.elements.end();
    if (!own && !placement.elements.empty() && !element.id.empty()) continue;  // it is not printed
    Domains of_element;
    if (own) of_element.add(placed->patch);
    // How far resist reaches is no length that anything depends on.
    for (std::size_t s = 0; s < element.shapes.size(); ++s)
      for (std::size_t c = 0; c < element.shapes[s].curves.size(); ++c) {
        const bool resist = element.shapes[s].layer.value_or(DrawnLayer()).step == PrintStep::resist;
        if (resist || measured.contains({e, s, c})) continue;
        const std::vector<Vector2d> line = points_of(element.shapes[s].curves[c]);
        out.measure(line, line, own ? of_element : charts, own ? placed->size : scale, static_cast<int>(e));
      }
  }
}

// Squares with ink, along u and v.
void add_squares(const Pattern& pattern, const Domains& charts, double scale, Pieces& out) {
  constexpr double least_ink = 0.02;
  const Vector2d half = pattern.size_mm() / 2;
  const double side = std::max(square_mm_side, std::sqrt(pattern.size_mm().prod() / 1e5));
  for (double v = -half.y() + side / 2; v < half.y(); v += side)
    for (double u = -half.x() + side / 2; u < half.x(); u += side) {
      const Vector2d at(u, v);
      if (pattern.sample(at, side).coverage() < least_ink) continue;
      for (const Vector2d& way : {Vector2d(side / 2, 0), Vector2d(0, side / 2)}) {
        const std::vector<Vector2d> line = {at - way, at - way / 2, at, at + way / 2, at + way};
        out.measure(line, line, charts, scale, -1);
      }
    }
}

}  // namespace

LengthErrors length_errors(const Drawing* drawing, const Pattern& pattern, const Placement& placement,
                           const std::vector<TiedPoints>& tied, double scale) {
  Domains charts;
  for (const Segment& chart : placement.charts) charts.add(chart.patch);
  Pieces pieces;
  if (drawing)
    add_lines(*drawing, placement, tied, scale, charts, pieces);
  else
    add_squares(pattern, charts, scale, pieces);
  LengthErrors out;
  out.pieces = std::move(pieces.found);
  if (out.pieces.empty()) return out;
  std::stable_sort(out.pieces.begin(), out.pieces.end(),
                   [](const auto& a, const auto& b) { return std::abs(a.error) > std::abs(b.error); });
  double all = 0, above = 0;
  for (const auto& piece : out.pieces) {
    all += piece.drawn_mm, out.mean += piece.drawn_mm * std::abs(piece.error);
    out.worst_angle_deg = std::max(out.worst_angle_deg, piece.angle_deg);
  }
  out.mean /= all;
  out.worst = std::abs(out.pieces.front().error);
  for (const auto& piece : out.pieces) {
    out.p95 = std::abs(piece.error);
    if ((above += piece.drawn_mm) >= 0.05 * all) break;
  }
  return out;
}

std::optional<Warning> length_warning(const LengthErrors& errors, const Drawing* drawing, double limit) {
  if (!(errors.worst > limit)) return std::nullopt;
  double all = 0, off = 0;
  std::vector<std::string> ids;
  Warning warning =
      errors.worst > std::max(limit, far_off) ? Warning{"length-far-off", ""} : Warning{"length-off", ""};
  for (const auto& piece : errors.pieces) {
    all += piece.drawn_mm;
    if (std::abs(piece.error) <= limit) continue;
    off += piece.drawn_mm;
    if (warning.marks.size() < Warning::most_marks)
      warning.marks.push_back({{piece.place.x(), piece.place.y(), piece.place.z()}, piece.drawn_mm});
    const std::string& id = drawing && piece.element >= 0 ? drawing->elements[index(piece.element)].id : "";
    const std::string name = id.empty() ? "ink of no element" : id;
    if (std::find(ids.begin(), ids.end(), name) == ids.end()) ids.push_back(name);
  }
  const double worst = errors.pieces.front().error;
  const double share = off / all;
  warning.text = (share < 0.005 ? "Less than 1 %" : in_percent(share)) +
                 " of the drawing's lines come out longer or shorter than drawn by more than " +
                 in_percent(limit, 1) + ", at worst " + in_percent(errors.worst, 1) +
                 (worst > 0 ? " longer." : " shorter.");
  warning.figure = Warning::Figure{100 * errors.worst, "%", 100 * limit};
  if (drawing) {
    constexpr std::size_t most = 8;
    for (std::size_t i = 0; i < std::min(most, ids.size()); ++i)
      warning.place += (i > 0 ? ", " : "") + ids[i];
    if (ids.size() > most) warning.place += " and " + std::to_string(ids.size() - most) + " more";
  }
  return warning;
}

}  // namespace vacuform
