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
#include "worker/conductors/other_ink.hpp"
#include "worker/pattern/drawn_loop.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

class Build {
 public:
  Build(const Drawing& drawing, const Placement& placement, const SheetSides& sides,
        const std::optional<BodyBelow>& body, const Settings& settings)
      : drawing_(drawing),
        placement_(placement),
        sides_(sides),
        body_(body),
        settings_(settings),
        layered_(drawing.layered()),
        parted_(drawing.parts_loops()),
        loop_of_(drawing.elements.size(), -1),
        placed_(drawing.elements.size(), -1) {
    for (std::size_t i = 0; i < placement.elements.size(); ++i)
      placed_[index(placement.elements[i].element)] = static_cast<int>(i);
    build_.faces.assign(drawing.elements.size(), 0);
    if (layered_) whole_ = std::make_shared<const Drawing>(drawing);
  }

  Result<ArrayBuild> run(const Context& context) {
    if (parted_ && settings_.coils.build != CoilBuild::single)
      return fail(Code::bad_settings,
                  "the drawing has layers for steps of printing, which say how its loops are parted",
                  "coils.build", "leave the setting out, or draw the loops on one layer");
    VACUFORM_TRY(found, choose_faces_and_cross(context));
    if (prints_plates(settings_.coils)) VACUFORM_CHECK(place_on_reverse(context));
    lay_opposite();
    lay_traces();
    bridge(found);
    cover();
    GapLayout layout = lay_gaps(loops_, sides_.reverse.border(), body_, settings_);
    build_.gaps = std::move(layout.gaps);
    build_.warnings.insert(build_.warnings.end(), layout.warnings.begin(), layout.warnings.end());
    if (settings_.print.compensate_width) widen();
    make_layers();
    if (settings_.coils.tails != TailExit::none) VACUFORM_CHECK(add_tails(context));
    std::sort(build_.layers.begin(), build_.layers.end(), [](const BuiltLayer& a, const BuiltLayer& b) {
      return std::pair(a.face, a.step) < std::pair(b.face, b.step);
    });
    return std::move(build_);
  }

 private:
  bool is_loop(std::size_t e) const {
    return placed_[e] >= 0 && drawing_.elements[e].loop && drawing_.elements[e].loop->line.size() >= 3;
  }

  // The crossings that need a bridge.
  Result<std::vector<Crossing>> choose_faces_and_cross(const Context& context) {
    const CoilSettings& coils = settings_.coils;
    if (layered_) VACUFORM_CHECK(look_at_layers(context));
    if (parted_) take_drawn_faces();
    if (parted_) return std::vector<Crossing>();
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
    VACUFORM_CHECK(place_on_reverse(context));
    const auto there = crossings_on(1, build_.faces, crossings(drawing_, *build_.reverse));
    all = crossings_on(0, build_.faces, all);
    all.insert(all.end(), there.begin(), there.end());
    return all;
  }

  Result<void> place_on_reverse(const Context& context) {
    if (build_.reverse) return {};
    VACUFORM_TRY(reverse,
                 on_other_face(sides_.reverse, drawing_, placement_, settings_.pattern.scale, context));
    build_.reverse = std::move(reverse);
    return {};
  }

  // A loop lies on the face of its first conductor, whatever else belongs to it.
  void take_drawn_faces() {
    for (std::size_t e = 0; e < drawing_.elements.size(); ++e) {
      const std::vector<Shape>& shapes = drawing_.elements[e].shapes;
      const auto conductor = std::find_if(shapes.begin(), shapes.end(), [](const Shape& shape) {
        return step_of(shape) == PrintStep::conductor;
      });
      build_.faces[e] = conductor == shapes.end() ? 0 : drawn_face(*conductor);
    }
  }

  Result<void> look_at_layers(const Context& context) {
    bool reverse = false;
    std::size_t unnamed = 0, loops = 0;
    for (const Element& element : drawing_.elements)
      for (const Shape& shape : element.shapes) {
        reverse |= drawn_face(shape) == 1;
        unnamed += shape.layer || !has_ink(shape) ? 0 : 1;
        loops += step_of(shape) == PrintStep::bridges && is_closed_loop(shape);
      }
    if (unnamed > 0)
      build_.warnings.push_back(
          {.code = "layer-unnamed",
           .text =
               std::to_string(unnamed) + (unnamed == 1 ? " shape lies" : " shapes lie") +
               " on no layer that is named after a step of printing, and is printed with the first conductor",
           .figure = Warning::Figure{static_cast<double>(unnamed), "shapes", 0.0}});
    if (loops > 0)
      build_.warnings.push_back({.code = "loop-on-bridges",
                                 .text = std::to_string(loops) +
                                         (loops == 1 ? " closed loop lies" : " closed loops lie") +
                                         " on a layer of bridges, and is no coil",
                                 .figure = Warning::Figure{static_cast<double>(loops), "loops", 0.0}});
    return reverse ? place_on_reverse(context) : Result<void>();
  }

