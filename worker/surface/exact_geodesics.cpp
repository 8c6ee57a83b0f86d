#include "worker/surface/exact_geodesics.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include "worker/numerics/plane.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/nearest_point.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double rounding_mm = 1e-9, rounding_angle = 1e-9;
// A source on an edge or a vertex is moved by this share into the triangle, so that all triangles around it are seen.
// The shares differ, so that no straight line through the vertices of an even grid passes through the source: rounding
// would decide there on which side it lies, and a sector could be lost.
const Vector3d beside = 1e-8 * Vector3d(1, 0.6180339887, 0.3247179572);

// Where straight lines begin: the source itself, or a vertex at which paths bend.
struct PseudoSource {
  double before = 0;        // mm from the source to here
  Vector3d start{0, 0, 0};  // in which the path to here leaves the source
  int vertex = -1;          // -1: the source itself
};

// What a pseudo-source sees through one side of a triangle: everything between two rays. In the plane of the
// pseudo-source, which is its origin; the triangles on the way are unfolded into it.
struct Window {
  int side = 0;  // of the triangle that is entered
  int pseudo_source = 0;
  Vector2d a, b;         // the side's ends, a on the left
  Vector2d left, right;  // on the side, where the rays come through
  int parent = -1;  // the window that this one was seen through; -1: seen from its pseudo-source's triangle
  int next = -1;    // of the windows on the same side
};

// Counter-clockwise from one direction to another.
double angle_between(const Vector2d& from, const Vector2d& to) {
  return std::atan2(cross(from, to), from.dot(to));
}

// The distance from the origin to the piece from p to q.
double nearest(const Vector2d& p, const Vector2d& q) {
  const Vector2d way = q - p;
  const double square = way.squaredNorm();
  const double f = square > 0 ? std::clamp(-p.dot(way) / square, 0.0, 1.0) : 0;
  return (p + f * way).norm();
}

// Where the ray from the origin through `through` meets the piece from p to q.
Vector2d met(const Vector2d& through, const Vector2d& p, const Vector2d& q) {
  const double at_p = cross(through, p), at_q = cross(through, q);
  const double f = at_p != at_q ? std::clamp(at_p / (at_p - at_q), 0.0, 1.0) : 0;
  return p + f * (q - p);
}

}  // namespace

struct Geodesics::State {
  explicit State(const PathMesh& of)
      : mesh(of), heads(3 * of.triangles().size(), -1), seen(heads.size()), known(of.places().size()) {}

  const PathMesh& mesh;
  double reach = 0;
  std::optional<Vector3d> target;  // in space: the only one
  int source_triangle = 0;
  Vector3d source{0, 0, 0}, axis{0, 0, 0}, across{0, 0, 0};  // the source's plane
  Vector2d asked{0, 0};  // in it: the source as it was given, which may lie on an edge or a vertex
  std::vector<PseudoSource> pseudo_sources;
  std::vector<Window> windows;

  std::vector<int> heads;  // per side: the last of its windows
  // Of the windows through a side that see the corner opposite, the nearest, and where on the side it looks through (0:
  // at its start, 1: at its end).
  struct Seen {
    double mm = infinite, through = 0;
  };
  std::vector<Seen> seen;
  struct Known {
    double mm = infinite;  // the shortest path to the vertex met so far
    Vector3d start{0, 0, 0};
    // Where it comes from: the triangle opposite the side `from`, and the angle there from its side to the next corner,
    // radians.
    int from = -1;
    double at = 0;
    int pseudo_source = 0,
        window = -1;  // the start and the last window of its last straight piece; -1: none
  };
  std::vector<Known> known;
  std::vector<int> touched_sides, touched_vertices;

  // Windows by number, vertices at which paths bend as -1 - number. The nearest comes first.
  struct Next {
    double mm;
    int what;
    bool operator>(const Next& other) const { return mm != other.mm ? mm > other.mm : what > other.what; }
  };
  std::priority_queue<Next, std::vector<Next>, std::greater<>> queue;

  double known_mm(int vertex) const { return known[index(vertex)].mm; }

  void clear() {
    for (const int s : touched_sides) heads[index(s)] = -1, seen[index(s)] = {};
    for (const int v : touched_vertices) known[index(v)] = {};
    touched_sides.clear(), touched_vertices.clear(), pseudo_sources.clear(), windows.clear();
    queue = {};
  }

