#include "worker/inspection/loop_figures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/inspection/shape_distance.hpp"
#include "worker/numerics/dense.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/pattern/drawn_loop.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double step_mm = 0.25;        // of the line on the flat sheet
constexpr double stretch_piece_mm = 1;  // over which a trace's stretch is taken
constexpr int radii = 180;              // rays from the centre
// In a step of at most this length, the plane gives the change of the radii to well below a micrometre on a head: the
// surface departs from the plane by a few percent of the square of the step over the radius.
constexpr double settled_mm = 0.15;

// `count` points evenly spaced by length in space along the closed line, whose points lie `at` in space.
std::vector<Vector2d> evenly(const std::vector<Vector2d>& line, const std::vector<Vector3d>& at, int count) {
  std::vector<double> until{0};
  for (std::size_t i = 0; i < at.size(); ++i)
    until.push_back(until.back() + (at[(i + 1) % at.size()] - at[i]).norm());
  std::vector<Vector2d> points;
  std::size_t piece = 0;
  for (int k = 0; k < count; ++k) {
    const double wanted = until.back() * k / count;
    while (piece + 1 < line.size() && until[piece + 1] <= wanted) ++piece;
    const double length = until[piece + 1] - until[piece];
    const double f = length > 0 ? (wanted - until[piece]) / length : 0;
    points.push_back(line[piece] + f * (line[(piece + 1) % line.size()] - line[piece]));
  }
  return points;
}

// The point that is most equally far from points (one a row; all in one plane), by the Gauss-Newton method from the
// origin, and the distances from it.
struct Centring {
  Eigen::VectorXd centre, radii;
  double mean() const { return radii.mean(); }
  double circularity() const { return (radii.array() - mean()).abs().maxCoeff() / mean(); }
};
Centring centre_of(const Eigen::MatrixXd& points) {
  Centring out{Eigen::VectorXd::Zero(points.cols()), points.rowwise().norm()};
  for (int round = 0; round < 12; ++round) {
    // r_i - way_i . move = R for all i, in move and R.
    Eigen::MatrixXd equations(points.rows(), points.cols() + 1);
    equations << points.rowwise() - out.centre.transpose(), Eigen::VectorXd::Ones(points.rows());
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      if (out.radii[i] > 0) equations.row(i).head(points.cols()) /= out.radii[i];
    // In space all directions lie in one plane, up to rounding: nothing may move across it.
    const Eigen::VectorXd move = shortest_least_squares(equations, out.radii, 1e-6).head(points.cols());
    out.centre += move;
    out.radii = (points.rowwise() - out.centre.transpose()).rowwise().norm();
    if (move.norm() < 1e-6) break;
  }
  return out;
}

// The part of a polygon to the left of the line from a to b (one pass of Sutherland and Hodgman 1974).
void cut(std::vector<Vector2d>& polygon, std::vector<Vector2d>& kept, const Vector2d& a, const Vector2d& b) {
  kept.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double side_p = cross(b - a, p - a), side_q = cross(b - a, q - a);
    if (side_p >= 0) kept.push_back(p);
    if ((side_p > 0 && side_q < 0) || (side_p < 0 && side_q > 0))
      kept.push_back(p + side_p / (side_p - side_q) * (q - p));
  }
  polygon.swap(kept);
}

// A closed line with the boxes of its parts, to find quickly which of them are near a place.
class BoxedLine {
 public:
  explicit BoxedLine(const std::vector<Vector2d>& line) : line_(line) {
    for (std::size_t begin = 0; begin < line.size(); begin += part) {
      Eigen::AlignedBox2d& box = boxes_.emplace_back();
      for (std::size_t i = begin; i <= std::min(begin + part, line.size()); ++i) box.extend(point(i));
      whole_.extend(box);
    }
  }

  const Eigen::AlignedBox2d& whole() const { return whole_; }
  bool may_meet(const Eigen::AlignedBox2d& box) const {
    return std::any_of(boxes_.begin(), boxes_.end(),
                       [&](const auto& of_part) { return of_part.intersects(box); });
  }
  // How many times the line runs around a point that is not on it, counter-clockwise: by the pieces that a ray to the
  // right crosses.
  int turns_around(const Vector2d& p) const {
    int turns = 0;
    for (std::size_t k = 0; k < boxes_.size(); ++k) {
      if (boxes_[k].max().x() < p.x() || boxes_[k].min().y() > p.y() || boxes_[k].max().y() < p.y()) continue;
      for (std::size_t i = k * part; i < std::min((k + 1) * part, line_.size()); ++i) {
        const Vector2d &a = point(i), &b = point(i + 1);
        const bool up = b.y() > a.y();
        if ((a.y() > p.y()) != (b.y() > p.y()) && (cross(b - a, p - a) > 0) == up) turns += up ? 1 : -1;
      }
    }
    return turns;
  }

