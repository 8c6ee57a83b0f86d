#include "worker/printing/vector_print.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>

#include "worker/pattern/area.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/pattern/drawn_loop.hpp"
#include "worker/printing/curve_fit.hpp"
#include "worker/printing/patch_map.hpp"
#include "worker/printing/tied_line.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

// Together below the 0.02 mm that are promised.
constexpr double polygon_tolerance = 0.002, fit_tolerance = 0.01, sample_mm = 0.2;
constexpr double corner_cosine = 0.94;  // 20 degrees; chords of smooth curves turn less

using Map = std::function<std::optional<Vector2d>(const Vector2d&)>;

// Where a shape is sampled.
struct Domain {
  Map rest_at;            // drawing to flat sheet
  const PatchMap* patch;  // its outline cuts the shape
};

AlignedBox2d box_of(const Area& area) {
  AlignedBox2d box;
  for (const Ring& ring : area)
    for (const Vector2d& p : ring) box.extend(p);
  return box;
}

Ring page_ring(const Vector2d& size) {
  const Vector2d h = size / 2;
  return {{-h.x(), -h.y()}, {h.x(), -h.y()}, {h.x(), h.y()}, {-h.x(), h.y()}};
}

Area on_page(const Area& area, const Vector2d& size) {
  const AlignedBox2d page(-size / 2 - Vector2d::Constant(1e-3), size / 2 + Vector2d::Constant(1e-3));
  const AlignedBox2d box = box_of(area);
  return box.isEmpty() || page.contains(box) ? area : intersection(area, {page_ring(size)});
}

Area on_patch(const Area& area, const PatchMap& patch) {
  const AlignedBox2d box = box_of(area);
  if (box.isEmpty() || patch.covers(box.min(), box.max())) return area;
  return intersection(area, patch.outline());
}

bool is_corner(const Vector2d& before, const Vector2d& after) {
  return before.dot(after) < corner_cosine * before.norm() * after.norm();
}

// Along its patch's border, which neighbouring patches share, the curve is the border itself.
Curve pulled_back(const Ring& ring, const Domain& domain) {
  std::vector<FitPoint> points;
  const std::size_t n = ring.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d &a = ring[i], &b = ring[(i + 1) % n], &before = ring[(i + n - 1) % n];
    const bool corner = is_corner(a - before, b - a) || domain.patch->is_border_vertex(a);
    const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / sample_mm)));
    for (int k = 0; k < pieces; ++k)
      if (const auto rest = domain.rest_at(a + (b - a) * k / pieces))
        points.push_back({*rest, k == 0 && corner});
  }
  return fit_curve(points, true, fit_tolerance);
}

void pull_back(const Area& area, const Domain& domain, std::vector<Curve>& outlines) {
  for (const Ring& ring : area)
    if (Curve curve = pulled_back(ring, domain); curve.points.size() > 3)
      outlines.push_back(std::move(curve));
}

// The parts of a curve that lie on the domain and on the page.
void pull_back_line(const std::vector<CurvePoint>& line, bool closed, const Map& rest_at,
                    const Vector2d& page, double width_mm, std::vector<Centreline>& out) {
  const auto place = [&](const Vector2d& uv) -> std::optional<Vector2d> {
    if ((uv.cwiseAbs() - page / 2).maxCoeff() > 1e-3) return std::nullopt;
    return rest_at(uv);
  };
  // Where the line crosses the border between a point that is placed and one that is not.
  const auto border = [&](Vector2d in, Vector2d off) {
    for (int i = 0; i < 16; ++i) {
      const Vector2d middle = (in + off) / 2;
      (place(middle) ? in : off) = middle;
    }
    return *place(in);
  };
  std::vector<std::vector<FitPoint>> parts(1);
  bool whole = true;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const auto rest = place(line[i].at);
    const bool before = i > 0 && !parts.back().empty();
    if (rest) {
      if (i > 0 && !before) parts.back().push_back({border(line[i].at, line[i - 1].at), true});
      parts.back().push_back({*rest, is_corner(line[i].before, line[i].after)});
    } else {
      whole = false;
      if (!before) continue;
      parts.back().push_back({border(line[i - 1].at, line[i].at), true});
      parts.emplace_back();
    }
  }
  if (whole && closed) {
    parts.back().pop_back();  // the first point again
    out.push_back({fit_curve(parts.back(), true, fit_tolerance), width_mm});
    return;
  }
  if (closed && parts.size() > 1 && !parts.front().empty() && !parts.back().empty() &&
      place(line.front().at)) {
    parts.back().insert(parts.back().end(), parts.front().begin() + 1, parts.front().end());
    parts.erase(parts.begin());
  }
  for (const auto& part : parts)
    if (Curve curve = fit_curve(part, false, fit_tolerance); curve.points.size() > 3)
      out.push_back({std::move(curve), width_mm});
}

