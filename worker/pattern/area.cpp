// Strokes are assembled from pieces that each turn clockwise: half of the line's width along each chord, a wedge at
// each outer corner, a cap at each end. Neighbouring pieces are joined into one ring where they continue each other.
// Where the curve bends more tightly than the stroke is wide, the piece would turn over and is a ring of its own. The
// stroke is what any piece covers, by the non-zero rule.
#include "worker/pattern/area.hpp"

#include <algorithm>
#include <cmath>

#include "worker/numerics/plane.hpp"
#include "worker/pattern/clipping.hpp"
#include "worker/pattern/curve.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

Vector2d left_of(const Vector2d& t) { return {-t.y(), t.x()}; }

// The pieces of one stroke.
class Stroker {
 public:
  Stroker(const Stroke& stroke, double tolerance)
      : stroke_(stroke), half_(stroke.width_mm / 2), step_(turn_for(half_, tolerance)) {}

  static double turn_for(double radius, double tolerance) {
    return 2 * std::acos(std::max(0.0, 1 - tolerance / std::max(radius, tolerance)));
  }
  double turn() const { return step_; }

  void open_line(const std::vector<CurvePoint>& line) {
    if (line.size() < 2) return dot(line);
    rings_.emplace_back();
    side(line);
    cap(line.back().at, line.back().before);
    const auto back = reversed(line);
    side(back);
    cap(back.back().at, back.back().before);
  }

  void closed_line(const std::vector<CurvePoint>& line) {
    if (line.size() < 2) return dot(line);
    for (const auto& way : {line, reversed(line)}) {
      rings_.emplace_back();
      side(way);
      corner(way.back());
    }
  }

  const std::vector<Ring>& rings() const { return rings_; }

 private:
  static std::vector<CurvePoint> reversed(const std::vector<CurvePoint>& line) {
    std::vector<CurvePoint> out(line.rbegin(), line.rend());
    for (CurvePoint& p : out) {
      const Vector2d before = p.before;
      p.before = -p.after;
      p.after = -before;
    }
    return out;
  }

  // The outline to the left of the line, without the corners at its ends.
  void side(const std::vector<CurvePoint>& line) {
    Vector2d edge = line.front().at + half_ * left_of(line.front().after);
    add(edge);
    for (std::size_t i = 1; i < line.size(); ++i) {
      const Vector2d &from = line[i - 1].at, &to = line[i].at;
      const Vector2d next = to + half_ * left_of(line[i].before);
      if ((next - edge).dot(to - from) <= 0) {
        alone(from, to, next);
        alone(from, next, edge);
        add(from);
        add(to);
      }
      add(next);
      edge = to + half_ * left_of(line[i].after);
      if (i + 1 < line.size()) corner(line[i]);
    }
  }

  // Joins the outline along the direction before the corner to that along the direction after it.
  void corner(const CurvePoint& p) {
    const double turned = cross(p.before, p.after), along = p.before.dot(p.after);
    const Vector2d next = p.at + half_ * left_of(p.after);
    if (along > 0.999999) return add(next);
    if (turned > 0) {
      add(p.at);  // the inner side
    } else if (stroke_.join == LineJoin::round) {
      arc(p.at, half_ * left_of(p.before), -std::atan2(std::abs(turned), along));
    } else if (stroke_.join == LineJoin::miter && 1 + along > 1e-9 &&
               2 <= stroke_.miter_limit * stroke_.miter_limit * (1 + along)) {
      add(p.at + half_ * (left_of(p.before) + left_of(p.after)) / (1 + along));
    }
    add(next);
  }

  void cap(const Vector2d& end, const Vector2d& ahead) {
    const Vector2d n = half_ * left_of(ahead);
    if (stroke_.cap == LineCap::square) {
      add(end + n + half_ * ahead);
      add(end - n + half_ * ahead);
    } else if (stroke_.cap == LineCap::round) {
      arc(end, n, -M_PI);
    }
  }

  void dot(const std::vector<CurvePoint>& line) {
    if (line.empty() || stroke_.cap == LineCap::butt) return;
    rings_.emplace_back();
    const Vector2d& p = line.front().at;
    if (stroke_.cap == LineCap::round) return arc(p, {half_, 0}, -2 * M_PI);
    for (const Vector2d& d : {Vector2d(-1, -1), Vector2d(-1, 1), Vector2d(1, 1), Vector2d(1, -1)})
      add(p + half_ * d);
  }

  // The arc from `from` to `from` turned by `angle`, without its two ends.
  void arc(const Vector2d& centre, const Vector2d& from, double angle) {
    const int pieces = std::max(1, static_cast<int>(std::ceil(std::abs(angle) / step_)));
    for (int i = 1; i < pieces; ++i) add(centre + Eigen::Rotation2Dd(angle * i / pieces) * from);
  }

  void add(const Vector2d& p) { rings_.back().push_back(p); }
  void alone(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    Ring triangle{a, b, c};
    if (cross(b - a, c - a) > 0) std::swap(triangle[1], triangle[2]);
    // Before the ring that is being made, which stays the last.
    rings_.insert(rings_.end() - 1, std::move(triangle));
  }

  const Stroke& stroke_;
  const double half_, step_;
  std::vector<Ring> rings_;
};

