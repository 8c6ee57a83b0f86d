#include "worker/conductors/array_build.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "worker/conductors/crossings.hpp"
#include "worker/conductors/faces.hpp"
#include "worker/conductors/interrupted.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
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

class Build {
 public:
  Build(const Drawing& drawing, const Placement& placement, const ChartedSurface& charted,
        const Settings& settings)
      : drawing_(drawing),
        placement_(placement),
        charted_(charted),
        settings_(settings),
        pads_(pads_of(settings.coils)),
        border_(charted.border()),
        traces_(drawing.elements.size()),
        placed_(drawing.elements.size(), -1) {
    for (std::size_t i = 0; i < placement.elements.size(); ++i)
      placed_[index(placement.elements[i].element)] = static_cast<int>(i);
    build_.faces.assign(drawing.elements.size(), 0);
  }

  Result<ArrayBuild> run(const Context& context) {
    VACUFORM_TRY(found, choose_faces_and_cross(context));
    lay_traces();
    bridge(found);
    make_gaps();
    make_layers();
    return std::move(build_);
  }

 private:
  bool is_loop(std::size_t e) const {
    return placed_[e] >= 0 && drawing_.elements[e].loop && drawing_.elements[e].loop->line.size() >= 3;
  }

  // The crossings that need a bridge.
  Result<std::vector<Crossing>> choose_faces_and_cross(const Context& context) {
    const CoilSettings& coils = settings_.coils;
    if (coils.build == CoilBuild::single) return std::vector<Crossing>();
    std::vector<Crossing> all = crossings(drawing_, placement_);
    if (coils.build == CoilBuild::bridges) return all;
    build_.faces = choose_faces(static_cast<int>(drawing_.elements.size()), all);
    for (std::size_t i = 0; i < placement_.elements.size(); ++i) {
      const std::size_t e = index(placement_.elements[i].element);
      if (const int leader = placement_.layout.elements[i].leader; leader >= 0 && !is_loop(e))
        build_.faces[e] = build_.faces[index(placement_.elements[index(leader)].element)];
    }
    if (std::find(build_.faces.begin(), build_.faces.end(), 1) == build_.faces.end()) return all;
    VACUFORM_TRY(reverse, on_other_face(charted_, drawing_, placement_, settings_.pattern.scale, context));
    build_.reverse = std::move(reverse);
    const auto there = crossings_on(1, build_.faces, crossings(drawing_, *build_.reverse));
    all = crossings_on(0, build_.faces, all);
    all.insert(all.end(), there.begin(), there.end());
    return all;
  }

  void lay_traces() {
    for (std::size_t e = 0; e < drawing_.elements.size(); ++e) {
      if (!is_loop(e)) continue;
      const PlacedElement& placed = build_.placement(build_.faces[e], placement_).elements[index(placed_[e])];
      const DrawnLoop& loop = *drawing_.elements[e].loop;
      // A line is as wide on the part as it is drawn, whatever size decoupling gives its coil.
      traces_[e] = std::make_unique<Trace>(
          loop, placed.patch, loop.width_mm * (loop.filled ? placed.size : settings_.pattern.scale),
          placed.size);
    }
  }

  void bridge(const std::vector<Crossing>& all) {
    const CoilSettings& coils = settings_.coils;
    Bridges chosen =
        choose_bridges(all, [&](int element) -> const Trace& { return *traces_[index(element)]; },
                       {coils.patch_margin_mm, coils.bridge_overlap_mm, coils.clearance_mm});
    build_.bridges = std::move(chosen.bridges);
    if (chosen.crowded > 0)
      build_.warnings.push_back(
          {.code = "bridges-crowded",
           .text = std::to_string(chosen.crowded) + " bridges end on the patch of another crossing",
           .figure = Warning::Figure{static_cast<double>(chosen.crowded), "bridges", 0.0}});
  }

