#include "worker/conductors/array_build.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "worker/conductors/crossings.hpp"
#include "worker/conductors/faces.hpp"
#include "worker/conductors/interrupted.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;

// Of a capacitor's footprint, mm on the part: between the pads, along the trace, and across it.
struct Pads {
  double gap, length, width;
};
Pads pads_of(const CoilSettings& settings) {
  switch (settings.capacitor) {
    case CapacitorCase::c0805:
      return {0.9, 1.0, 1.45};
    case CapacitorCase::c1111:
      return {1.8, 1.3, 3.0};
    case CapacitorCase::custom:
      break;
  }
  return {settings.gap_mm, settings.pad_length_mm, settings.pad_width_mm};
}

std::optional<Vector3d> in_space(const Patch& patch, const Eigen::Vector2d& uv) {
  const auto found = PlaneLocator(patch.triangles, patch.uv).nearest(uv, 1e-3);
  if (!found) return std::nullopt;
  return interpolate(patch.triangles, *found, patch.inked);
}

class Build {
 public:
  Build(const Drawing& drawing, const Placement& placement, const ChartedSurface& charted, const Settings& settings)
      : drawing_(drawing), placement_(placement), charted_(charted), settings_(settings), pads_(pads_of(settings.coils)),
        traces_(drawing.elements.size()), placed_(drawing.elements.size(), -1) {
    for (std::size_t i = 0; i < placement.elements.size(); ++i) {
      const PlacedElement& placed = placement.elements[i];
      const std::size_t e = index(placed.element);
      placed_[e] = static_cast<int>(i);
      if (!is_loop(e)) continue;
      const DrawnLoop& loop = *drawing.elements[e].loop;
      traces_[e] = {loop.width_mm * (loop.filled ? placed.size : settings.pattern.scale), placed.size,
                    LoopPath(loop).length()};
    }
    build_.faces.assign(drawing.elements.size(), 0);
  }

  Result<ArrayBuild> run(const Context& context) {
    VACUFORM_CHECK(cross(context));
    make_gaps();
    make_layers();
    return std::move(build_);
  }

 private:
  bool is_loop(std::size_t e) const {
    return placed_[e] >= 0 && drawing_.elements[e].loop && drawing_.elements[e].loop->line.size() >= 3;
  }
  const Placement& placement_of(std::size_t e) const { return build_.placement(build_.faces[e], placement_); }
  const Patch& patch_of(std::size_t e) const { return placement_of(e).elements[index(placed_[e])].patch; }

  // Faces, crossings and bridges.
  Result<void> cross(const Context& context) {
    const CoilSettings& coils = settings_.coils;
    std::vector<Crossing> all = crossings(drawing_, placement_);
    if (coils.build == CoilBuild::two_faces) {
      build_.faces = choose_faces(static_cast<int>(drawing_.elements.size()), all);
      for (std::size_t i = 0; i < placement_.elements.size(); ++i)
        if (const int leader = placement_.layout.elements[i].leader; leader >= 0)
          build_.faces[index(placement_.elements[i].element)] =
              build_.faces[index(placement_.elements[index(leader)].element)];
      if (std::find(build_.faces.begin(), build_.faces.end(), 1) != build_.faces.end()) {
        VACUFORM_TRY(reverse,
                     on_other_face(charted_, drawing_, placement_, settings_.pattern.scale, context));
        build_.reverse = std::move(reverse);
        const auto there = crossings_on(1, build_.faces, crossings(drawing_, *build_.reverse));
        all = crossings_on(0, build_.faces, all);
        all.insert(all.end(), there.begin(), there.end());
      }
    }
    build_.crossings = std::move(all);
    if (coils.build == CoilBuild::single) {
      if (!build_.crossings.empty()) build_.warnings.push_back(shorted());
      return {};
    }
    Bridges chosen = choose_bridges(build_.crossings, traces_,
                                    {coils.patch_margin_mm, coils.bridge_overlap_mm, coils.clearance_mm});
    build_.bridges = std::move(chosen.bridges);
    if (chosen.crowded > 0)
      build_.warnings.push_back(
          {.code = "bridges-crowded",
           .text = std::to_string(chosen.crowded) + " bridges end on the patch of another crossing",
           .figure = Warning::Figure{static_cast<double>(chosen.crowded), "bridges", 0.0}});
    return {};
  }