  Vector3d start_of(int pseudo_source, const Vector2d& to) const {
    if (pseudo_source > 0) return pseudo_sources[index(pseudo_source)].start;
    const double length = to.norm();
    if (length == 0) return Vector3d::Zero();
    return (to.x() * axis + to.y() * across) / length;
  }

  // Whether a path of this length on an edge cannot reach the only target; for a vertex both ends are the same.
  bool leads_away(double mm, int from, int to) const {
    if (!target) return false;
    const Vector3d &a = mesh.place(from), &b = mesh.place(to);
    return mm + (a + nearest_on_edge(*target, a, b) * (b - a) - *target).norm() > reach;
  }

  // A path to the corner opposite the side `from`.
  void reached(int from, double mm, const Vector3d& start, double at, int pseudo_source, int window = -1) {
    const int vertex = mesh.corner(from / 3, from % 3);
    Known& k = known[index(vertex)];
    if (mm >= k.mm || mm > reach) return;
    if (k.mm == infinite) touched_vertices.push_back(vertex);
    k = {mm, start, from, at, pseudo_source, window};
    if (mesh.is_saddle(vertex) && !leads_away(mm, vertex, vertex)) queue.push({mm, -1 - vertex});
  }

  // Whether a vertex offers a shorter path to all of the piece between the rays. It does if it offers one to the ray's
  // end that is farther from it.
  bool shorter_by(int vertex, const Vector2d& at, double before, const Vector2d& end) const {
    return before + end.norm() > known_mm(vertex) + (end - at).norm() + rounding_mm;
  }
  bool useless(const Window& w) const {
    const int t = w.side / 3, k = w.side % 3;
    const double before = pseudo_sources[index(w.pseudo_source)].before;
    return shorter_by(mesh.corner(t, k + 1), w.a, before, w.right) ||
           shorter_by(mesh.corner(t, k + 2), w.b, before, w.left);
  }

  // Opens a window through the side `s` into the triangle beyond it.
  void open(int s, int pseudo_source, const Vector2d& a, const Vector2d& b, const Vector2d& left,
            const Vector2d& right, int parent = -1) {
    const int opposite = mesh.side(s).opposite;
    if (opposite < 0) return;
    Window w{opposite, pseudo_source, a, b, left, right, parent, -1};
    const double mm = pseudo_sources[index(pseudo_source)].before + nearest(left, right);
    if (mm > reach || useless(w) ||
        leads_away(mm, mesh.corner(s / 3, s % 3 + 1), mesh.corner(s / 3, s % 3 + 2)))
      return;
    int& head = heads[index(opposite)];
    if (head < 0) touched_sides.push_back(opposite);
    w.next = head;
    head = static_cast<int>(windows.size());
    windows.push_back(w);
    queue.push({mm, head});
  }

  Vector2d apex(const Window& w) const {
    const PathMesh::Side& side = mesh.side(w.side);
    if (side.length == 0) return w.a;
    const Vector2d along = (w.b - w.a) / side.length;
    return w.a + side.foot * along + side.height * Vector2d(-along.y(), along.x());
  }

  // What the window sees through the two other sides of its triangle.
  void pass(int window) {
    const Window w = windows[index(window)];
    if (useless(w)) return;
    const int t = w.side / 3, k = w.side % 3;
    const int to_left = 3 * t + (k + 2) % 3, to_right = 3 * t + (k + 1) % 3;
    const double before = pseudo_sources[index(w.pseudo_source)].before;
    const Vector2d c = apex(w);
    bool goes_left = true, goes_right = true;
    Vector2d left_end = c,
             right_end = c;  // of the rays that go left, the last to the right, and vice versa
    if (cross(w.right, c) <= 0) {
      goes_right = false;
      left_end = met(w.right, w.a, c);
    } else if (cross(w.left, c) >= 0) {
      goes_left = false;
      right_end = met(w.left, c, w.b);
    } else {
      const double mm = before + c.norm();
      // If two windows see the corner, the farther one is only useful on the side on which it looks past the nearer.
      const double at_a = cross(c, w.a), at_b = cross(c, w.b);
      const double through = at_a / (at_a - at_b);
      Seen& best = seen[index(w.side)];
      if (mm < best.mm)
        best = {mm, through};
      else
        (through < best.through ? goes_right : goes_left) = false;
      reached(w.side, mm, start_of(w.pseudo_source, c), angle_between(w.a - c, -c), w.pseudo_source, window);
    }
    if (goes_left) {
      const Vector2d left = met(w.left, w.a, c);
      if (!shorter_by(mesh.corner(t, k + 2), w.b, before, left))
        open(to_left, w.pseudo_source, w.a, c, left, left_end, window);
    }
    if (goes_right) {
      const Vector2d right = met(w.right, c, w.b);
      if (!shorter_by(mesh.corner(t, k + 1), w.a, before, right))
        open(to_right, w.pseudo_source, c, w.b, right_end, right, window);
    }
  }

