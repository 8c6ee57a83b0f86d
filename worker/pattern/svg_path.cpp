#include "worker/pattern/svg_path.hpp"

#include <algorithm>
#include <cmath>

#include "worker/numerics/plane.hpp"
#include "worker/pattern/svg_values.hpp"

namespace vacuform {

using Eigen::Vector2d;

void CurveBuilder::begin() {
  if (open_) return;
  curves_.push_back({.points = {at_}, .closed = false});
  start_ = at_;
  open_ = true;
}

void CurveBuilder::move_to(const Vector2d& p) {
  at_ = start_ = p;
  open_ = false;
}

void CurveBuilder::line_to(const Vector2d& p) { cubic_to(at_ + (p - at_) / 3, p - (p - at_) / 3, p); }

void CurveBuilder::cubic_to(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
  begin();
  auto& points = curves_.back().points;
  points.insert(points.end(), {a, b, p});
  at_ = p;
  ++segments_;
}

void CurveBuilder::quadratic_to(const Vector2d& a, const Vector2d& p) {
  cubic_to(at_ + (a - at_) * 2 / 3, p + (a - p) * 2 / 3, p);
}

void CurveBuilder::arc_to(const Vector2d& given_radii, double turned_deg, bool large, bool sweep,
                          const Vector2d& p) {
  Vector2d radii = given_radii.cwiseAbs();
  if (p == at_) return;
  if (!(radii.minCoeff() > 0)) return line_to(p);
  const Eigen::Rotation2Dd turn(turned_deg * M_PI / 180);
  // In coordinates where the ellipse is a unit circle and the middle of the chord is the origin.
  const Vector2d half = (turn.inverse() * ((at_ - p) / 2)).cwiseQuotient(radii);
  const double far = half.norm();
  if (far > 1) radii *= far;
  const Vector2d h = far > 1 ? Vector2d(half / far) : half;
  const double across = std::sqrt(std::max(0.0, 1 / std::max(h.squaredNorm(), 1e-300) - 1));
  const Vector2d c = (large == sweep ? -1 : 1) * across * Vector2d(h.y(), -h.x());
  const Vector2d from = h - c, to = -h - c;
  double sweep_angle = std::atan2(cross(from, to), from.dot(to));
  if (sweep && sweep_angle < 0) sweep_angle += 2 * M_PI;
  if (!sweep && sweep_angle > 0) sweep_angle -= 2 * M_PI;
  const Vector2d centre = (at_ + p) / 2 + turn * c.cwiseProduct(radii);
  const int pieces = std::max(1, static_cast<int>(std::ceil(std::abs(sweep_angle) / (M_PI / 2) - 1e-9)));
  const double step = sweep_angle / pieces, first = std::atan2(from.y(), from.x());
  const double handle = 4.0 / 3 * std::tan(step / 4);
  const auto on = [&](const Vector2d& unit) -> Vector2d { return centre + turn * unit.cwiseProduct(radii); };
  for (int i = 0; i < pieces; ++i) {
    const double a = first + i * step, b = a + step;
    const Vector2d u(std::cos(a), std::sin(a)), v(std::cos(b), std::sin(b));
    cubic_to(on(u + handle * Vector2d(-u.y(), u.x())), on(v - handle * Vector2d(-v.y(), v.x())),
             i + 1 == pieces ? p : on(v));
  }
}

void CurveBuilder::close() {
  if (!open_ && !curves_.empty() && curves_.back().closed && curves_.back().points.front() == at_) return;
  begin();
  if (at_ != start_ || curves_.back().points.size() == 1) line_to(start_);
  curves_.back().closed = true;
  at_ = start_;
  open_ = false;
}

std::vector<Curve> CurveBuilder::finish() { return std::move(curves_); }

namespace {

// Reads path data, one command at a time.
class PathReader {
 public:
  explicit PathReader(std::string_view d) : cursor_(d) {}

  std::vector<Curve> read(std::size_t most) {
    char command = cursor_.letter();
    if (command != 'M' && command != 'm') return {};
    while (command && builder_.segments() < most) {
      if (command == 'Z' || command == 'z') {
        builder_.close();
        command_before_ = 'Z';
        if (!(command = cursor_.letter())) break;
        continue;
      }
      if (!one(command)) break;
      command_before_ = upper(command);
      if (const char next = cursor_.letter())
        command = next;
      else if (cursor_.at_end())
        break;
      else if (command == 'M')
        command = 'L';
      else if (command == 'm')
        command = 'l';
    }
    return builder_.finish();
  }

