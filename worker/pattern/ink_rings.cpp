#include "worker/pattern/ink_rings.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <optional>

#include "worker/numerics/dense.hpp"
#include "worker/numerics/plane.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

constexpr double least_radius = 4, most_radius = 100, cell_mm = 0.5;
constexpr double least_arc = 0.25;   // of each circle, seen as an outline
constexpr double least_inked = 0.9;  // of a ring's middle line and of two beside it
constexpr double aimed_mm = 1;       // how near to a centre the normals of its circles pass
constexpr std::size_t most_points = 8000;
constexpr int most_rings = 128, most_misses = 24;

// A point of an outline, with the direction towards its ink, and the length of outline that it stands for.
struct BorderPoint {
  Vector2d at, inward;
  double mm;
};

std::vector<BorderPoint> border_points(const std::vector<Curve>& outlines) {
  std::size_t count = 0;
  for (const Curve& curve : outlines) count += curve.points.size() / 3;
  const std::size_t step = 1 + count / most_points;
  constexpr std::size_t reach = 4;  // points to either side that tell the direction
  std::vector<BorderPoint> out;
  for (const Curve& curve : outlines) {
    const std::size_t n = curve.points.size() / 3;
    if (n < 4 * reach) continue;
    const auto at = [&](std::size_t i) -> const Vector2d& { return curve.points[3 * (i % n)]; };
    for (std::size_t i = 0; i < n; i += step) {
      const Vector2d way = at(i + reach) - at(i + n - reach);
      if (!(way.norm() > 0)) continue;
      out.push_back({at(i), Vector2d(-way.y(), way.x()).normalized(),
                     static_cast<double>(step) * way.norm() / (2.0 * reach)});
    }
  }
  return out;
}

// Votes of outline points for the centres of circles through them, in cells. Banned cells are ignored.
class Votes {
 public:
  explicit Votes(const std::vector<BorderPoint>& points) {
    Eigen::AlignedBox2d box;
    for (const BorderPoint& p : points) box.extend(p.at);
    low_ = box.min();
    columns_ = static_cast<int>(box.sizes().x() / cell_mm) + 1;
    rows_ = static_cast<int>(box.sizes().y() / cell_mm) + 1;
    banned_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0);
  }

  void count(const std::vector<BorderPoint>& points) {
    sums_.assign(banned_.size(), 0.0f);
    for (const BorderPoint& p : points)
      for (const double side : {1.0, -1.0})
        for (double r = least_radius; r < most_radius; r += cell_mm) {
          const Vector2d c = (p.at + side * r * p.inward - low_) / cell_mm;
          if (!(c.minCoeff() >= 0 && c.x() < columns_ && c.y() < rows_)) break;
          sums_[index(static_cast<int>(c.x()), static_cast<int>(c.y()))] += static_cast<float>(p.mm);
        }
  }

  std::optional<Vector2d> best() const {
    float most = 0;
    Vector2d out(0, 0);
    for (int y = 1; y + 1 < rows_; ++y)
      for (int x = 1; x + 1 < columns_; ++x) {
        if (banned_[index(x, y)]) continue;
        float sum = 0;
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) sum += sums_[index(x + dx, y + dy)];
        if (sum > most) most = sum, out = low_ + cell_mm * Vector2d(x + 0.5, y + 0.5);
      }
    // Even a ring of the least radius gives more.
    return most > least_arc * 4 * M_PI * least_radius ? std::optional(out) : std::nullopt;
  }

  void ban(const Vector2d& centre) {
    const Vector2d c = (centre - low_) / cell_mm;
    const int x0 = static_cast<int>(c.x()), y0 = static_cast<int>(c.y());
    for (int y = std::max(0, y0 - 3); y <= std::min(rows_ - 1, y0 + 3); ++y)
      for (int x = std::max(0, x0 - 3); x <= std::min(columns_ - 1, x0 + 3); ++x) banned_[index(x, y)] = 1;
  }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
  }
  Vector2d low_;
  int columns_ = 0, rows_ = 0;
  std::vector<float> sums_;
  std::vector<char> banned_;
};

// Two circles about one centre; the outer has its ink inside, the inner outside.
struct Circles {
  Vector2d centre;
  double outer = 0, inner = 0;

  // 1 on the outer, -1 on the inner, 0 on neither.
  int side_of(const BorderPoint& p, double within) const {
    const Vector2d to = centre - p.at;
    const double d = to.norm();
    if (std::abs(cross(p.inward, to)) > aimed_mm) return 0;
    const bool inside = p.inward.dot(to) > 0;
    if (std::abs(d - (inside ? outer : inner)) > within) return 0;
    return inside ? 1 : -1;
  }
};