  // The place along a loop that is nearest to where its cable leaves.
  double towards_port(const Trace& trace) const {
    const bool edge = settings_.coils.port == PortSide::edge;
    constexpr int count = 180;
    double best = 0, least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < count; ++i) {
      const double along = trace.path().length() * i / count;
      const auto at = trace.at(along);
      if (!at) continue;
      double far = edge ? std::numeric_limits<double>::infinity() : -at->z();
      if (edge)
        for (const Vector3d& p : border_) far = std::min(far, (p - *at).squaredNorm());
      if (far < least) least = far, best = along;
    }
    return best;
  }

  LoopGap gap_of(std::size_t e, const Interval& along, bool port, bool drawn) const {
    const Trace& trace = *traces_[e];
    LoopGap out{.coil = static_cast<int>(e),
                .along = along,
                .port = port,
                .drawn = drawn,
                .number = static_cast<int>(build_.gaps.size()) + 1};
    const double at = along.middle();
    out.place = trace.at(at).value_or(Vector3d::Zero());
    const auto middle = trace.rest(at), left = trace.rest(at, 1);
    if (!middle || !left || !((*left - *middle).norm() > 0)) return out;
    const Vector2d centre =
        build_.placement(build_.faces[e], placement_).elements[index(placed_[e])].centre_rest;
    const double side = (*left - *middle).dot(centre - *middle) < 0 ? -1 : 1;
    out.rest = *middle;
    out.inwards = side * (*left - *middle).normalized();
    return out;
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
      const LoopPath& path = traces_[e]->path();
      const auto add = [&](const Interval& along, bool port, bool drawn) {
        build_.gaps.push_back(gap_of(e, along, port, drawn));
      };
      if (std::vector<Interval> drawn = drawn_gaps(path, ink_of(e)); !drawn.empty()) {
        const double port = towards_port(*traces_[e]);
        const auto far = [&](const Interval& gap) {
          return apart_on_loop(gap.middle(), port, path.length());
        };
        std::rotate(drawn.begin(),
                    std::min_element(drawn.begin(), drawn.end(),
                                     [&](const Interval& a, const Interval& b) { return far(a) < far(b); }),
                    drawn.end());
        for (const Interval& gap : drawn) add(gap, &gap == &drawn.front(), true);
        continue;
      }
      if (settings_.coils.gaps == 0) continue;
      const double scale = traces_[e]->scale(),
                   half = (pads_.gap / 2 + pads_.length + settings_.coils.clearance_mm) / scale;
      const std::vector<double> places =
          places_for_gaps(path.length(), settings_.coils.gaps, half, towards_port(*traces_[e]), blocked[e]);
      lost += settings_.coils.gaps - static_cast<int>(places.size());
      for (const double at : places)
        add({at - pads_.gap / 2 / scale, at + pads_.gap / 2 / scale}, at == places.front(), false);
    }
    if (lost > 0)
      build_.warnings.push_back(
          {.code = "gaps-left-out",
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
      const LoopPath& path = traces_[e]->path();
      std::vector<Interval> removed;
      for (const Bridge& b : build_.bridges)
        if (b.over() == static_cast<int>(e))
          removed.push_back({b.along_over() - b.cut, b.along_over() + b.cut});
      for (const LoopGap& gap : build_.gaps)
        if (gap.coil == static_cast<int>(e) && !gap.drawn) removed.push_back(gap.along);
      out.shapes = removed.empty() ? drawn.shapes : interrupted(drawn.shapes, band(path, removed));
      add_pads(e, out);
    }
    for (const Bridge& b : build_.bridges) {
      const int face = build_.faces[index(b.over())];
      const Trace &over = *traces_[index(b.over())], &under = *traces_[index(b.under())];
      layer(PrintStep::dielectric, face)
          .elements[index(b.under())]
          .shapes.push_back(along_loop(under.path(), {b.along_under() - b.patch, b.along_under() + b.patch},
                                       drawn_width(under.width_mm() + 2 * settings_.coils.patch_margin_mm)));
      layer(PrintStep::bridges, face)
          .elements[index(b.over())]
          .shapes.push_back(along_loop(over.path(), {b.along_over() - b.reach, b.along_over() + b.reach},
                                       drawn_width(over.width_mm())));
    }
    std::sort(build_.layers.begin(), build_.layers.end(), [](const BuiltLayer& a, const BuiltLayer& b) {
      return std::pair(a.face, a.step) < std::pair(b.face, b.step);
    });
  }

  // A line of the drawing is as wide on the part as it is drawn, times the scale of the drawing.
  double drawn_width(double on_part_mm) const { return on_part_mm / settings_.pattern.scale; }

  void add_pads(std::size_t e, Element& out) const {
    const LoopPath& path = traces_[e]->path();
    const double length = pads_.length / traces_[e]->scale(),
                 wide = drawn_width(std::max(pads_.width, traces_[e]->width_mm()));
    for (const LoopGap& gap : build_.gaps) {
      if (gap.coil != static_cast<int>(e) || gap.drawn) continue;
      out.shapes.push_back(along_loop(path, {gap.along.from - length, gap.along.from}, wide));
      out.shapes.push_back(along_loop(path, {gap.along.to, gap.along.to + length}, wide));
    }
  }

  const Drawing& drawing_;
  const Placement& placement_;
  const ChartedSurface& charted_;
  const Settings& settings_;
  const Pads pads_;
  const std::vector<Vector3d> border_;          // of the chart, in space
  std::vector<std::unique_ptr<Trace>> traces_;  // by Drawing::elements; null: no loop
  std::vector<int> placed_;                     // the same; indices into Placement::elements, -1: none
  ArrayBuild build_;
};

}  // namespace

Result<ArrayBuild> build_array(const Drawing& drawing, const Placement& placement,
                               const ChartedSurface& reverse, const Settings& settings,
                               const Context& context) {
  return Build(drawing, placement, reverse, settings).run(context);
}

}  // namespace vacuform