  // Straight lines from a vertex, in all directions that make half a turn or more with the arriving path on either
  // side.
  void bend_at(int vertex) {
    const Known from = known[index(vertex)];
    const int pseudo_source = static_cast<int>(pseudo_sources.size());
    pseudo_sources.push_back({from.mm, from.start, vertex});
    const double whole = mesh.total_angle(vertex);
    double passed = mesh.angle(from.from) - from.at;  // from the path to the triangle
    for (int s = mesh.next_around(from.from, true); s >= 0 && s != from.from; s = mesh.next_around(s, true)) {
      const double angle = mesh.angle(s);
      look(s, pseudo_source, M_PI - passed, whole - M_PI - passed);
      passed += angle;
    }
    if (std::isfinite(whole)) return;
    passed = from.at;
    for (int s = mesh.next_around(from.from, false); s >= 0 && s != from.from;
         s = mesh.next_around(s, false)) {
      const double angle = mesh.angle(s);
      look(s, pseudo_source, -infinite, angle - (M_PI - passed));
      passed += angle;
    }
  }

  // Looks from a pseudo-source at the corner opposite a side, at angles between two bounds, counted from the side to
  // the next corner.
  void look(int s, int pseudo_source, double first, double last) {
    const PathMesh::Side& side = mesh.side(s);
    const double angle = mesh.angle(s);
    first -= rounding_angle, last += rounding_angle;
    if (side.length == 0 || first > angle || last < 0 || first > last) return;
    const int t = s / 3, k = s % 3;
    // The corner is above the side: b, where the side begins, is on the right.
    const Vector2d b(-side.foot, -side.height), a(side.length - side.foot, -side.height);
    const auto through = [&](double by) { return met(Eigen::Rotation2Dd(by) * b, b, a); };
    const PseudoSource& here = pseudo_sources[index(pseudo_source)];
    if (first <= 0)
      reached(3 * t + (k + 1) % 3, here.before + b.norm(), here.start, mesh.angle(3 * t + (k + 1) % 3),
              pseudo_source);
    if (last >= angle) reached(3 * t + (k + 2) % 3, here.before + a.norm(), here.start, 0, pseudo_source);
    open(s, pseudo_source, a, b, last >= angle ? a : through(last), first <= 0 ? b : through(first));
  }

  Vector3d place_of(const SheetPoint& at) const {
    Vector3d place = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) place += at.weights[k] * mesh.place(mesh.corner(at.triangle, k));
    return place;
  }

  void begin(const SheetPoint& at, const SheetPoint* only, double reach_mm) {
    clear();
    reach = reach_mm;
    target = only ? std::optional(place_of(*only)) : std::nullopt;
    source_triangle = at.triangle;
    Vector3d weights = at.weights.cwiseMax(beside);
    weights /= weights.sum();
    std::array<Vector3d, 3> corner;
    source.setZero();
    for (int k = 0; k < 3; ++k) {
      corner[index(k)] = mesh.place(mesh.corner(at.triangle, k));
      source += weights[k] * corner[index(k)];
    }
    axis = (corner[1] - corner[0]).normalized();
    across = (corner[2] - corner[0] - (corner[2] - corner[0]).dot(axis) * axis).normalized();
    pseudo_sources.push_back({});
    std::array<Vector2d, 3> flat;
    for (int k = 0; k < 3; ++k) {
      const Vector3d d = corner[index(k)] - source;
      flat[index(k)] = {d.dot(axis), d.dot(across)};
    }
    asked = at.weights[0] * flat[0] + at.weights[1] * flat[1] + at.weights[2] * flat[2];
    for (int k = 0; k < 3; ++k) {
      const Vector2d& c = flat[index(k)];
      reached(3 * at.triangle + k, c.norm(), start_of(0, c), angle_between(flat[index((k + 1) % 3)] - c, -c),
              0);
    }
    for (int k = 0; k < 3; ++k) {
      const Vector2d &b = flat[index((k + 1) % 3)], &a = flat[index((k + 2) % 3)];
      open(3 * at.triangle + k, 0, a, b, a, b);
    }
    while (!queue.empty()) {
      const auto [mm, what] = queue.top();
      queue.pop();
      if (what < 0) {
        if (mm <= known_mm(-1 - what)) bend_at(-1 - what);
      } else {
        pass(what);
      }
    }
  }
};