  static bool has_ink(const Shape& shape) {
    return (shape.fill && shape.fill->ink() > 0) || (shape.stroke && shape.stroke->colour.ink() > 0);
  }
  static bool is_closed_loop(const Shape& shape) {
    if (!shape.stroke || !(shape.stroke->colour.ink() > 0)) return false;
    return std::any_of(shape.curves.begin(), shape.curves.end(), [&](const Curve& curve) {
      return closed_loop(loop_line(curve, shape.stroke->width_mm)).has_value();
    });
  }
  static PrintStep step_of(const Shape& shape) { return shape.layer.value_or(DrawnLayer()).step; }
  int drawn_face(const Shape& shape) const {
    switch (shape.layer.value_or(DrawnLayer()).face) {
      case DrawnFace::first:
        break;
      case DrawnFace::reverse:
        return 1;
      case DrawnFace::outer:
        return settings_.pattern.inked_face == InkedFace::outer ? 0 : 1;
      case DrawnFace::inner:
        return settings_.pattern.inked_face == InkedFace::inner ? 0 : 1;
    }
    return 0;
  }
  int face_of(std::size_t e, const Shape& shape) const {
    return parted_ || !of_circuits(step_of(shape)) ? drawn_face(shape) : build_.faces[e];
  }

  void lay_traces() {
    for (std::size_t e = 0; e < drawing_.elements.size(); ++e) {
      if (!is_loop(e)) continue;
      const auto placed_on = [&](int face) -> const PlacedElement& {
        return build_.placement(face, placement_).elements[index(placed_[e])];
      };
      const PlacedElement& placed = placed_on(build_.faces[e]);
      const DrawnLoop& loop = *drawing_.elements[e].loop;
      // A line is as wide on the part as it is drawn, whatever size decoupling gives its coil.
      const double width = loop.width_mm * (loop.filled ? placed.size : settings_.pattern.scale);
      loop_of_[e] = static_cast<int>(loops_.size());
      LaidLoop& laid = loops_.emplace_back();
      laid.element = static_cast<int>(e);
      laid.trace = std::make_unique<Trace>(loop, placed.patch, width, placed.size);
      laid.centre = placed.centre_rest;
      laid.drawn = drawn_gaps(laid.trace->path(), ink_of(e));
      if (!prints_plates(settings_.coils)) continue;
      laid.far = std::make_unique<Trace>(loop, placed_on(1 - build_.faces[e]).patch, width, placed.size);
    }
  }

  // What an element has on the other face lies opposite to what it has on its own, such as plates, marks that are drawn at one
  // place on both, and lines that end there.
  void lay_opposite() {
    if (!build_.reverse) return;
    for (std::size_t e = 0; e < drawing_.elements.size(); ++e) {
      const std::vector<Shape>& shapes = drawing_.elements[e].shapes;
      const bool drawn = layered_ && std::any_of(shapes.begin(), shapes.end(), [&](const Shape& shape) {
                           return face_of(e, shape) == build_.faces[e];
                         });
      if (placed_[e] < 0 || !(drawn || (prints_plates(settings_.coils) && is_loop(e)))) continue;
      const std::size_t i = index(placed_[e]);
      const int face = 1 - build_.faces[e];
      if (face == 0 && !build_.first) build_.first = placement_;
      PlacedElement& out = face == 1 ? build_.reverse->elements[i] : build_.first->elements[i];
      const Patch there = std::move(out.patch);
      out = build_.placement(1 - face, placement_).elements[i];
      out.patch = opposite(out.patch, there);
    }
  }

  LaidLoop& loop_of(int element) { return loops_[index(loop_of_[index(element)])]; }
  const Trace& trace_of(int element) const { return *loops_[index(loop_of_[index(element)])].trace; }

