#include "worker/pattern/ink_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/numerics/disjoint_sets.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/pattern/pieces.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

constexpr float half_covered = 0.5f;
constexpr double smoothed_mm = 0.25;         // width of the smoothed edge beside a ring
constexpr std::size_t most_outlines = 1000;  // of a part that is searched for rings

// Whether it has two holes or more, together larger than the ink.
bool is_entangled(const Shape& shape) {
  double holes = 0, outside = 0;
  std::size_t count = 0;
  for (const Curve& curve : shape.curves) {
    double twice = 0;
    for (std::size_t i = 0; i + 3 < curve.points.size(); i += 3)
      twice += cross(curve.points[i], curve.points[i + 3]);
    (twice < 0 ? holes : outside) += std::abs(twice) / 2;
    count += twice < 0 ? 1 : 0;
  }
  return count >= 2 && holes > outside - holes;
}

}  // namespace

InkParts::InkParts(const Pattern& pattern) {
  drawing_.size_mm = pattern.size_mm();
  step_ = std::max(0.1, std::sqrt(drawing_.size_mm.prod() / 1e6));
  // A margin of one point on each side, so that outlines close.
  columns_ = static_cast<int>(std::ceil(drawing_.size_mm.x() / step_)) + 2;
  rows_ = static_cast<int>(std::ceil(drawing_.size_mm.y() / step_)) + 2;
  const std::vector<float> ink = coverage(pattern);
  label(ink);
  sort(pieces(outline(ink)));
  spread();
}

Vector2d InkParts::uv(double x, double y) const {
  return {(x - 0.5) * step_ - drawing_.size_mm.x() / 2, drawing_.size_mm.y() / 2 - (y - 0.5) * step_};
}

std::vector<float> InkParts::coverage(const Pattern& pattern) const {
  const int channels = pattern.grayscale() ? 1 : 4;
  std::vector<float> line(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(channels));
  std::vector<float> ink(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0.0f);
  for (int y = 1; y + 1 < rows_; ++y) {
    pattern.sample_line(uv(0, y), {step_, 0}, columns_, step_, line.data());
    for (int x = 1; x + 1 < columns_; ++x) {
      const float* p = line.data() + static_cast<std::ptrdiff_t>(x) * channels;
      ink[index(x, y)] = channels == 1 ? p[0] : p[3] - (0.2126f * p[0] + 0.7152f * p[1] + 0.0722f * p[2]);
    }
  }
  return ink;
}

void InkParts::label(const std::vector<float>& ink) {
  DisjointSets sets(ink.size());
  for (int y = 1; y < rows_; ++y)
    for (int x = 1; x + 1 < columns_; ++x) {
      if (ink[index(x, y)] < half_covered) continue;
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}})
        if (const auto beside = index(x + dx, y + dy); ink[beside] >= half_covered)
          sets.join(static_cast<int>(index(x, y)), static_cast<int>(beside));
    }
  std::vector<std::int32_t> points(ink.size(), 0), part(ink.size(), -1);
  for (std::size_t i = 0; i < ink.size(); ++i)
    if (ink[i] >= half_covered) ++points[sets.root(static_cast<int>(i))];
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i] * step_ * step_ > 1) part[i] = part_count_++;
  labels_.assign(ink.size(), -1);
  for (std::size_t i = 0; i < ink.size(); ++i)
    if (ink[i] >= half_covered) labels_[i] = part[sets.root(static_cast<int>(i))];
}

// Marching squares (Lorensen, Cline 1987, in the plane), ink on the left. Where opposite corners of a cell have ink
// they are joined, as in the labels.
std::vector<Shape> InkParts::outline(const std::vector<float>& ink) {
  // Edges of the grid: 2 i from point i to the right, 2 i + 1 from it downwards.
  std::vector<std::int32_t> next(2 * ink.size(), -1);
  for (int y = 0; y + 1 < rows_; ++y)
    for (int x = 0; x + 1 < columns_; ++x) {
      // Counter-clockwise from the lower left, and the edges that follow each corner.
      const std::array<std::size_t, 4> corner{index(x, y + 1), index(x + 1, y + 1), index(x + 1, y),
                                              index(x, y)};
      const std::array<std::size_t, 4> edge{2 * corner[0], 2 * corner[2] + 1, 2 * corner[3],
                                            2 * corner[3] + 1};
      for (std::size_t k = 0; k < 4; ++k) {
        if (ink[corner[k]] < half_covered || ink[corner[(k + 1) % 4]] >= half_covered) continue;
        std::size_t other = (k + 1) % 4;
        while ((ink[corner[other]] >= half_covered) == (ink[corner[(other + 1) % 4]] >= half_covered))
          other = (other + 1) % 4;
        next[edge[k]] = static_cast<std::int32_t>(edge[other]);
      }
    }
  const auto crossing = [&](std::size_t e) {
    const std::size_t a = e / 2, b = e % 2 == 0 ? a + 1 : a + static_cast<std::size_t>(columns_);
    const double f = (half_covered - ink[a]) / (ink[b] - ink[a]);
    const auto columns = static_cast<std::size_t>(columns_);
    const std::size_t column = a % columns, row = a / columns;
    const auto x = static_cast<double>(column), y = static_cast<double>(row);
    return e % 2 == 0 ? uv(x + f, y) : uv(x, y + f);
  };
  std::vector<Shape> out(static_cast<std::size_t>(part_count_), Shape{{}, Colour{}, true, {}});
  for (std::size_t first = 0; first < next.size(); ++first) {
    if (next[first] < 0) continue;
    const std::size_t a = first / 2, b = first % 2 == 0 ? a + 1 : a + static_cast<std::size_t>(columns_);
    const std::int32_t part = std::max(labels_[a], labels_[b]);
    Curve curve{.points = {crossing(first)}, .closed = true};
    for (std::size_t e = first; next[e] >= 0;) {
      const auto to = static_cast<std::size_t>(next[e]);
      next[e] = -1;
      e = to;
      const Vector2d from = curve.points.back(), p = e == first ? curve.points.front() : crossing(e);
      curve.points.insert(curve.points.end(), {from + (p - from) / 3, p - (p - from) / 3, p});
    }
    if (part >= 0) out[part].curves.push_back(std::move(curve));
  }
  return out;
}