 private:
  static char upper(char c) { return c >= 'a' ? static_cast<char>(c - 'a' + 'A') : c; }

  bool point(bool relative, Vector2d& p) {
    const auto x = cursor_.number();
    const auto y = x ? cursor_.number() : x;
    if (!y) return false;
    p = Vector2d(*x, *y) + (relative ? builder_.at() : Vector2d(0, 0));
    return true;
  }
  // The last control point, mirrored in the current point.
  Vector2d mirrored(char smooth, char full) const {
    const bool follows = command_before_ == smooth || command_before_ == full;
    return follows ? Vector2d(2 * builder_.at() - control_) : builder_.at();
  }

  bool one(char command) {
    const bool relative = command >= 'a';
    Vector2d a, b, p;
    switch (upper(command)) {
      case 'M':
        if (!point(relative, p)) return false;
        builder_.move_to(p);
        return true;
      case 'L':
        if (!point(relative, p)) return false;
        builder_.line_to(p);
        return true;
      case 'H':
      case 'V': {
        const auto value = cursor_.number();
        if (!value) return false;
        p = builder_.at();
        double& moved = p[upper(command) == 'H' ? 0 : 1];
        moved = *value + (relative ? moved : 0);
        builder_.line_to(p);
        return true;
      }
      case 'C':
      case 'S':
        if (upper(command) == 'S')
          a = mirrored('S', 'C');
        else if (!point(relative, a))
          return false;
        if (!point(relative, b) || !point(relative, p)) return false;
        builder_.cubic_to(a, b, p);
        control_ = b;
        return true;
      case 'Q':
      case 'T':
        if (upper(command) == 'T')
          a = mirrored('T', 'Q');
        else if (!point(relative, a))
          return false;
        if (!point(relative, p)) return false;
        builder_.quadratic_to(a, p);
        control_ = a;
        return true;
      case 'A':
        return arc(relative);
      default:
        return false;
    }
  }

  bool arc(bool relative) {
    const auto rx = cursor_.number(), ry = rx ? cursor_.number() : rx, turned = ry ? cursor_.number() : ry;
    const auto large = turned ? cursor_.flag() : std::nullopt, sweep = large ? cursor_.flag() : large;
    Vector2d p;
    if (!sweep || !point(relative, p)) return false;
    builder_.arc_to({*rx, *ry}, *turned, *large, *sweep, p);
    return true;
  }

  NumberCursor cursor_;
  CurveBuilder builder_;
  char command_before_ = 0;
  Vector2d control_{0, 0};
};

}  // namespace

std::vector<Curve> svg_path(std::string_view d, std::size_t most) { return PathReader(d).read(most); }

std::vector<Curve> svg_ellipse(const Vector2d& centre, const Vector2d& radii) {
  CurveBuilder builder;
  const Vector2d x(radii.x(), 0), y(0, radii.y());
  builder.move_to(centre + x);
  for (const Vector2d& p : {y, Vector2d(-x), Vector2d(-y), x})
    builder.arc_to(radii, 0, false, true, centre + p);
  builder.close();
  return builder.finish();
}

std::vector<Curve> svg_rectangle(const Vector2d& corner, const Vector2d& size, const Vector2d& given_radii) {
  const Vector2d radii = given_radii.cwiseMin(size / 2), far = corner + size;
  CurveBuilder builder;
  const bool round = radii.minCoeff() > 0;
  const auto side = [&](const Vector2d& to, const Vector2d& around) {
    if (builder.at() != to) builder.line_to(to);
    if (round) builder.arc_to(radii, 0, false, true, around);
  };
  const Vector2d r = round ? radii : Vector2d(0, 0);
  builder.move_to({corner.x() + r.x(), corner.y()});
  side({far.x() - r.x(), corner.y()}, {far.x(), corner.y() + r.y()});
  side({far.x(), far.y() - r.y()}, {far.x() - r.x(), far.y()});
  side({corner.x() + r.x(), far.y()}, {corner.x(), far.y() - r.y()});
  side({corner.x(), corner.y() + r.y()}, {corner.x() + r.x(), corner.y()});
  builder.close();
  return builder.finish();
}

std::vector<Curve> svg_polyline(const std::vector<double>& coordinates, bool closed) {
  CurveBuilder builder;
  for (std::size_t i = 0; i + 1 < coordinates.size(); i += 2) {
    const Vector2d p(coordinates[i], coordinates[i + 1]);
    i == 0 ? builder.move_to(p) : builder.line_to(p);
  }
  if (closed && coordinates.size() >= 4) builder.close();
  return builder.finish();
}

}  // namespace vacuform