  void bridge(const std::vector<Crossing>& all) {
    const CoilSettings& coils = settings_.coils;
    Bridges chosen = choose_bridges(all, [&](int element) -> const Trace& { return trace_of(element); },
                                    {coils.patch_margin_mm, coils.bridge_overlap_mm, coils.clearance_mm});
    build_.bridges = std::move(chosen.bridges);
    if (chosen.crowded > 0)
      build_.warnings.push_back(
          {.code = "bridges-crowded",
           .text = std::to_string(chosen.crowded) + " bridges end on the patch of another crossing",
           .figure = Warning::Figure{static_cast<double>(chosen.crowded), "bridges", 0.0}});
  }

  // What bridges and patches lie on.
  void cover() {
    for (const Bridge& b : build_.bridges) {
      loop_of(b.over()).covered.push_back({b.along_over() - b.reach, b.along_over() + b.reach});
      loop_of(b.under()).covered.push_back({b.along_under() - b.patch, b.along_under() + b.patch});
    }
    if (!parted_) return;
    const std::array<Islands, 2> over{ink_over(0), ink_over(1)};
    for (LaidLoop& loop : loops_)
      loop.covered = inked_parts(loop.trace->path(), over[index(build_.faces[index(loop.element)])]);
  }

  void widen() {
    std::vector<std::vector<double>> loads;
    double least = std::numeric_limits<double>::infinity();
    for (const LaidLoop& loop : loops_) {
      loads.push_back(trace_loads(*loop.trace, settings_.circuit.ink_stretch));
      least = std::min(least, *std::min_element(loads.back().begin(), loads.back().end()));
    }
    build_.widened.resize(drawing_.elements.size());
    for (std::size_t i = 0; i < loops_.size(); ++i) {
      const LaidLoop& loop = loops_[i];
      std::vector<Interval> kept = loop.covered;
      for (const LoopGap& gap : build_.gaps) {
        if (gap.coil != loop.element) continue;
        constexpr double beside = 0.2;
        const double ends = gap.drawn ? beside : pads_of(settings_.coils).length / loop.trace->scale();
        kept.push_back({gap.along.from - std::max(ends, gap.plate ? gap.plate->before : 0),
                        gap.along.to + std::max(ends, gap.plate ? gap.plate->after : 0)});
      }
      build_.widened[index(loop.element)] = widened(*loop.trace, loads[i], least, kept);
    }
  }

  static void add_ink(const Shape& shape, std::vector<Ring>& rings) {
    const auto add = [&](const Area& area) { rings.insert(rings.end(), area.begin(), area.end()); };
    if (shape.fill) add(fill_area(shape.curves, shape.even_odd, 0.01));
    if (shape.stroke) add(stroke_area(shape.curves, *shape.stroke, 0.01));
  }

  // What conducts of a loop.
  Area ink_of(std::size_t e) const {
    std::vector<Ring> rings;
    for (const Shape& shape : drawing_.elements[e].shapes)
      if (conducts(step_of(shape)) && face_of(e, shape) == build_.faces[e]) add_ink(shape, rings);
    return union_of(rings);
  }

  // What the drawing prints over the conductors of a face as a part of the circuits.
  Islands ink_over(int face) const {
    std::vector<Ring> rings;
    for (const Element& element : drawing_.elements)
      for (const Shape& shape : element.shapes)
        if (const PrintStep step = step_of(shape);
            step != PrintStep::conductor && of_circuits(step) && drawn_face(shape) == face)
          add_ink(shape, rings);
    return Islands(rings);
  }

  BuiltLayer& built_layer(PrintStep step, int face) {
    for (BuiltLayer& layer : build_.layers)
      if (layer.step == step && layer.face == face) return layer;
    BuiltLayer& out = build_.layers.emplace_back(BuiltLayer{step, face, drawing_});
    out.drawing.whole = whole_;
    for (Element& element : out.drawing.elements) {
      element.shapes.clear();
      element.loop.reset();
    }
    return out;
  }
  Drawing& layer(PrintStep step, int face) { return built_layer(step, face).drawing; }

