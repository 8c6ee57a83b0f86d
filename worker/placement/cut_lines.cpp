#include "worker/placement/cut_lines.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "api/base/decimal.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/exact_geodesics.hpp"
#include "worker/surface/nearest_point.hpp"
#include "worker/surface/split_triangle.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;

constexpr double near_vertex = 0.1;  // of an edge: a cut that passes this near goes through the vertex
constexpr double farthest_mm = 20;   // of a row's places from the chart

// A vertex as the corner of the first triangle that has it.
SheetPoint corner_at(const PathMesh& mesh, int vertex) {
  int side = 0;
  while (mesh.corner(side / 3, side % 3) != vertex) ++side;
  return {side / 3, Vector3d::Unit(side % 3)};
}

class Cutter {
 public:
  Cutter(FormedSheet&& sheet, const InkedSurface& surface, Flattening&& flattening)
      : sheet_(std::move(sheet)),
        inked_(surface.inked()),
        flat_(std::move(flattening)),
        on_chart_(sheet_.triangles.size(), -1) {
    for (std::size_t i = 0; i < flat_.triangles.size(); ++i)
      on_chart_[index(flat_.triangles[i])] = static_cast<int>(i);
  }

  // The vertex at this place, created if needed; nothing if the place is too far away.
  std::optional<int> vertex_at(const Vector3d& place) {
    const auto near = nearest_point(sheet_.triangles, inked_, flat_.triangles, place);
    if (!(near.distance_mm <= farthest_mm)) return std::nullopt;
    const Triangle corners = sheet_.triangles[index(near.point.triangle)];
    for (std::size_t k = 0; k < 3; ++k)
      if (near.point.weights[static_cast<Eigen::Index>(k)] > 1 - near_vertex) return corners[k];
    for (std::size_t k = 0; k < 3; ++k)
      if (near.point.weights[static_cast<Eigen::Index>(k)] < near_vertex) {
        const auto a = (k + 1) % 3, b = (k + 2) % 3;
        const double wa = near.point.weights[static_cast<Eigen::Index>(a)],
                     wb = near.point.weights[static_cast<Eigen::Index>(b)];
        const int v = on_edge({corners[a], corners[b], wb / (wa + wb)});
        divide();
        return v;
      }
    const int v = add({corners[0], corners[1], corners[2]}, near.point.weights);
    const Triangle whole = corners;
    replace(near.point.triangle, {{whole[0], whole[1], v}, {whole[1], whole[2], v}, {whole[2], whole[0], v}});
    return v;
  }

  bool cut(int from, int to) {
    std::vector<Triangle> chart;
    for (const int t : flat_.triangles) chart.push_back(sheet_.triangles[index(t)]);
    const PathMesh mesh(std::move(chart), inked_);
    Geodesics geodesics(mesh);
    geodesics.begin_at(corner_at(mesh, from), std::numeric_limits<double>::infinity());
    std::vector<int> way{from};
    for (const PathPoint& p : geodesics.trace(to)) {
      const int v = on_edge(p);
      if (way.back() != v) way.push_back(v);
    }
    divide();
    for (std::size_t i = 1; i < way.size(); ++i) edges_.insert(std::minmax(way[i - 1], way[i]));
    return way.size() > 1;
  }

  CutSheet finish() {
    InkedSurface surface(sheet_.triangles, std::move(inked_), sheet_.rest);
    return {std::move(sheet_), std::move(surface), std::move(flat_), {edges_.begin(), edges_.end()}};
  }

 private:
  int add(const Triangle& of, const Vector3d& weights) {
    const auto blend = [&](auto& values) {
      using Value = std::decay_t<decltype(values[0])>;
      const Value value = weights[0] * values[index(of[0])] + weights[1] * values[index(of[1])] +
                          weights[2] * values[index(of[2])];
      values.push_back(value);
    };
    blend(sheet_.rest), blend(sheet_.formed), blend(sheet_.thickness), blend(sheet_.temperature);
    blend(flat_.chart), blend(inked_);
    Eigen::Index most = 0;
    weights.maxCoeff(&most);
    const auto nearest = index(of[most]);
    sheet_.contact.push_back(sheet_.contact[nearest]);
    sheet_.contact_time.push_back(sheet_.contact_time[nearest]);
    return static_cast<int>(sheet_.rest.size()) - 1;
  }