 private:
  static constexpr std::size_t part = 8;  // pieces
  const Vector2d& point(std::size_t i) const { return line_[i % line_.size()]; }
  const std::vector<Vector2d>& line_;
  std::vector<Eigen::AlignedBox2d> boxes_;
  Eigen::AlignedBox2d whole_;
};

// The area of the surface inside a loop of the flat sheet: of each triangle the share of its flat area inside, exactly.
double enclosed_area(const MeasuredSheet& sheet, const std::vector<Vector2d>& line) {
  const InkedSurface& surface = sheet.surface();
  const BoxedLine boxed(line);
  double sum = 0;
  std::vector<Vector2d> polygon, kept;
  for (const Triangle& t : surface.triangles()) {
    std::array<Vector2d, 3> c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = surface.rest()[t[k]];
    const Eigen::AlignedBox2d box(c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2]));
    if (!box.intersects(boxed.whole())) continue;
    const double flat = cross(c[1] - c[0], c[2] - c[0]) / 2;
    if (!(flat > 0)) continue;
    double share = 0;
    if (boxed.may_meet(box)) {
      polygon = line;
      for (std::size_t k = 0; k < 3 && !polygon.empty(); ++k) cut(polygon, kept, c[k], c[(k + 1) % 3]);
      if (!polygon.empty()) share = std::abs(signed_area(polygon)) / flat;
    } else {
      share = std::abs(boxed.turns_around(c[0]));
    }
    if (share == 0) continue;
    const auto at = [&](std::size_t k) { return sheet.surface().inked()[t[k]]; };
    sum += share * (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2;
  }
  return sum;
}

// Sheet coordinates for a move in space within a triangle's plane.
Vector2d in_rest(const MeasuredSheet& sheet, int triangle, const Vector3d& move) {
  const Triangle& t = sheet.surface().triangles()[triangle];
  const auto rest = [&](std::size_t k) { return sheet.surface().rest()[t[k]]; };
  const auto at = [&](std::size_t k) { return sheet.surface().inked()[t[k]]; };
  Eigen::Matrix<double, 3, 2> space;
  space << at(1) - at(0), at(2) - at(0);
  Eigen::Matrix2d flat;
  flat << rest(1) - rest(0), rest(2) - rest(0);
  return flat * least_squares(space, move);
}

// The length of the straight line on the flat sheet from a to b once it is formed: an upper bound of the geodesic one.
double straight_length(const MeasuredSheet& sheet, const Vector2d& a, const Vector2d& b) {
  const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step_mm)));
  double length = 0;
  Vector3d last;
  for (int i = 0; i <= pieces; ++i) {
    const auto at = sheet.find(a + (b - a) * i / pieces);
    if (!at) return std::nan("");
    const Vector3d place = sheet.place(*at);
    if (i > 0) length += (place - last).norm();
    last = place;
  }
  return 1.01 * length + 0.1;  // the pieces cut corners
}

// The line by directions and distances along the surface, from a `centre` in the plane of the source's triangle.
std::optional<std::vector<Vector2d>> polar(const MeasuredSheet& sheet, const Geodesics& geodesics,
                                           const SheetPoint& source, const std::vector<Vector2d>& line,
                                           const Vector3d& centre) {
  const Triangle& t = sheet.surface().triangles()[source.triangle];
  const auto at = [&](std::size_t k) { return sheet.surface().inked()[t[k]]; };
  const Vector3d u = (at(1) - at(0)).normalized();
  const Vector3d v = (at(1) - at(0)).cross(at(2) - at(0)).cross(u).normalized();
  std::vector<Vector2d> out;
  for (const Vector2d& p : line) {
    const auto end = sheet.find(p);
    const auto path = end ? geodesics.to(*end) : std::nullopt;
    if (!path) return std::nullopt;
    const Vector3d way = path->length * path->start - centre;
    out.emplace_back(way.dot(u), way.dot(v));
  }
  return out;
}

double worst_stretch(const std::vector<Vector2d>& line, const std::vector<Vector3d>& at) {
  const std::size_t n = line.size();
  double worst = 0;
  for (std::size_t i = 0; i < n; ++i) {
    double flat = 0, formed = 0;
    for (std::size_t k = i; flat < stretch_piece_mm && k < i + n; ++k) {
      flat += (line[(k + 1) % n] - line[k % n]).norm();
      formed += (at[(k + 1) % n] - at[k % n]).norm();
    }
    if (flat > 0) worst = std::max(worst, formed / flat);
  }
  return worst;
}

}  // namespace