std::optional<Circles> circles_about(const Vector2d& centre, const std::vector<BorderPoint>& points) {
  constexpr double bin = 0.5;
  constexpr std::size_t bins = static_cast<std::size_t>(most_radius / bin) + 2;
  std::array<std::vector<double>, 2> arcs{std::vector<double>(bins, 0), std::vector<double>(bins, 0)};
  for (const BorderPoint& p : points) {
    const Vector2d to = centre - p.at;
    const double d = to.norm();
    if (d < least_radius / 2 || d >= most_radius) continue;
    if (std::abs(cross(p.inward, to)) > aimed_mm) continue;
    arcs[p.inward.dot(to) > 0 ? 0 : 1][d / bin] += p.mm;
  }
  const auto peak = [&](const std::vector<double>& arc, std::size_t below) {
    std::size_t best = 0;
    double most = 0;
    for (std::size_t i = 1; i + 1 < below; ++i) {
      const double share =
          (arc[i - 1] + arc[i] + arc[i + 1]) / (2 * M_PI * bin * (static_cast<double>(i) + 0.5));
      if (share > most) most = share, best = i;
    }
    return most >= least_arc ? best : std::size_t{0};
  };
  const std::size_t outer = peak(arcs[0], bins), inner = outer > 0 ? peak(arcs[1], outer + 1) : 0;
  if (inner == 0) return std::nullopt;
  return Circles{centre, bin * (static_cast<double>(outer) + 0.5), bin * (static_cast<double>(inner) + 0.5)};
}

// Gauss-Newton least squares over the points on the two circles, within smaller and smaller distances.
void fit(Circles& circles, const std::vector<BorderPoint>& points) {
  for (const double within : {1.0, 0.6, 0.4, 0.25, 0.25}) {
    Eigen::Matrix4d normal = 1e-9 * Eigen::Matrix4d::Identity();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (const BorderPoint& p : points) {
      const int side = circles.side_of(p, within);
      if (side == 0) continue;
      const Vector2d from = p.at - circles.centre;
      const double d = from.norm();
      const Eigen::Vector4d row(-from.x() / d, -from.y() / d, side > 0 ? -1 : 0, side > 0 ? 0 : -1);
      normal += p.mm * row * row.transpose();
      right -= p.mm * (d - (side > 0 ? circles.outer : circles.inner)) * row;
    }
    const Eigen::Vector4d step = solve_symmetric(normal, right);
    if (!step.allFinite() || step.head<2>().norm() > 2) return;
    circles.centre += step.head<2>();
    circles.outer += step[2];
    circles.inner += step[3];
  }
}

bool is_ring(const Circles& circles, const std::vector<BorderPoint>& points,
             const std::function<bool(const Vector2d&)>& inked) {
  const double width = circles.outer - circles.inner;
  if (!(circles.inner >= least_radius / 2) || !(width > 0.3) || width > circles.inner) return false;
  double outer = 0, inner = 0;
  for (const BorderPoint& p : points)
    if (const int side = circles.side_of(p, 0.25); side != 0) (side > 0 ? outer : inner) += p.mm;
  if (outer < least_arc * 2 * M_PI * circles.outer || inner < least_arc * 2 * M_PI * circles.inner)
    return false;
  constexpr int samples = 360;
  int found = 0;
  for (int i = 0; i < samples; ++i) {
    const Vector2d away(std::cos(2 * M_PI * i / samples), std::sin(2 * M_PI * i / samples));
    for (const double across : {0.25, 0.5, 0.75})
      found += inked(circles.centre + (circles.inner + across * width) * away);
  }
  return found >= least_inked * 3 * samples;
}

}  // namespace

std::vector<InkRing> find_rings(const std::vector<Curve>& outlines,
                                const std::function<bool(const Vector2d&)>& inked) {
  std::vector<InkRing> rings;
  std::vector<BorderPoint> points = border_points(outlines);
  if (points.empty()) return rings;
  Votes votes(points);
  votes.count(points);
  for (int misses = 0; misses < most_misses && rings.size() < most_rings;) {
    const auto centre = votes.best();
    if (!centre) break;
    votes.ban(*centre);
    auto circles = circles_about(*centre, points);
    if (circles) fit(*circles, points);
    if (!circles || !is_ring(*circles, points, inked)) {
      ++misses;
      continue;
    }
    misses = 0;
    rings.push_back(
        {circles->centre, (circles->outer + circles->inner) / 2, (circles->outer - circles->inner) / 2});
    std::erase_if(points, [&](const BorderPoint& p) { return circles->side_of(p, 0.25) != 0; });
    votes.count(points);
  }
  return rings;
}

}  // namespace vacuform