Geodesics::Geodesics(const PathMesh& mesh) : state_(std::make_unique<State>(mesh)) {}
Geodesics::~Geodesics() = default;

void Geodesics::begin_at(const SheetPoint& source, double reach_mm) {
  state_->begin(source, nullptr, reach_mm);
}
void Geodesics::begin_at(const SheetPoint& source, const SheetPoint& target, double reach_mm) {
  state_->begin(source, &target, reach_mm);
}

std::optional<Geodesics::Path> Geodesics::to(const SheetPoint& target) const {
  const State& s = *state_;
  const int t = target.triangle;
  const Vector3d place = s.place_of(target);
  Path best{infinite, Vector3d::Zero()};
  const auto offer = [&](double mm, const auto& start) {
    if (mm < best.length) best = {mm, start()};
  };
  if (t == s.source_triangle) {
    const Vector3d way = place - s.source;
    offer(way.norm(), [&] { return Vector3d(way.norm() > 0 ? Vector3d(way.normalized()) : way); });
  }
  for (int k = 0; k < 3; ++k) {
    const int v = s.mesh.corner(t, k);
    offer(s.known_mm(v) + (place - s.mesh.place(v)).norm(), [&] { return s.known[index(v)].start; });
    for (int i = s.heads[index(3 * t + k)]; i >= 0; i = s.windows[index(i)].next) {
      const Window& w = s.windows[index(i)];
      const Vector2d at = target.weights[k] * s.apex(w) + target.weights[(k + 1) % 3] * w.a +
                          target.weights[(k + 2) % 3] * w.b;
      const double mm = at.norm(), room = rounding_angle * mm;
      if (cross(w.right, at) < -room * w.right.norm() || cross(at, w.left) < -room * w.left.norm()) continue;
      offer(s.pseudo_sources[index(w.pseudo_source)].before + mm,
            [&] { return s.start_of(w.pseudo_source, at); });
    }
  }
  if (!(best.length <= s.reach)) return std::nullopt;
  return best;
}

std::vector<PathPoint> Geodesics::trace(int vertex) const {
  const State& s = *state_;
  std::vector<PathPoint> out;
  if (s.known_mm(vertex) == infinite) return out;
  // From the target backwards, over the windows of one straight piece after another.
  while (vertex >= 0) {
    out.push_back({vertex, vertex, 0});
    const State::Known& known = s.known[index(vertex)];
    if (known.window >= 0) {
      const Vector2d begin = known.pseudo_source == 0 ? s.asked : Vector2d(0, 0);
      const Vector2d way = s.apex(s.windows[index(known.window)]) - begin;
      for (int i = known.window; i >= 0; i = s.windows[index(i)].parent) {
        const Window& w = s.windows[index(i)];
        const int t = w.side / 3, k = w.side % 3;
        const double at_a = cross(way, w.a - begin), at_b = cross(way, w.b - begin);
        const double f = at_a != at_b ? std::clamp(at_a / (at_a - at_b), 0.0, 1.0) : 0;
        out.push_back({s.mesh.corner(t, k + 1), s.mesh.corner(t, k + 2), f});
      }
    }
    vertex = s.pseudo_sources[index(known.pseudo_source)].vertex;
  }
  std::reverse(out.begin(), out.end());
  return out;
}

}  // namespace vacuform
