// Surfaces of triangles for the checker of formed sheets: reading them, the nearest point, and vertical rays.
// Shares no code with the programs under test.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

namespace check {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Corners = std::array<int, 3>;

struct Surface {
  std::vector<Vector3d> points;
  std::vector<Corners> triangles;
  Vector3d corner(std::size_t t, int k) const { return points[static_cast<std::size_t>(triangles[t][k])]; }
  Vector3d cross(std::size_t t) const {
    return (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0));
  }
};

inline std::string read_all(const std::string& name) {
  std::ifstream in(name, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + name);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <class T>
T take(const std::string& bytes, std::size_t& at) {
  T value;
  if (at + sizeof value > bytes.size()) throw std::runtime_error("a file ends early");
  std::memcpy(&value, bytes.data() + at, sizeof value);
  at += sizeof value;
  return value;
}

// Binary STL; corners at exactly the same place become one vertex.
inline Surface read_stl(const std::string& name) {
  const std::string bytes = read_all(name);
  std::size_t at = 80;
  const auto count = take<std::uint32_t>(bytes, at);
  Surface out;
  std::map<std::array<float, 3>, int> known;
  for (std::uint32_t i = 0; i < count; ++i) {
    at = 84 + 50 * static_cast<std::size_t>(i) + 12;
    Corners t;
    for (int k = 0; k < 3; ++k) {
      std::array<float, 3> p;
      for (float& x : p) x = take<float>(bytes, at);
      const auto [place, fresh] = known.try_emplace(p, static_cast<int>(out.points.size()));
      if (fresh) out.points.emplace_back(p[0], p[1], p[2]);
      t[k] = place->second;
    }
    out.triangles.push_back(t);
  }
  return out;
}

enum Contact { free_sheet = 0, on_mold = 1, on_platform = 2, in_clamp = 3 };

struct Sheet : Surface {
  std::vector<Vector2d> rest;
  std::vector<double> thickness;
  std::vector<int> contact;
  bool cracked = false;  // one place of the flat sheet is at two places of the formed one
  Vector3d crack = Vector3d::Zero();
};

// formed.ply, as docs and DESIGN give it. Vertices of several segments, there once for each, become one again.
inline Sheet read_sheet(const std::string& name) {
  const std::string bytes = read_all(name), end = "end_header\n";
  const std::size_t body = bytes.find(end);
  if (body == std::string::npos) throw std::runtime_error("formed.ply has no end_header");
  const auto count_of = [&](const std::string& element) {
    const std::size_t at = bytes.find("element " + element + ' ');
    if (at > body) throw std::runtime_error("formed.ply has no " + element);
    return std::stoul(bytes.substr(at + 9 + element.size(), 12));
  };
  std::size_t at = body + end.size();
  Sheet out;
  std::map<std::pair<float, float>, int> known;
  std::vector<int> number;
  for (std::size_t i = 0, n = count_of("vertex"); i < n; ++i) {
    float p[9];
    for (float& x : p) x = take<float>(bytes, at);
    const Vector3d place(p[0], p[1], p[2]);
    if (!place.allFinite() || !std::isfinite(p[3]) || !std::isfinite(p[4]))
      throw std::runtime_error("formed.ply has a vertex that is not finite");
    const int contact = take<std::uint8_t>(bytes, at);
    const auto [found, fresh] = known.try_emplace({p[3], p[4]}, static_cast<int>(out.points.size()));
    number.push_back(found->second);
    if (fresh) {
      out.points.push_back(place);
      out.rest.emplace_back(p[3], p[4]);
      out.thickness.push_back(p[7]);
      out.contact.push_back(contact);
    } else if ((out.points[static_cast<std::size_t>(found->second)] - place).norm() > 1e-3) {
      out.cracked = true, out.crack = place;
    }
  }
  for (std::size_t i = 0, n = count_of("face"); i < n; ++i) {
    if (take<std::uint8_t>(bytes, at) != 3) throw std::runtime_error("formed.ply has a polygon");
    Corners t;
    for (int& v : t) v = number.at(static_cast<std::size_t>(take<std::int32_t>(bytes, at)));
    out.triangles.push_back(t);
  }
  return out;
}

// The point of a triangle nearest to p (Ericson, Real-Time Collision Detection, 5.1.5).
inline Vector3d nearest(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  if (d6 >= 0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double whole = va + vb + vc;
  return whole > 0 ? Vector3d(a + vb / whole * ab + vc / whole * ac) : a;
}

// Finds triangles by place: in a tree of boxes for distances, in columns for vertical rays.
class Finder {
 public:
  explicit Finder(const Surface& surface) : surface_(surface) {
    std::vector<std::size_t> all(surface.triangles.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    grow(all, 0, all.size());
    order_ = std::move(all);
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const Box box = box_of(t);
      for (int i = index(box.low.x()); i <= index(box.high.x()); ++i)
        for (int j = index(box.low.y()); j <= index(box.high.y()); ++j) columns_[key(i, j)].push_back(t);
    }
  }

  // The distance to the surface, or `reach` where that is farther.
  double distance(const Vector3d& p, double reach) const {
    double best = reach;
    std::vector<std::size_t> open{0};
    while (!open.empty()) {
      const Node& node = nodes_[open.back()];
      open.pop_back();
      if (node.box.away(p) >= best) continue;
      if (node.left == 0) {
        for (std::size_t i = node.first; i < node.last; ++i) {
          const std::size_t t = order_[i];
          const Vector3d q = nearest(p, surface_.corner(t, 0), surface_.corner(t, 1), surface_.corner(t, 2));
          best = std::min(best, (q - p).norm());
        }
        continue;
      }
      const bool right_first = nodes_[node.right].box.away(p) < nodes_[node.left].box.away(p);
      open.push_back(right_first ? node.left : node.right);
      open.push_back(right_first ? node.right : node.left);
    }
    return best;
  }

  // How often the surface is crossed straight above p: from its lower to its upper face +1, the other way -1. Over a closed
  // surface that faces outwards 1 means inside; over a sheet that spans everything 1 means under it.
  int crossings_above(const Vector3d& p) const {
    const Vector2d q(p.x() + 1.37e-6, p.y() - 2.11e-6);  // off the edges of rounded coordinates
    const auto found = columns_.find(key(index(q.x()), index(q.y())));
    if (found == columns_.end()) return 0;
    int crossings = 0;
    for (const std::size_t t : found->second) {
      const Vector3d a = surface_.corner(t, 0), b = surface_.corner(t, 1), c = surface_.corner(t, 2);
      const auto turn = [&](const Vector3d& u, const Vector3d& v) {
        return (v.x() - u.x()) * (q.y() - u.y()) - (v.y() - u.y()) * (q.x() - u.x());
      };
      const double wc = turn(a, b), wa = turn(b, c), wb = turn(c, a), whole = wa + wb + wc;
      if (whole == 0 || !((wa >= 0 && wb >= 0 && wc >= 0) || (wa <= 0 && wb <= 0 && wc <= 0))) continue;
      if ((wa * a.z() + wb * b.z() + wc * c.z()) / whole > p.z()) crossings += whole > 0 ? 1 : -1;
    }
    return crossings;
  }

 private:
  struct Box {
    Vector3d low = Vector3d::Constant(HUGE_VAL), high = -low;
    double away(const Vector3d& p) const { return (p - p.cwiseMax(low).cwiseMin(high)).norm(); }
  };
  struct Node {
    Box box;
    std::size_t first, last, left = 0, right = 0;  // of order_; nodes below, or none
  };

  Box box_of(std::size_t t) const {
    Box box;
    for (int k = 0; k < 3; ++k)
      box.low = box.low.cwiseMin(surface_.corner(t, k)), box.high = box.high.cwiseMax(surface_.corner(t, k));
    return box;
  }
  Vector3d middle(std::size_t t) const {
    return (surface_.corner(t, 0) + surface_.corner(t, 1) + surface_.corner(t, 2)) / 3;
  }

  std::size_t grow(std::vector<std::size_t>& all, std::size_t first, std::size_t last) {
    const std::size_t number = nodes_.size();
    nodes_.push_back({{}, first, last});
    Box box, middles;
    for (std::size_t i = first; i < last; ++i) {
      const Box one = box_of(all[i]);
      box.low = box.low.cwiseMin(one.low), box.high = box.high.cwiseMax(one.high);
      middles.low = middles.low.cwiseMin(middle(all[i])),
      middles.high = middles.high.cwiseMax(middle(all[i]));
    }
    nodes_[number].box = box;
    if (last - first <= 4) return number;
    int axis = 0;
    (middles.high - middles.low).maxCoeff(&axis);
    const auto at = [&](std::size_t i) { return all.begin() + static_cast<std::ptrdiff_t>(i); };
    const std::size_t half = (first + last) / 2;
    std::nth_element(at(first), at(half), at(last),
                     [&](std::size_t a, std::size_t b) { return middle(a)[axis] < middle(b)[axis]; });
    const std::size_t left = grow(all, first, half), right = grow(all, half, last);
    nodes_[number].left = left, nodes_[number].right = right;
    return number;
  }

  static int index(double x) { return static_cast<int>(std::floor(x / 2)); }
  static std::uint64_t key(int i, int j) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(i)) << 32 | static_cast<std::uint32_t>(j);
  }

  const Surface& surface_;
  std::vector<std::size_t> order_;
  std::vector<Node> nodes_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> columns_;
};

// Calls `each` with points of the triangle at most about `spacing` apart: the middles of equal parts, and its corners.
template <class Each>
void sample(const Surface& surface, std::size_t t, double spacing, const Each& each) {
  const Vector3d a = surface.corner(t, 0), b = surface.corner(t, 1), c = surface.corner(t, 2);
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  const int n = std::clamp(static_cast<int>(std::ceil(longest / spacing)), 1, 200);
  const auto at = [&](double u, double v) { each(Vector3d(a + u / n * (b - a) + v / n * (c - a))); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      at(i + 1.0 / 3, j + 1.0 / 3);
      if (i + j < n - 1) at(i + 2.0 / 3, j + 2.0 / 3);
    }
  each(a), each(b), each(c);
}

}  // namespace check