std::unique_ptr<Geodesics, MeasuredSheet::GiveBack> MeasuredSheet::paths() const {
  const std::lock_guard lock(mutex_);
  if (idle_.empty()) {
    idle_.reserve(made_ + 1);
    idle_.push_back(std::make_unique<Geodesics>(surface().path_mesh()));
    ++made_;
  }
  Geodesics* const lent = idle_.back().release();
  idle_.pop_back();
  return {lent, GiveBack{this}};
}

void MeasuredSheet::take_back(Geodesics* paths) const {
  const std::lock_guard lock(mutex_);
  idle_.emplace_back(paths);
}

std::vector<Vector2d> densified(const std::vector<Vector2d>& line, double step, bool closed) {
  std::vector<Vector2d> out;
  for (std::size_t i = 0; i + (closed ? 0 : 1) < line.size(); ++i) {
    const Vector2d &a = line[i], &b = line[(i + 1) % line.size()];
    const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step)));
    for (int k = 0; k < pieces; ++k) out.push_back(a + (b - a) * k / pieces);
  }
  if (!closed && !line.empty()) out.push_back(line.back());
  return out;
}

std::optional<LoopFigures> measure_loop(const MeasuredSheet& sheet, const std::vector<Vector2d>& given,
                                        const Vector2d& near, CoilKeep keep) {
  const std::vector<Vector2d> line = densified(given, step_mm, true);
  if (line.size() < 3) return std::nullopt;
  LoopFigures out;
  out.on_head = true;
  for (const Vector2d& p : line) {
    const auto at = sheet.find(p);
    if (!at) return std::nullopt;
    out.outline.push_back(sheet.place(*at));
    out.on_head &= sheet.on_chart(*at);
  }
  std::vector<SheetPoint> ends;
  for (const Vector2d& p : evenly(line, out.outline, radii)) {
    const auto at = sheet.find(p);
    if (!at) return std::nullopt;
    ends.push_back(*at);
  }

  out.centre_rest = near;
  double reach = 0;
  for (std::size_t i = 0; i < line.size(); i += 4)
    reach = std::max(reach, straight_length(sheet, near, line[i]));
  if (!std::isfinite(reach)) return std::nullopt;
  const auto geodesics = sheet.paths();
  for (int round = 0; round < 12; ++round) {
    const auto source = sheet.find(out.centre_rest);
    if (!source) return std::nullopt;
    geodesics->begin_at(*source, reach);
    Eigen::MatrixXd ways(radii, 3);
    for (int i = 0; i < radii; ++i) {
      const auto path = geodesics->to(ends[i]);
      if (!path) return std::nullopt;
      ways.row(i) = path->length * path->start;
    }
    const Centring centring = centre_of(ways);
    const Vector3d move = centring.centre;
    out.centre_rest += in_rest(sheet, source->triangle, move);
    out.diameter_mm = 2 * centring.mean();
    out.circularity = centring.circularity();
    out.centre = sheet.place(*source) + move;
    reach += move.norm();
    if (move.norm() >= settled_mm) continue;
    const auto shape = polar(sheet, *geodesics, *source, line, move);
    if (!shape) return std::nullopt;
    out.shape = *shape;
    break;
  }
  out.area_mm2 = enclosed_area(sheet, line);
  if (keep == CoilKeep::area) out.shape = true_to_area(std::move(out.shape), out.area_mm2);
  out.worst_stretch = worst_stretch(line, out.outline);
  return out;
}

PlaneLoopFigures measure_plane_loop(const std::vector<Vector2d>& given) {
  PlaneLoopFigures out;
  const std::vector<Vector2d> line = densified(given, step_mm, true);
  std::vector<Vector3d> at;
  for (const Vector2d& p : line) at.emplace_back(p.x(), p.y(), 0), out.centre += p;
  out.centre /= static_cast<double>(std::max<std::size_t>(1, line.size()));
  const std::vector<Vector2d> ends = evenly(line, at, radii);
  Eigen::MatrixXd points(radii, 2);
  for (int i = 0; i < radii; ++i) points.row(i) = ends[i] - out.centre;
  const Centring centring = centre_of(points);
  out.centre += centring.centre;
  out.diameter_mm = 2 * centring.mean();
  out.circularity = centring.circularity();
  out.area_mm2 = lobes_area(given);
  return out;
}

double geodesic_distance(const MeasuredSheet& sheet, const Vector2d& a, const Vector2d& b) {
  const auto from = sheet.find(a), to = sheet.find(b);
  const double bound = straight_length(sheet, a, b);
  if (!from || !to || !std::isfinite(bound)) return std::nan("");
  const auto geodesics = sheet.paths();
  geodesics->begin_at(*from, *to, bound);
  const auto path = geodesics->to(*to);
  return path ? path->length : std::nan("");
}

}  // namespace vacuform