// A closed line with points at most `sample_mm` apart; the first is repeated as the last.
std::vector<CurvePoint> closed_points(const std::vector<Vector2d>& line) {
  std::vector<Vector2d> dense;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vector2d &a = line[i], &b = line[(i + 1) % line.size()];
    const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / sample_mm)));
    for (int k = 0; k < pieces; ++k) dense.push_back(a + (b - a) * k / pieces);
  }
  std::vector<CurvePoint> out;
  const std::size_t n = dense.size();
  for (std::size_t i = 0; i <= n; ++i) {
    const Vector2d &before = dense[(i + n - 1) % n], &at = dense[i % n], &after = dense[(i + 1) % n];
    out.push_back({at, (at - before).normalized(), (after - at).normalized(), 0});
  }
  return out;
}

// One shape to be pulled back, and the result.
struct PulledShape {
  const Shape* shape;
  std::size_t element, number;  // Drawing::elements, Element::shapes
  std::vector<PaintedArea> areas;
  std::vector<Centreline> centrelines;
  std::vector<TiedPoints> tied;
  double painted = 0, lost = 0;
};

class PullBack {
 public:
  PullBack(const Drawing& drawing, const Placement& placement, double scale)
      : drawing_(drawing), scale_(scale), elements_placed_(!placement.elements.empty()) {
    std::vector<Ring> rings;
    for (const Segment& chart : placement.charts) {
      maps_.push_back(std::make_unique<PatchMap>(chart.patch));
      charts_.push_back(domain_of(*maps_.back()));
      rings.insert(rings.end(), maps_.back()->outline().begin(), maps_.back()->outline().end());
    }
    if (charts_.size() > 1) covered_ = union_of(rings);
    for (const PlacedElement& placed : placement.elements)
      placed_.try_emplace(static_cast<std::size_t>(placed.element),
                          Placed{std::make_unique<PatchMap>(placed.patch), placed.size});
  }

  bool elements_placed() const { return elements_placed_; }

  // The loop of a coil on the sheet; nothing where the border of its patch or of the page cuts it.
  std::optional<Centreline> loop(std::size_t element) const {
    const Element& of = drawing_.elements[element];
    if (!of.loop || of.id.empty()) return std::nullopt;
    const auto placed = placed_.find(element);
    std::vector<Centreline> found;
    for (const Domain& domain : domains_of(element))
      pull_back_line(
          closed_points(of.loop->line), true, domain.rest_at, drawing_.size_mm,
          of.loop->width_mm * (placed != placed_.end() && of.loop->filled ? placed->second.size : scale_),
          found);
    if (found.size() != 1 || !found.front().curve.closed) return std::nullopt;
    return std::move(found.front());
  }

  // What the elements paint in the pattern, for lines that are tied to them.
  void look_for_ties() {
    const Drawing& whole = drawing_.whole ? *drawing_.whole : drawing_;
    for (const auto& [index, placed] : placed_) {
      std::vector<Ring> rings;
      for (const Shape& shape : whole.elements[index].shapes) {
        if (shape.fill && shape.fill->ink() > 0)
          for (Ring& r : fill_area(shape.curves, shape.even_odd, polygon_tolerance))
            rings.push_back(std::move(r));
        if (shape.stroke && shape.stroke->colour.ink() > 0)
          for (Ring& r : stroke_area(shape.curves, *shape.stroke, polygon_tolerance))
            rings.push_back(std::move(r));
      }
      Area area = union_of(rings);
      const AlignedBox2d box = box_of(area);
      ink_.emplace(index, Inked{std::move(area), box});
    }
  }