  void make_layers() {
    layer(PrintStep::conductor, 0);
    for (std::size_t e = 0; e < drawing_.elements.size(); ++e) {
      for (const Shape& shape : drawing_.elements[e].shapes)
        layer(step_of(shape), face_of(e, shape)).elements[e].shapes.push_back(in_its_ink(shape));
      Element& out = layer(PrintStep::conductor, build_.faces[e]).elements[e];
      out.loop = drawing_.elements[e].loop;
      if (!is_loop(e)) continue;
      const LoopPath& path = trace_of(static_cast<int>(e)).path();
      std::vector<Interval> removed;
      for (const Bridge& b : build_.bridges)
        if (b.over() == static_cast<int>(e))
          removed.push_back({b.along_over() - b.cut, b.along_over() + b.cut});
      for (const LoopGap& gap : build_.gaps)
        if (gap.coil == static_cast<int>(e) && !gap.drawn) removed.push_back(gap.along);
      if (!removed.empty()) out.shapes = interrupted(out.shapes, band(path, removed));
      add_pads(e, out);
      if (!build_.widened.empty())
        out.shapes.insert(out.shapes.end(), build_.widened[e].added.begin(), build_.widened[e].added.end());
    }
    for (const Bridge& b : build_.bridges) {
      const int face = build_.faces[index(b.over())];
      const Trace &over = trace_of(b.over()), &under = trace_of(b.under());
      layer(PrintStep::dielectric, face)
          .elements[index(b.under())]
          .shapes.push_back(along_loop(under.path(), {b.along_under() - b.patch, b.along_under() + b.patch},
                                       drawn_width(under.width_mm() + 2 * settings_.coils.patch_margin_mm)));
      layer(PrintStep::bridges, face)
          .elements[index(b.over())]
          .shapes.push_back(along_loop(over.path(), {b.along_over() - b.reach, b.along_over() + b.reach},
                                       drawn_width(over.width_mm())));
    }
    for (const LoopGap& gap : build_.gaps)
      if (gap.plate)
        layer(PrintStep::conductor, 1 - build_.faces[index(gap.coil)])
            .elements[index(gap.coil)]
            .shapes.push_back(
                along_loop(trace_of(gap.coil).path(),
                           {gap.along.from - gap.plate->before, gap.along.to + gap.plate->after},
                           drawn_width(settings_.coils.plate_width_mm)));
    leave_out_empty_layers();
  }

  Result<void> add_tails(const Context& context) {
    std::vector<double> widest;
    for (const LaidLoop& loop : loops_)
      widest.push_back(build_.widened.empty() ? 1 : build_.widened[index(loop.element)].widest);
    const PatchOf patch_of = [&](std::size_t e, int face) -> std::vector<const Patch*> {
      const Placement& placement = build_.placement(face, placement_);
      if (placed_[e] >= 0) return {&placement.elements[index(placed_[e])].patch};
      std::vector<const Patch*> out;
      for (const Segment& chart : placement.charts) out.push_back(&chart.patch);
      return out;
    };
    VACUFORM_TRY(
        tails,
        lay_tails({loops_,
                   build_.gaps,
                   build_.faces,
                   widest,
                   {&sides_.first, &sides_.reverse},
                   ink_beside_traces(build_.layers, build_.faces, widest_by_element(widest), patch_of)},
                  settings_, context));
    for (const Tail& tail : tails.tails)
      for (const TailCrossing& crossing : tail.crossings)
        layer(PrintStep::dielectric, build_.faces[index(tail.coil)])
            .elements[index(crossing.under)]
            .shapes.push_back(along_loop(trace_of(crossing.under).path(), crossing.patch,
                                         drawn_width(crossing.patch_width_mm)));
    for (LaidInkArea& ink : tails.ink) built_layer(ink.step, ink.face).laid.push_back(std::move(ink));
    build_.tails = std::move(tails.tails);
    say_left_out(tails.left_out);
    return {};
  }

  void say_left_out(const std::vector<int>& blocked) {
    std::vector<int> without_port;
    for (const LaidLoop& loop : loops_)
      if (std::none_of(build_.gaps.begin(), build_.gaps.end(),
                       [&](const LoopGap& gap) { return gap.port && gap.coil == loop.element; }))
        without_port.push_back(loop.element);
    for (const auto& [elements, why] : {std::pair(blocked, "no way from its port to the edge"),
                                        std::pair(without_port, "no gap for a port")}) {
      if (elements.empty()) continue;
      Warning& warning = build_.warnings.emplace_back(Warning{.code = "tails-left-out", .text = {}});
      warning.text =
          std::to_string(elements.size()) +
          (elements.size() == 1 ? " loop has no tail: it has " : " loops have no tails: each has ") + why;
      warning.figure = Warning::Figure{static_cast<double>(elements.size()), "loops", 0.0};
      for (const int e : elements)
        warning.place += (warning.place.empty() ? "" : ", ") + drawing_.elements[index(e)].id;
      for (const LoopGap& gap : build_.gaps)
        if (gap.port && std::find(elements.begin(), elements.end(), gap.coil) != elements.end() &&
            warning.marks.size() < Warning::most_marks)
          warning.marks.push_back({{gap.place.x(), gap.place.y(), gap.place.z()}, 5});
    }
  }