  std::string id(int element) const { return drawing_.elements[index(element)].id; }

  Warning shorted() const {
    Warning out{.code = "coils-short", .text = {}};
    const std::size_t count = build_.crossings.size();
    std::vector<std::string> pairs;
    for (const Crossing& c : build_.crossings) {
      const std::string pair = c.a == c.b ? id(c.a) + " itself" : id(c.a) + " and " + id(c.b);
      if (std::find(pairs.begin(), pairs.end(), pair) == pairs.end()) pairs.push_back(pair);
      if (out.marks.size() < Warning::most_marks)
        out.marks.push_back({{c.place.x(), c.place.y(), c.place.z()}, 2 * traces_[index(c.a)].width_mm});
    }
    for (const std::string& pair : pairs) out.place += (out.place.empty() ? "" : ", ") + pair;
    out.text = "The traces of loops cross at " + std::to_string(count) + (count == 1 ? " place" : " places") +
               " on one layer of ink: the loops are joined there";
    out.figure = Warning::Figure{static_cast<double>(count), "crossings", 0.0};
    return out;
  }

  // The place along a loop that is nearest to where its cable leaves.
  double towards_port(std::size_t e, const LoopPath& path) const {
    const Patch& patch = patch_of(e);
    const PlaneLocator locator(patch.triangles, patch.uv);
    const std::vector<Vector3d> border = charted_.border();
    const bool edge = settings_.coils.port == PortSide::edge;
    constexpr int count = 180;
    double best = 0, least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < count; ++i) {
      const double along = path.length() * i / count;
      const auto found = locator.nearest(path.at(along), 1e-3);
      if (!found) continue;
      const Vector3d at = interpolate(patch.triangles, *found, patch.inked);
      double far = std::numeric_limits<double>::infinity();
      if (edge)
        for (const Vector3d& p : border) far = std::min(far, (p - at).squaredNorm());
      else
        far = -at.z();
      if (far < least) least = far, best = along;
    }
    return best;
  }

  void make_gaps() {
    std::vector<std::vector<Interval>> blocked(drawing_.elements.size());
    for (const Bridge& b : build_.bridges) {
      blocked[index(b.over())].push_back({b.along_over() - b.reach, b.along_over() + b.reach});
      blocked[index(b.under())].push_back({b.along_under() - b.patch, b.along_under() + b.patch});
    }
    int lost = 0;
    for (std::size_t e = 0; e < drawing_.elements.size(); ++e) {
      if (!is_loop(e)) continue;
      const LoopPath path(*drawing_.elements[e].loop);
      const auto add = [&](const Interval& along, bool port, bool drawn) {
        const auto place = in_space(patch_of(e), path.at(along.middle()));
        build_.gaps.push_back({static_cast<int>(e), along, port, drawn, place.value_or(Vector3d::Zero())});
      };
      if (std::vector<Interval> drawn = drawn_gaps(path, ink_of(e)); !drawn.empty()) {
        const double port = towards_port(e, path);
        const auto far = [&](const Interval& gap) { return apart_on_loop(gap.middle(), port, path.length()); };
        std::rotate(drawn.begin(), std::min_element(drawn.begin(), drawn.end(), [&](const Interval& a, const Interval& b) {
                      return far(a) < far(b);
                    }), drawn.end());
        for (const Interval& gap : drawn) add(gap, &gap == &drawn.front(), true);
        continue;
      }
      if (settings_.coils.gaps == 0) continue;
      const double scale = traces_[e].scale, half = (pads_.gap / 2 + pads_.length + settings_.coils.clearance_mm) / scale;
      const std::vector<double> places =
          places_for_gaps(path.length(), settings_.coils.gaps, half, towards_port(e, path), blocked[e]);
      lost += settings_.coils.gaps - static_cast<int>(places.size());
      for (const double at : places)
        add({at - pads_.gap / 2 / scale, at + pads_.gap / 2 / scale}, at == places.front(), false);
    }
    if (lost > 0)
      build_.warnings.push_back({.code = "gaps-left-out",
                                 .text = std::to_string(lost) + " gaps have no room between the crossings of their loops",
                                 .figure = Warning::Figure{static_cast<double>(lost), "gaps", 0.0}});
  }

  Area ink_of(std::size_t e) const {
    std::vector<Ring> rings;
    const auto add = [&](const Area& area) { rings.insert(rings.end(), area.begin(), area.end()); };
    for (const Shape& shape : drawing_.elements[e].shapes) {
      if (shape.fill) add(fill_area(shape.curves, shape.even_odd, 0.01));
      if (shape.stroke) add(stroke_area(shape.curves, *shape.stroke, 0.01));
    }
    return union_of(rings);
  }

  Drawing& layer(PrintStep step, int face) {
    for (BuiltLayer& layer : build_.layers)
      if (layer.step == step && layer.face == face) return layer.drawing;
    BuiltLayer& out = build_.layers.emplace_back(BuiltLayer{step, face, drawing_});
    for (Element& element : out.drawing.elements) {
      element.shapes.clear();
      element.loop.reset();
    }
    return out.drawing;
  }

  void make_layers() {
    layer(PrintStep::conductor, 0);
    for (std::size_t e = 0; e < drawing_.elements.size(); ++e) {
      const Element& drawn = drawing_.elements[e];
      Element& out = layer(PrintStep::conductor, build_.faces[e]).elements[e];
      out.loop = drawn.loop;
      if (!is_loop(e)) {
        out.shapes = drawn.shapes;
        continue;
      }
      const LoopPath path(*drawn.loop);
      std::vector<Interval> removed;
      for (const Bridge& b : build_.bridges)
        if (b.over() == static_cast<int>(e)) removed.push_back({b.along_over() - b.cut, b.along_over() + b.cut});
      for (const LoopGap& gap : build_.gaps)
        if (gap.coil == static_cast<int>(e) && !gap.drawn) removed.push_back(gap.along);
      out.shapes = removed.empty() ? drawn.shapes : interrupted(drawn.shapes, band(path, removed));
      add_pads(e, path, out);
    }
    for (const Bridge& b : build_.bridges) {
      const int face = build_.faces[index(b.over())];
      const LoopPath over(*drawing_.elements[index(b.over())].loop), under(*drawing_.elements[index(b.under())].loop);
      layer(PrintStep::dielectric, face)
          .elements[index(b.under())]
          .shapes.push_back(along_loop(under, {b.along_under() - b.patch, b.along_under() + b.patch},
                                       drawn_width(traces_[index(b.under())].width_mm + 2 * settings_.coils.patch_margin_mm)));
      layer(PrintStep::bridges, face)
          .elements[index(b.over())]
          .shapes.push_back(along_loop(over, {b.along_over() - b.reach, b.along_over() + b.reach},
                                       drawn_width(traces_[index(b.over())].width_mm)));
    }
    std::sort(build_.layers.begin(), build_.layers.end(), [](const BuiltLayer& a, const BuiltLayer& b) {
      return std::pair(a.face, a.step) < std::pair(b.face, b.step);
    });
  }

  // A line of the drawing is as wide on the part as it is drawn, times the scale of the drawing.
  double drawn_width(double on_part_mm) const { return on_part_mm / settings_.pattern.scale; }

  void add_pads(std::size_t e, const LoopPath& path, Element& out) const {
    const double long_ = pads_.length / traces_[e].scale, wide = drawn_width(std::max(pads_.width, traces_[e].width_mm));
    for (const LoopGap& gap : build_.gaps) {
      if (gap.coil != static_cast<int>(e) || gap.drawn) continue;
      out.shapes.push_back(along_loop(path, {gap.along.from - long_, gap.along.from}, wide));
      out.shapes.push_back(along_loop(path, {gap.along.to, gap.along.to + long_}, wide));
    }
  }

  const Drawing& drawing_;
  const Placement& placement_;
  const ChartedSurface& charted_;
  const Settings& settings_;
  const Pads pads_;
  std::vector<TraceOnPart> traces_;  // by Drawing::elements
  std::vector<int> placed_;          // the same; indices into Placement::elements, -1: none
  ArrayBuild build_;
};

}  // namespace

Result<ArrayBuild> build_array(const Drawing& drawing, const Placement& placement, const ChartedSurface& reverse,
                               const Settings& settings, const Context& context) {
  return Build(drawing, placement, reverse, settings).run(context);
}

}  // namespace vacuform