CurvePoint between(const CurvePoint& a, const CurvePoint& b, double along) {
  const double f = (along - a.along) / (b.along - a.along);
  Vector2d tangent = (1 - f) * a.after + f * b.before;
  if (tangent.norm() < 1e-9) tangent = b.at - a.at;
  tangent.normalize();
  return {a.at + f * (b.at - a.at), tangent, tangent, along};
}

// The line from `from` to `to`, measured along it.
std::vector<CurvePoint> piece(const std::vector<CurvePoint>& line, double from, double to) {
  const auto behind = [&](double along) {
    return std::upper_bound(line.begin(), line.end(), along,
                            [](double x, const CurvePoint& p) { return x < p.along; });
  };
  std::vector<CurvePoint> out;
  auto at = behind(from);
  if (at == line.end()) return out;
  if (at != line.begin()) out.push_back(between(*(at - 1), *at, from));
  for (; at != line.end() && at->along < to; ++at) out.push_back(*at);
  if (at != line.end() && at != line.begin()) out.push_back(between(*(at - 1), *at, to));
  return out;
}

void dash(Stroker& stroker, const Stroke& stroke, const std::vector<CurvePoint>& line, bool closed) {
  const double length = line.back().along;
  double period = 0;
  for (const double d : stroke.dashes_mm) period += d;
  double at = -std::fmod(stroke.dash_offset_mm, period);
  if (at > 0) at -= period;
  std::vector<std::vector<CurvePoint>> pieces;
  bool from_start = false, to_end = false;
  for (std::size_t k = 0; at < length; k = (k + 1) % stroke.dashes_mm.size()) {
    const double end = at + stroke.dashes_mm[k];
    if (k % 2 == 0 && end > 0) {
      auto one = piece(line, std::max(at, 0.0), std::min(end, length));
      if (!one.empty()) {
        from_start |= at <= 0;
        to_end = end >= length;
        pieces.push_back(std::move(one));
      }
    }
    at = end;
  }
  if (pieces.empty()) return;
  if (closed && from_start && to_end && pieces.size() > 1) {
    auto& last = pieces.back();
    last.back().after = pieces.front().front().after;
    last.insert(last.end(), pieces.front().begin() + 1, pieces.front().end());
    pieces.erase(pieces.begin());
  }
  for (const auto& one : pieces) stroker.open_line(one);
}

double largest_stretch(const Eigen::Matrix2d& map) {
  const double half = map.squaredNorm() / 2, det = map.determinant();
  return std::sqrt(half + std::sqrt(std::max(0.0, half * half - det * det)));
}

// In the pen's own coordinates, and from there to the pattern.
Area stretched_area(const std::vector<Curve>& curves, Stroke stroke, double tolerance_mm) {
  const Eigen::Matrix2d pen = stroke.pen, back = pen.inverse();
  stroke.pen.setIdentity();
  std::vector<Curve> own = curves;
  for (Curve& curve : own)
    for (Vector2d& p : curve.points) p = back * p;
  Area out = stroke_area(own, stroke, tolerance_mm / largest_stretch(pen));
  for (Ring& ring : out)
    for (Vector2d& p : ring) p = pen * p;
  return out;
}

}  // namespace

Area fill_area(const std::vector<Curve>& curves, bool even_odd, double tolerance_mm) {
  std::vector<Ring> rings;
  const Fineness fineness{.tolerance_mm = tolerance_mm};
  for (const Curve& curve : curves) {
    Ring ring;
    for (const CurvePoint& p : flatten(curve, fineness)) ring.push_back(p.at);
    rings.push_back(std::move(ring));
  }
  return covered_by(rings, even_odd ? FillRule::even_odd : FillRule::non_zero);
}

double widest_mm(const Stroke& stroke) { return stroke.width_mm * largest_stretch(stroke.pen); }

Area stroke_area(const std::vector<Curve>& curves, const Stroke& stroke, double tolerance_mm) {
  if (!(stroke.width_mm > 0)) return {};
  if (stroke.pen != Eigen::Matrix2d::Identity()) return stretched_area(curves, stroke, tolerance_mm);
  Stroker stroker(stroke, tolerance_mm);
  Fineness fineness{.tolerance_mm = tolerance_mm};
  fineness.turn = std::min(fineness.turn, stroker.turn());
  for (const Curve& curve : curves) {
    const auto line = flatten(curve, fineness);
    if (line.size() > 1 && !stroke.dashes_mm.empty())
      dash(stroker, stroke, line, curve.closed);
    else if (curve.closed)
      stroker.closed_line(line);
    else
      stroker.open_line(line);
  }
  return union_of(stroker.rings());
}

Area intersection(const Area& a, const Area& b) { return shared_by(a, b); }

Area difference(const Area& a, const Area& b) { return remainder_of(a, b); }

Area union_of(const std::vector<Ring>& rings) { return covered_by(rings, FillRule::non_zero); }

double square_mm(const Area& area) {
  double twice = 0;
  for (const Ring& ring : area)
    for (std::size_t i = 0; i < ring.size(); ++i) twice += cross(ring[i], ring[(i + 1) % ring.size()]);
  return twice / 2;
}

}  // namespace vacuform