  void run(PulledShape& pulled) const {
    const Shape& shape = *pulled.shape;
    const std::string& id = drawing_.elements[pulled.element].id;
    const auto placed = placed_.find(pulled.element);
    const bool own = placed != placed_.end();
    const std::vector<Domain> domains = domains_of(pulled.element);
    if (shape.fill) {
      const Area area = fill_area(shape.curves, shape.even_odd, polygon_tolerance);
      paint(area, *shape.fill, domains, pulled);
    }
    if (!shape.stroke) return;
    Stroke stroke = *shape.stroke;
    if (own) resize(stroke, scale_ / placed->second.size);
    std::vector<Curve> plain;
    for (std::size_t c = 0; c < shape.curves.size(); ++c)
      if (!id.empty() || !elements_placed_ || !tied(c, stroke, pulled)) plain.push_back(shape.curves[c]);
    if (plain.empty()) return;
    paint(stroke_area(plain, stroke, polygon_tolerance), stroke.colour, domains, pulled);
    if (!(stroke.colour.ink() > 0)) return;
    for (const Curve& curve : plain)
      for (const Domain& domain : domains)
        centre(flatten(curve, fine()), curve.closed, domain.rest_at, pulled);
  }

 private:
  struct Placed {
    std::unique_ptr<PatchMap> map;
    double size;
  };
  struct Inked {
    Area area;
    AlignedBox2d box;
  };

  static Fineness fine() { return {.tolerance_mm = polygon_tolerance, .turn = 0.2, .longest_mm = sample_mm}; }

  // A coil that is printed larger keeps the width of its line.
  static void resize(Stroke& stroke, double factor) {
    stroke.width_mm *= factor;
    stroke.dash_offset_mm *= factor;
    for (double& d : stroke.dashes_mm) d *= factor;
  }

  // Where an element lies: on its patch, nowhere if it is not placed, or with all others on the charts.
  std::vector<Domain> domains_of(std::size_t element) const {
    if (const auto placed = placed_.find(element); placed != placed_.end())
      return {domain_of(*placed->second.map)};
    return drawing_.elements[element].id.empty() || !elements_placed_ ? charts_ : std::vector<Domain>();
  }

  static Domain domain_of(const PatchMap& map) {
    return {[&map](const Vector2d& uv) { return map.rest_at(uv); }, &map};
  }

  // Paints on each domain the part of the area that lies there. Pieces that meet on the sheet are one area, without a
  // line between them.
  void paint(const Area& drawn, const Colour& colour, const std::vector<Domain>& domains,
             PulledShape& pulled) const {
    const Area area = on_page(drawn, drawing_.size_mm);
    const double all = colour.ink() * square_mm(area);
    double kept = 0;
    PaintedArea out{{}, false, colour};
    for (const Domain& domain : domains) {
      const Area part = on_patch(area, *domain.patch);
      kept += colour.ink() * square_mm(part);
      pull_back(part, domain, out.outlines);
    }
    if (domains.size() > 1) kept = colour.ink() * square_mm(intersection(area, covered_));
    pulled.painted += all;
    pulled.lost += all - kept;
    if (!out.outlines.empty()) pulled.areas.push_back(std::move(out));
  }

  void centre(const std::vector<CurvePoint>& line, bool closed, const Map& rest_at,
              PulledShape& pulled) const {
    if (line.size() < 2) return;
    const double width = pulled.shape->stroke->width_mm * scale_;
    pull_back_line(line, closed, rest_at, drawing_.size_mm, width, pulled.centrelines);
  }

  // The map of the element whose ink `end` touches.
  const PatchMap* touched(const Vector2d& end, double within) const {
    const PatchMap* out = nullptr;
    double least = within + 1e-6;
    for (const auto& [index, inked] : ink_) {
      if (inked.box.isEmpty() || inked.box.exteriorDistance(end) > least) continue;
      const double d = distance(end, inked.area);
      if (d >= least) continue;
      least = d;
      out = placed_.at(index).map.get();
    }
    return out;
  }