// Ink beside a part is its smoothed edge.
void InkParts::spread() {
  std::vector<std::size_t> front, then;
  for (std::size_t i = 0; i < labels_.size(); ++i)
    if (labels_[i] >= 0) front.push_back(i);
  const int reach = static_cast<int>(std::ceil(1 / step_));
  for (int round = 0; round < reach; ++round, std::swap(front, then)) {
    then.clear();
    for (const std::size_t i : front) {
      const int x = static_cast<int>(i % static_cast<std::size_t>(columns_)),
                y = static_cast<int>(i / static_cast<std::size_t>(columns_));
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        if (x + dx < 0 || x + dx >= columns_ || y + dy < 0 || y + dy >= rows_) continue;
        const std::size_t beside = index(x + dx, y + dy);
        if (labels_[beside] >= 0) continue;
        labels_[beside] = labels_[i];
        then.push_back(beside);
      }
    }
  }
}

// The pieces: parts, and the rings of parts that consist of several.
std::vector<PaintedShape> InkParts::pieces(std::vector<Shape> parts) {
  std::vector<PaintedShape> out;
  for (Shape& shape : parts) {
    const auto part = static_cast<int>(parts_.size());
    std::vector<InkRing> rings;
    if (shape.curves.size() >= 3 && shape.curves.size() <= most_outlines)
      rings = find_rings(shape.curves, [&](const Vector2d& at) { return part_at(at) == part; });
    parts_.push_back({static_cast<int>(out.size()), 1});
    if (rings.size() < 2) {
      entangled_ |= is_entangled(shape);
      rings_.emplace_back();
      out.push_back({std::move(shape)});
      continue;
    }
    std::sort(rings.begin(), rings.end(), [](const InkRing& a, const InkRing& b) {
      return std::pair(-a.centre.y(), a.centre.x()) < std::pair(-b.centre.y(), b.centre.x());
    });
    parts_.back().count = static_cast<int>(rings.size());
    for (const InkRing& ring : rings) {
      Shape of_ring{{}, shape.fill, true, {}};
      for (const double r : {ring.radius + ring.half_width, ring.radius - ring.half_width})
        of_ring.curves.push_back(circle(ring.centre, r));
      out.push_back({std::move(of_ring)});
      rings_.emplace_back(ring);
    }
  }
  return out;
}

void InkParts::sort(std::vector<PaintedShape> pieces) {
  element_of_.assign(pieces.size(), -1);
  for (SortedElement& found : sort_into_elements(pieces, {})) {
    Element& element = drawing_.elements.emplace_back();
    element.id = std::move(found.id), element.centre = found.centre, element.loop = std::move(found.loop);
    for (const int i : found.pieces) {
      element_of_[i] = static_cast<int>(drawing_.elements.size()) - 1;
      element.shapes.push_back(std::move(pieces[i].shape));
    }
  }
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (element_of_[i] < 0) drawing_.loose_ink_mm2 += ink_mm2(pieces[i].shape);
}

bool InkParts::holds(int element, const Vector2d& uv) const {
  const int at = part_at(uv);
  if (at < 0) return element < 0;
  const Part& part = parts_[at];
  bool in_any = false;
  for (int i = part.first; i < part.first + part.count; ++i) {
    const auto& ring = rings_[i];
    if (element_of_[i] < 0 || (ring && !ring->holds(uv, smoothed_mm))) continue;
    if (element_of_[i] == element) return true;
    in_any = true;
  }
  return element < 0 && !in_any;
}

int InkParts::part_at(const Vector2d& at) const {
  const double x = (at.x() + drawing_.size_mm.x() / 2) / step_ + 1,
               y = (drawing_.size_mm.y() / 2 - at.y()) / step_ + 1;
  if (!(x >= 0 && y >= 0 && x < columns_ && y < rows_)) return -1;
  return labels_[index(static_cast<int>(x), static_cast<int>(y))];
}

std::optional<InkParts> parts_to_place(const Pattern& pattern, PatternPlacement placement,
                                       std::vector<Warning>& warnings) {
  if (placement == PatternPlacement::chart || placement == PatternPlacement::segments) return std::nullopt;
  InkParts parts(pattern);
  const auto& elements = parts.drawing().elements;
  if (parts.entangled())
    warnings.push_back(
        {"ink-hangs-together",
         "Loops of the picture touch or overlap, and could not be separated as circles: each connected "
         "group is laid as one element."});
  if (elements.empty()) return std::nullopt;
  return parts;
}

}  // namespace vacuform
