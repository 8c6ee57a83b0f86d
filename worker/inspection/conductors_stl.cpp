#include "worker/inspection/conductors_stl.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "api/base/decimal.hpp"
#include "worker/numerics/plane.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/planar_triangles.hpp"
#include "worker/surface/plane_locator.hpp"
#include "worker/surface/vertex_normals.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A ring with sides of at most `longest_mm`.
std::vector<Vector2d> with_short_sides(const Ring& ring, double longest_mm) {
  std::vector<Vector2d> out;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
    const int parts = std::max(1, static_cast<int>(std::ceil((b - a).norm() / longest_mm)));
    for (int k = 0; k < parts; ++k) out.push_back(a + (b - a) * k / parts);
  }
  return out;
}

// Whether a point lies inside an odd number of rings.
bool inside(const std::vector<Ring>& rings, const Vector2d& p) {
  bool in = false;
  for (const Ring& ring : rings)
    for (std::size_t i = 0, k = ring.size() - 1; i < ring.size(); k = i++)
      if ((ring[i].y() > p.y()) != (ring[k].y() > p.y()) &&
          p.x() <
              (ring[k].x() - ring[i].x()) * (p.y() - ring[i].y()) / (ring[k].y() - ring[i].y()) + ring[i].x())
        in = !in;
  return in;
}

class Solids {
 public:
  explicit Solids(const Finished& job)
      : job_(job),
        locator_(job.sheet.triangles, job.sheet.rest),
        normals_{vertex_normals(job.surface.inked(), job.sheet.triangles),
                 vertex_normals(job.reverse->inked(), job.sheet.triangles)} {}

  void add(const Layer& layer, const std::map<std::string, std::vector<Ring>>& dielectric) {
    const bool bridges = layer.step == PrintStep::bridges;
    for (const PrintedElement& element : layer.source->vectors()->elements) {
      std::vector<Ring> painted;
      for (const PaintedArea& area : element.areas)
        if (area.colour.ink() > 0)
          for (Ring& ring : fill_area(area.outlines, area.even_odd, tolerance_mm))
            painted.push_back(std::move(ring));
      if (painted.empty()) continue;
      add_solid(element.id + (bridges ? "-bridges" : ""), union_of(painted), layer,
                bridges && dielectric.contains(key(layer)) ? dielectric.at(key(layer)) : std::vector<Ring>());
    }
  }

  std::string text() const { return text_; }

  // Layers of one face have one key.
  static std::string key(const Layer& layer) { return layer.mirrored() ? "inner" : "outer"; }

 private:
  static constexpr double tolerance_mm = 0.01;

  void add_solid(const std::string& name, const Area& area, const Layer& layer,
                 const std::vector<Ring>& dielectric) {
    // Bridges bend where they leave the dielectric.
    const double longest_mm = dielectric.empty() ? 1.5 : 0.4;
    std::vector<std::vector<Vector2d>> rings;
    for (const Ring& ring : area) rings.push_back(with_short_sides(ring, longest_mm));
    const PlanarTriangles flat = triangulate(rings);
    std::vector<std::array<Vector3d, 2>> sides;  // next to the sheet, and away from it
    for (const Vector2d& p : flat.points) sides.push_back(both_sides(p, layer, inside(dielectric, p)));
    // Away from the sheet is up on the outer face, and down on the other.
    const bool up = !layer.mirrored();
    text_ += "solid " + name + '\n';
    std::map<std::pair<int, int>, int> edges;
    for (const Triangle& t : flat.triangles) {
      facet(sides[t[0]][1], sides[t[up ? 1 : 2]][1], sides[t[up ? 2 : 1]][1]);
      facet(sides[t[0]][0], sides[t[up ? 2 : 1]][0], sides[t[up ? 1 : 2]][0]);
      for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
    }
    for (const auto& [edge, count] : edges) {
      if (edges.contains({edge.second, edge.first})) continue;
      const auto &a = sides[edge.first], &b = sides[edge.second];
      const auto &from = up ? a : b, &to = up ? b : a;
      facet(from[0], to[0], to[1]);
      facet(from[0], to[1], from[1]);
    }
    text_ += "endsolid " + name + '\n';
  }

  std::array<Vector3d, 2> both_sides(const Vector2d& rest, const Layer& layer, bool raised) const {
    const SheetPoint at = locator_.nearest(rest, HUGE_VAL).value_or(SheetPoint{0, {1, 0, 0}});
    const bool reverse = layer.face != job_.settings.pattern.inked_face;
    const InkedSurface& surface = reverse ? *job_.reverse : job_.surface;
    const Vector3d normal = interpolate(job_.sheet.triangles, at, normals_[reverse ? 1 : 0]).normalized() *
                            (layer.mirrored() ? -1 : 1);
    const double left = job_.sheet.element_thickness[index(at.triangle)] / job_.settings.sheet.thickness_mm;
    const double ink = 1e-3 * job_.settings.circuit.ink_um * left;
    double bottom = layer.step == PrintStep::bridges ? ink : 0;
    if (raised) bottom += 1e-3 * job_.settings.circuit.dielectric_um * left;
    const Vector3d place = surface.place(at);
    return {place + bottom * normal, place + (bottom + ink) * normal};
  }

  void facet(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const Vector3d normal = (b - a).cross(c - a).normalized();
    const auto add = [&](const Vector3d& v, int places) {
      for (const double x : v) text_ += ' ' + decimal(x, places);
      text_ += '\n';
    };
    text_ += "facet normal";
    add(normal.allFinite() ? normal : Vector3d(0, 0, 0), 4);
    text_ += "outer loop\n";
    for (const Vector3d* p : {&a, &b, &c}) {
      text_ += "vertex";
      add(*p, 5);
    }
    text_ += "endloop\nendfacet\n";
  }

  const Finished& job_;
  const PlaneLocator locator_;
  const std::array<std::vector<Vector3d>, 2> normals_;  // of the inked face and of the other
  std::string text_;
};

}  // namespace

std::string conductors_stl(const Finished& job) {
  std::map<std::string, std::vector<Ring>> dielectric;
  for (const Layer& layer : job.print.layers)
    if (layer.step == PrintStep::dielectric)
      for (const PrintedElement& element : layer.source->vectors()->elements)
        for (const PaintedArea& area : element.areas)
          for (Ring& ring : fill_area(area.outlines, area.even_odd, 0.01))
            dielectric[Solids::key(layer)].push_back(std::move(ring));
  for (auto& [face, rings] : dielectric) rings = union_of(rings);
  Solids solids(job);
  for (const Layer& layer : job.print.layers)
    if (conducts(layer.step.value_or(PrintStep::conductor))) solids.add(layer, dielectric);
  return solids.text();
}

}  // namespace vacuform