  // Lays a curve of the shape as a tied line; false where neither end touches an element.
  bool tied(std::size_t number, const Stroke& stroke, PulledShape& pulled) const {
    const Curve& curve = pulled.shape->curves[number];
    if (curve.closed || curve.points.empty()) return false;
    const PatchMap *start = touched(curve.points.front(), widest_mm(stroke) / 2),
                   *end = touched(curve.points.back(), widest_mm(stroke) / 2);
    if (!start && !end) return false;
    auto points = flatten(curve, fine());
    if (points.size() < 2) return false;
    const PatchMap& chart = *maps_.front();
    const TiedLine line(points, widest_mm(stroke), chart, start, end);
    const Domain domain{[&](const Vector2d& uv) { return line.rest_at(uv); }, &chart};
    paint(stroke_area({curve}, stroke, polygon_tolerance), stroke.colour, {domain}, pulled);
    if (stroke.colour.ink() > 0) centre(points, false, domain.rest_at, pulled);
    TiedPoints* part = nullptr;  // of the line, between places off the chart
    for (const CurvePoint& p : points) {
      const auto rest = line.rest_at(p.at);
      if (!rest) {
        part = nullptr;
        continue;
      }
      if (!part) part = &pulled.tied.emplace_back(TiedPoints{pulled.element, pulled.number, number, {}, {}});
      part->drawn.push_back(p.at);
      part->rest.push_back(*rest);
    }
    return true;
  }

  const Drawing& drawing_;
  const double scale_;
  const bool elements_placed_;
  std::vector<std::unique_ptr<PatchMap>> maps_;  // of the charts
  std::vector<Domain> charts_;
  Area covered_;  // by the charts together, where they are several
  std::map<std::size_t, Placed> placed_;
  std::map<std::size_t, Inked> ink_;
};

}  // namespace

Result<VectorPrint> pull_back(const Drawing& drawing, const Placement& placement, const Settings& settings,
                              const Context& context) {
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  PullBack pulling(drawing, placement, settings.pattern.scale);
  std::vector<PulledShape> all;
  VectorPrint out;
  bool loose = false;
  for (std::size_t e = 0; e < drawing.elements.size(); ++e) {
    const Element& element = drawing.elements[e];
    out.elements.push_back({element.id, {}, {}, {}});
    for (std::size_t i = 0; i < element.shapes.size(); ++i) {
      all.push_back({&element.shapes[i], e, i, {}, {}, {}, 0, 0});
      loose |= element.id.empty() && element.shapes[i].stroke;
    }
  }
  if (loose && pulling.elements_placed()) pulling.look_for_ties();

  constexpr std::size_t batch = 16;
  for (std::size_t first = 0; first < all.size(); first += batch) {
    VACUFORM_CHECK(
        context.step(Stage::printing, static_cast<double>(first) / static_cast<double>(all.size())));
    in_parallel(static_cast<int>(first), static_cast<int>(std::min(first + batch, all.size())),
                [&](int begin, int end) {
                  for (int i = begin; i < end && !context.cancelled(); ++i) pulling.run(all[i]);
                });
  }
  VACUFORM_CHECK(context.step(Stage::printing, 1));
  for (PulledShape& pulled : all) {
    PrintedElement& element = out.elements[pulled.element];
    for (PaintedArea& area : pulled.areas) element.areas.push_back(std::move(area));
    for (Centreline& line : pulled.centrelines) element.centrelines.push_back(std::move(line));
    for (TiedPoints& line : pulled.tied) out.tied.push_back(std::move(line));
    out.painted_mm2 += pulled.painted;
    out.lost_mm2 += pulled.lost;
  }
  std::vector<std::optional<Centreline>> loops(drawing.elements.size());
  in_parallel(0, static_cast<int>(loops.size()), [&](int begin, int end) {
    for (int e = begin; e < end && !context.cancelled(); ++e) loops[index(e)] = pulling.loop(index(e));
  });
  VACUFORM_CHECK(context.step(Stage::printing, 1));
  for (std::size_t e = 0; e < loops.size(); ++e) {
    if (!loops[e]) continue;
    if (drawing.elements[e].loop->filled) out.elements[e].centrelines.push_back(*loops[e]);
    out.elements[e].loop = std::move(loops[e]->curve);
  }
  return out;
}

}  // namespace vacuform