  // The vertex at a point of an edge, which divide() then splits there.
  int on_edge(const PathPoint& p) {
    if (p.f < near_vertex || p.a == p.b) return p.a;
    if (p.f > 1 - near_vertex) return p.b;
    const Edge edge = std::minmax(p.a, p.b);
    const auto [at, is_new] = middles_.try_emplace(edge, 0);
    if (is_new) {
      at->second = add({p.a, p.b, p.b}, {1 - p.f, p.f, 0});
      if (edges_.erase(edge))  // an earlier cut runs along it
        edges_.insert(std::minmax(edge.first, at->second)),
            edges_.insert(std::minmax(edge.second, at->second));
    }
    return at->second;
  }

  // Splits the triangles that have new vertices on their edges.
  void divide() {
    if (middles_.empty()) return;
    const int count = static_cast<int>(sheet_.triangles.size());
    for (int t = 0; t < count; ++t) {
      const Triangle c = sheet_.triangles[index(t)];
      std::array<int, 3> middle{-1, -1, -1};
      for (std::size_t e = 0; e < 3; ++e)
        if (const auto at = middles_.find(std::minmax(c[e], c[(e + 1) % 3])); at != middles_.end())
          middle[e] = at->second;
      replace(t, pieces_of(c, middle));
    }
    middles_.clear();
  }

  void replace(int t, const std::vector<Triangle>& pieces) {
    const int row = on_chart_[index(t)];
    sheet_.triangles[index(t)] = pieces.front();
    for (std::size_t i = 1; i < pieces.size(); ++i) {
      sheet_.element_thickness.push_back(sheet_.element_thickness[index(t)]);
      sheet_.element_wrinkled.push_back(sheet_.element_wrinkled[index(t)]);
      on_chart_.push_back(row < 0 ? -1 : static_cast<int>(flat_.triangles.size()));
      if (row >= 0) {
        flat_.triangles.push_back(static_cast<int>(sheet_.triangles.size()));
        if (!flat_.weight.empty()) flat_.weight.push_back(flat_.weight[index(row)]);
        if (!flat_.favoured.empty()) flat_.favoured.push_back(flat_.favoured[index(row)]);
      }
      sheet_.triangles.push_back(pieces[i]);
    }
  }

  FormedSheet sheet_;
  std::vector<Vector3d> inked_;
  Flattening flat_;
  std::vector<int> on_chart_;    // row in flat_.triangles of each triangle; -1 off the chart
  std::map<Edge, int> middles_;  // new vertices of edges that are not split yet
  std::set<Edge> edges_;
};

}  // namespace

Result<CutSheet> with_cut_lines(FormedSheet sheet, InkedSurface surface, Flattening flattening,
                                const std::vector<std::array<double, 6>>& rows, const Context& context) {
  if (rows.empty()) return CutSheet{std::move(sheet), std::move(surface), std::move(flattening), {}};
  Cutter cutter(std::move(sheet), surface, std::move(flattening));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    VACUFORM_CHECK(context.step(Stage::printing, 0));
    const auto& r = rows[i];
    const auto refuse = [&](const std::string& what, const char* fix) {
      return fail(Code::bad_settings, "row " + std::to_string(i + 1) + " of the cuts " + what,
                  "pattern.seams", fix);
    };
    const auto from = cutter.vertex_at({r[0], r[1], r[2]}), to = cutter.vertex_at({r[3], r[4], r[5]});
    if (!from || !to)
      return refuse("has a point more than " + decimal(farthest_mm, 0) + " mm from the formed part",
                    "give points of the mold, x, y, z in mm as formed.ply has them");
    if (*from == *to) return refuse("leads from a point to itself", "give two points apart");
    if (!cutter.cut(*from, *to))
      return refuse("has no path over the formed part",
                    "give points between which the sheet lies on the mold");
  }
  return cutter.finish();
}

}  // namespace vacuform