  std::vector<double> widest_by_element(const std::vector<double>& widest) const {
    std::vector<double> out(drawing_.elements.size(), 0);
    for (std::size_t i = 0; i < loops_.size(); ++i) out[index(loops_[i].element)] = widest[i];
    return out;
  }

  // A layer with nothing but white on it would be an empty page. The first layer is what the print is, and is kept.
  void leave_out_empty_layers() {
    const auto is_empty = [](const BuiltLayer& layer) {
      return std::none_of(layer.drawing.elements.begin(), layer.drawing.elements.end(),
                          [](const Element& element) {
                            return std::any_of(element.shapes.begin(), element.shapes.end(),
                                               [](const Shape& s) { return has_ink(s); });
                          });
    };
    const auto empty = std::stable_partition(build_.layers.begin() + 1, build_.layers.end(),
                                             [&](const BuiltLayer& layer) { return !is_empty(layer); });
    const auto count = build_.layers.end() - empty;
    if (count == 0) return;
    build_.layers.erase(empty, build_.layers.end());
    build_.warnings.push_back({.code = "layer-empty",
                               .text = std::to_string(count) + (count == 1 ? " layer has" : " layers have") +
                                       " nothing but white, which is no ink, and " +
                                       (count == 1 ? "is" : "are") + " not printed",
                               .figure = Warning::Figure{static_cast<double>(count), "layers", 0.0}});
  }

  // A person tells layers apart by their colours; each has one ink but a picture.
  Shape in_its_ink(Shape shape) const {
    if (step_of(shape) == PrintStep::picture) return shape;
    const auto blacken = [](Colour& colour) {
      if (colour.ink() > 0) colour = {0, 0, 0, 1};
    };
    if (layered_ && shape.fill) blacken(*shape.fill);
    if (layered_ && shape.stroke) blacken(shape.stroke->colour);
    return shape;
  }

  // A line of the drawing is as wide on the part as it is drawn, times the scale of the drawing.
  double drawn_width(double on_part_mm) const { return on_part_mm / settings_.pattern.scale; }

  // The ends of the trace at its gaps: the pads of a part, or what lies over a plate.
  void add_pads(std::size_t e, Element& out) const {
    const Trace& trace = trace_of(static_cast<int>(e));
    const Pads pads = pads_of(settings_.coils);
    const double margin = plate_margin_mm / trace.scale(), length = pads.length / trace.scale();
    for (const LoopGap& gap : build_.gaps) {
      if (gap.coil != static_cast<int>(e) || gap.drawn) continue;
      const double before = gap.plate ? gap.plate->before + margin : length,
                   after = gap.plate ? gap.plate->after + margin : length,
                   wide = gap.plate ? settings_.coils.plate_width_mm + 2 * plate_margin_mm
                                    : std::max(pads.width, trace.width_mm());
      out.shapes.push_back(
          along_loop(trace.path(), {gap.along.from - before, gap.along.from}, drawn_width(wide)));
      out.shapes.push_back(along_loop(trace.path(), {gap.along.to, gap.along.to + after}, drawn_width(wide)));
    }
  }

  const Drawing& drawing_;
  const Placement& placement_;
  const SheetSides& sides_;
  const std::optional<BodyBelow>& body_;
  const Settings& settings_;
  const bool layered_, parted_;  // see Drawing
  std::shared_ptr<const Drawing> whole_;
  std::vector<LaidLoop> loops_;
  std::vector<int> loop_of_;  // by Drawing::elements, -1: none
  std::vector<int> placed_;   // the same; indices into Placement::elements
  ArrayBuild build_;
};

}  // namespace

Result<ArrayBuild> build_array(const Drawing& drawing, const Placement& placement, const SheetSides& sides,
                               const std::optional<BodyBelow>& body, const Settings& settings,
                               const Context& context) {
  return Build(drawing, placement, sides, body, settings).run(context);
}

}  // namespace vacuform
