#include "worker/scan/undercuts.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "api/base/decimal.hpp"
#include "worker/scan/topology.hpp"

namespace vacuform {
namespace {
constexpr double most_layers = 50;        // crossed by a ray on average; heads have two or three
constexpr double most_crossings = 2.5e6;  // about 3 s; a head has a quarter of a million

// The area of the turned mesh seen from above, with every layer counted. Divided by the spacing squared, it is the
// number of surfaces that the rays will cross.
double area_from_above(const TriangleMesh& mesh, const Eigen::Matrix3d& turn) {
  const Eigen::Vector3d up = turn.row(2);
  double area = 0;
  for (const auto& t : mesh.triangles) area += std::abs(up.dot(area_vector(mesh, t)));
  return area;
}
}  // namespace

Eigen::Vector2d CoveredSpace::place(int column) const {
  const int x = column % nx_, y = column / nx_;
  return {origin_.x() + (x + 0.5) * spacing_, origin_.y() + (y + 0.5) * spacing_};
}

Result<CoveredSpace> CoveredSpace::measure(const TriangleMesh& mesh, std::shared_ptr<const RayCaster> caster,
                                           const Eigen::Matrix3d& turn, double floor, double spacing,
                                           const ScanProgress& progress) {
  CoveredSpace space;
  Box box{Eigen::Vector3d::Constant(HUGE_VAL), Eigen::Vector3d::Constant(-HUGE_VAL)};
  for (const auto& p : mesh.vertices) {
    const Eigen::Vector3d q = turn * p;
    box.low = box.low.cwiseMin(q), box.high = box.high.cwiseMax(q);
  }
  const double area = area_from_above(mesh, turn);
  if (area > most_layers * box.size().x() * box.size().y())
    return fail(
        Code::unusable_scan, "the scan's surface lies in layers, more than fifty above each other", "",
        "keep its outer surface alone (in a mesh editor: remove inner and double faces) and export it again");
  spacing = std::max(spacing, std::sqrt(area / most_crossings));
  space.back_ = turn.transpose();
  space.floor_ = floor;
  space.ceiling_ = box.high.z();
  space.spacing_ = spacing;
  // Adds a ring of empty columns, so that every depth can be measured from an open column.
  space.nx_ = 2 * static_cast<int>(std::ceil(box.size().x() / (2 * spacing)) + 1);
  space.ny_ = 2 * static_cast<int>(std::ceil(box.size().y() / (2 * spacing)) + 1);
  space.origin_ = box.centre().head<2>() - spacing / 2 * Eigen::Vector2d(space.nx_, space.ny_);
  const int columns = space.nx_ * space.ny_;
  space.top_.assign(static_cast<std::size_t>(columns), -HUGE_VAL);

  space.caster_ = std::move(caster);
  const Eigen::Vector3d down = -space.back_.col(2);
  const double step = 1e-5 * box.size().norm();  // beyond the rays' own error
  for (int column = 0; column < columns; ++column) {
    if (column % 1024 == 0) VACUFORM_CHECK(progress.tick());
    const Eigen::Vector2d xy = space.place(column);
    double z = box.high.z() + spacing, opened = 0;
    int inside = 0, last = -1;  // inside of how many overlapping pieces
    bool met = false;
    while (z > floor) {
      const double reach = z - floor + spacing;
      const auto hit =
          space.caster_->first_hit(space.back_ * Eigen::Vector3d(xy.x(), xy.y(), z), reach * down);
      if (!hit) break;
      const double at = z - hit->t * reach;
      z = at - step;
      if (hit->triangle == last) continue;
      last = hit->triangle;
      const double up = -down.dot(area_vector(mesh, mesh.triangles[hit->triangle]));
      if (up > 0 && inside++ == 0) {
        if (!met) space.top_[column] = at;
        if (met && opened - at > space.least_height()) space.spans_.push_back({column, at, opened});
        met = true;
      } else if (up < 0 && inside > 0 && --inside == 0) {
        opened = at;
      }
    }
    if (met && inside == 0 && opened - floor > space.least_height())
      space.spans_.push_back({column, floor, opened});
  }
  space.build_pyramid();
  return space;
}

void CoveredSpace::build_pyramid() {
  const std::vector<double>* below = &top_;
  for (int bx = nx_, by = ny_; bx > 1 || by > 1;) {
    const int cx = (bx + 1) / 2, cy = (by + 1) / 2;
    Level level{cx, cy,
                std::vector<double>(static_cast<std::size_t>(cx) * static_cast<std::size_t>(cy), HUGE_VAL)};
    for (int y = 0; y < by; ++y)
      for (int x = 0; x < bx; ++x) {
        auto& lowest = level.lowest[static_cast<std::size_t>(y / 2) * static_cast<std::size_t>(cx) +
                                    static_cast<std::size_t>(x / 2)];
        lowest = std::min(lowest, (*below)[static_cast<std::size_t>(y) * static_cast<std::size_t>(bx) +
                                           static_cast<std::size_t>(x)]);
      }
    pyramid_.push_back(std::move(level));
    below = &pyramid_.back().lowest;
    bx = cx, by = cy;
  }
}

struct CoveredSpace::Search {
  int x, y;     // the column asked about
  double z;     // open: its top lies below
  double best;  // squared distance in columns
};

// Descends into the blocks that hold an open column nearer than the best so far, the nearest block first.
void CoveredSpace::search(Search& s, std::size_t level, int x, int y) const {
  const int nx = level == 0 ? nx_ : pyramid_[level - 1].nx, ny = level == 0 ? ny_ : pyramid_[level - 1].ny;
  if (x >= nx || y >= ny) return;
  const auto& lowest = level == 0 ? top_ : pyramid_[level - 1].lowest;
  if (lowest[static_cast<std::size_t>(y) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(x)] >= s.z)
    return;
  const int side = 1 << level;
  const double dx = std::max({0, x * side - s.x, s.x - (x * side + side - 1)});
  const double dy = std::max({0, y * side - s.y, s.y - (y * side + side - 1)});
  const double squared = dx * dx + dy * dy;
  if (squared >= s.best) return;
  if (level == 0) {
    s.best = squared;
    return;
  }
  const int right = s.x >= x * side + side / 2, upper = s.y >= y * side + side / 2;
  for (const int k : {0, 1, 2, 3})
    search(s, level - 1, 2 * x + (right ^ (k & 1)), 2 * y + (upper ^ (k >> 1)));
}

double CoveredSpace::depth_at(int column, double z, double enough) const {
  const double farthest = enough / spacing_ + 2;
  Search s{column % nx_, column / nx_, z, farthest * farthest};
  search(s, pyramid_.size(), 0, 0);
  return std::max(0.0, std::sqrt(s.best) - 0.5) * spacing_;
}

std::vector<CoveredSpace::Span> CoveredSpace::above(double floor) const {
  std::vector<Span> spans;
  for (Span span : spans_) {
    span.low = std::max(span.low, floor);
    if (span.high - span.low > least_height()) spans.push_back(span);
  }
  return spans;
}

// Spans of neighbouring columns that overlap in height belong together. Each pocket lists its spans in their
// order.
std::vector<std::vector<int>> CoveredSpace::pockets(const std::vector<Span>& spans) const {
  std::vector<int> parent(spans.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) {
      auto& p = parent[i];
      i = p = parent[p];
    }
    return i;
  };
  std::vector<int> first(top_.size() + 1, 0);  // span of each column
  for (const auto& span : spans) ++first[static_cast<std::size_t>(span.column) + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  for (int i = 0; i < static_cast<int>(spans.size()); ++i) {
    const auto& a = spans[i];
    for (const int neighbour :
         {a.column + 1, a.column + nx_})  // the outer ring holds no spans: no wrapping around
      for (int j = first[neighbour]; j < first[static_cast<std::size_t>(neighbour) + 1]; ++j) {
        const auto& b = spans[j];
        if (a.low <= b.high && b.low <= a.high) parent[root(j)] = root(i);
      }
  }
  std::vector<int> number(spans.size(), -1);
  std::vector<std::vector<int>> pockets;
  for (int i = 0; i < static_cast<int>(spans.size()); ++i) {
    int& n = number[root(i)];
    if (n < 0) {
      n = static_cast<int>(pockets.size());
      pockets.emplace_back();
    }
    pockets[n].push_back(i);
  }
  return pockets;
}

// Whether a span can be entered from the open air of the column beside it. A ray checks that no wall thinner than the
// grid stands between the two.
bool CoveredSpace::reaches_air(const std::vector<Span>& spans, const std::vector<int>& pocket) const {
  for (const int i : pocket) {
    const auto& span = spans[i];
    for (const int beside : {span.column - 1, span.column + 1, span.column - nx_, span.column + nx_}) {
      const double low = std::max(span.low, top_[beside]);
      if (low >= span.high) continue;
      const Eigen::Vector2d from = place(span.column), to = place(beside);
      const double z = (low + span.high) / 2;
      if (!caster_->first_hit(back_ * Eigen::Vector3d(from.x(), from.y(), z),
                              back_ * Eigen::Vector3d(to.x() - from.x(), to.y() - from.y(), 0)))
        return true;
    }
  }
  return false;
}

std::vector<Undercut> CoveredSpace::undercuts(double floor) const {
  const auto spans = above(floor);
  std::vector<Undercut> found;
  for (const auto& pocket : pockets(spans)) {
    if (!reaches_air(spans, pocket)) continue;
    Undercut undercut{Eigen::Vector3d::Zero(), -1, 0};
    int last_column = -1;
    for (const int i : pocket) {
      const auto& span = spans[i];
      const double depth = depth_at(span.column, span.low + least_height() / 2, HUGE_VAL);
      if (depth > undercut.depth_mm) {
        const Eigen::Vector2d xy = place(span.column);
        undercut.place = {xy.x(), xy.y(), span.low};
        undercut.depth_mm = depth;
      }
      if (last_column != span.column) undercut.area_mm2 += spacing_ * spacing_;
      last_column = span.column;
    }
    found.push_back(undercut);
  }
  std::stable_sort(found.begin(), found.end(), [](const Undercut& a, const Undercut& b) {
    if (a.depth_mm != b.depth_mm) return a.depth_mm > b.depth_mm;
    return a.area_mm2 > b.area_mm2;
  });
  return found;
}

bool CoveredSpace::has_undercut(double floor, double depth, double area) const {
  const auto spans = above(floor);
  for (const auto& pocket : pockets(spans)) {
    if (static_cast<double>(pocket.size()) * spacing_ * spacing_ <= area) continue;
    for (const int i : pocket) {
      const auto& span = spans[i];
      if (depth_at(span.column, span.low + least_height() / 2, depth) <= depth) continue;
      if (reaches_air(spans, pocket)) return true;
      break;
    }
  }
  return false;
}

double CoveredSpace::lowest_cut(double depth, double area) const {
  if (!has_undercut(floor_, depth, area)) return floor_;
  double low = floor_, high = ceiling_;  // a higher cut leaves less of every pocket
  while (high - low > 0.02 * spacing_) {
    const double middle = (low + high) / 2;
    (has_undercut(middle, depth, area) ? low : high) = middle;
  }
  return high;
}

double CoveredSpace::domed_share(double floor, double reach) const {
  const int d = std::max(1, static_cast<int>(std::lround(reach / spacing_)));
  const double slack = 0.02 * d * spacing_;
  std::int64_t seen = 0, domed = 0;
  for (int y = d; y + d < ny_; ++y)
    for (int x = d; x + d < nx_; ++x) {
      const auto top = [&](int i, int j) {
        return top_[static_cast<std::size_t>(j) * static_cast<std::size_t>(nx_) +
                    static_cast<std::size_t>(i)];
      };
      const double here = top(x, y), west = top(x - d, y), east = top(x + d, y), south = top(x, y - d),
                   north = top(x, y + d);
      const double least = std::min({here, west, east, south, north});
      if (least == -HUGE_VAL) continue;
      ++seen;
      domed += least >= floor && here + slack >= (west + east) / 2 && here + slack >= (south + north) / 2;
    }
  return seen > 0 ? static_cast<double>(domed) / static_cast<double>(seen) : 0;
}

Warning undercut_warning(const std::vector<Undercut>& undercuts) {
  const Undercut& worst = undercuts.front();
  Warning warning{"undercut",
                  (undercuts.size() == 1
                       ? "The mold has an undercut that the sheet cannot reach or that locks the part; it"
                       : "The mold has " + std::to_string(undercuts.size()) +
                             " undercuts that the sheet cannot reach or that lock the part; the deepest") +
                      " reaches " + in_mm(worst.depth_mm) +
                      " under what overhangs it at x = " + in_mm(worst.place.x()) +
                      ", y = " + in_mm(worst.place.y()) + ", z = " + in_mm(worst.place.z())};
  warning.figure = Warning::Figure{worst.depth_mm, "mm"};
  for (std::size_t i = 0; i < std::min(undercuts.size(), Warning::most_marks); ++i) {
    const Undercut& u = undercuts[i];
    warning.marks.push_back({{u.place.x(), u.place.y(), u.place.z()}, u.depth_mm});
  }
  return warning;
}

}  // namespace vacuform
