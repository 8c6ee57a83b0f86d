#include "worker/placement/placement.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "api/base/decimal.hpp"
#include "worker/placement/alignment.hpp"
#include "worker/stage/index.hpp"
#include "worker/surface/nearest_point.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The region of interest with the sheet's own triangles.
struct Whole {
  Segment chart;
  std::vector<int> local;  // of each vertex of the sheet; -1 off the chart
};
Whole whole_region(const ChartedSurface& charted, const Alignment& alignment) {
  const InkedSurface& surface = charted.surface();
  Whole out{{}, std::vector<int>(surface.rest().size(), -1)};
  Patch& patch = out.chart.patch;
  std::vector<int>& local = out.local;
  for (const int t : charted.flattening().triangles) {
    out.chart.triangles.push_back(static_cast<int>(out.chart.triangles.size()));
    Triangle corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = index(surface.triangles()[index(t)][k]);
      if (local[v] < 0) {
        local[v] = static_cast<int>(patch.uv.size());
        patch.uv.push_back(alignment.pattern(charted.flattening().chart[v]));
        patch.rest.push_back(surface.rest()[v]);
        patch.inked.push_back(surface.inked()[v]);
      }
      corners[k] = local[v];
    }
    patch.triangles.push_back(corners);
  }
  out.chart.distortion = patch_distortion(patch, alignment.scale);
  return out;
}

void warn_about_segments(const Segments& segments, const PatternSettings& settings,
                         std::vector<Warning>& warnings) {
  Warning above{"segment-distorted", "", {}};
  double worst = 0;
  std::size_t count = 0;
  for (const Segment& s : segments.parts) {
    if (s.distortion <= settings.distortion_limit) continue;
    worst = std::max(worst, s.distortion), ++count;
    Eigen::AlignedBox3d box;
    for (const Vector3d& p : s.patch.inked) box.extend(p);
    const Vector3d middle = box.center();
    if (above.marks.size() < Warning::most_marks)
      above.marks.push_back({{middle.x(), middle.y(), middle.z()}, box.diagonal().norm()});
  }
  if (count > 0) {
    above.text = (count == 1 ? std::string("A segment stays") : std::to_string(count) + " segments stay") +
                 " above pattern.distortion_limit (" +
                 (std::isfinite(worst) ? "up to " + decimal(worst, 2) : std::string("folded over")) +
                 "): the sheet is creased or too coarse there";
    above.figure = Warning::Figure{worst, "", settings.distortion_limit};
    warnings.push_back(std::move(above));
  }
  if (!settings.seams.empty() && !segments.cuts_sufficed)
    warnings.push_back(
        {.code = "seams-not-enough",
         .text = "The cuts of pattern.seams alone leave segments above pattern.distortion_limit, or "
                 "lying over themselves, and more cuts were made",
         .figure = Warning::Figure{static_cast<double>(segments.parts.size()), "segments"},
         .place = "pattern.seams"});
}

Result<void> place_segments(Whole&& whole, const Alignment& alignment, const PatternSettings& settings,
                            const std::vector<Edge>& cuts, const Context& context, Placement& out) {
  std::vector<Edge> local;
  for (const auto& [a, b] : cuts)
    if (whole.local[index(a)] >= 0 && whole.local[index(b)] >= 0)
      local.push_back(std::minmax(whole.local[index(a)], whole.local[index(b)]));
  std::sort(local.begin(), local.end());
  VACUFORM_TRY(segments, cut_into_segments(whole.chart.patch, alignment.scale, settings.distortion_limit,
                                           local, context));
  warn_about_segments(segments, settings, out.warnings);
  out.charts = std::move(segments.parts);
  out.seams = std::move(segments.seams);
  return {};
}

// "coil-1, coil-2 and 5 more"
std::string names(const Drawing& drawing, const std::vector<int>& elements) {
  constexpr std::size_t most = 8;
  std::string out;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (i == most) return out + " and " + std::to_string(elements.size() - most) + " more";
    if (i > 0) out += i + 1 == elements.size() ? " and " : ", ";
    out += drawing.elements[index(elements[i])].id;
  }
  return out;
}

Warning about(const Drawing& drawing, const char* code, const std::vector<int>& elements,
              const std::string& one, const std::string& several) {
  Warning warning{code, names(drawing, elements) + (elements.size() > 1 ? several : one)};
  warning.place = names(drawing, elements);
  warning.figure = Warning::Figure{static_cast<double>(elements.size()),
                                   "of " + std::to_string(drawing.elements.size()) + " elements", 0.0};
  return warning;
}

void say_what_was_found(const Drawing& drawing, const ElementLayout& layout,
                        const std::vector<ElementOnSurface>& laid, std::vector<Warning>& warnings) {
  std::vector<int> off;
  for (std::size_t i = 0; i < laid.size(); ++i)
    if (!laid[i].on_head) off.push_back(layout.elements[i].element);
  if (!layout.left_out.empty())
    warnings.push_back(about(drawing, "coil-left-out", layout.left_out,
                             " lies off the formed part and is not printed.",
                             " lie off the formed part and are not printed."));
  if (!off.empty())
    warnings.push_back(about(drawing, "coil-off-head", off, " does not lie wholly on the mold.",
                             " do not lie wholly on the mold."));
}

PlacedElement placed(const InkedSurface& surface, const Drawing& drawing, double scale,
                     const LaidElement& element, const Centre& centre, const ElementOnSurface& laid) {
  PlacedElement out;
  out.element = element.element;
  out.centre = surface.place(centre.point);
  out.centre_rest = surface.rest(centre.point);
  out.moved_mm = centre.moved.norm();
  out.turned_deg = laid.turn * 180 / M_PI;
  out.size = scale * element.size;
  out.on_head = laid.on_head;
  out.smooth = laid.patch.smooth;
  out.patch = laid.patch.patch;
  for (Vector2d& uv : out.patch.uv) uv = drawing.elements[index(element.element)].centre + uv / out.size;
  return out;
}

double geodesic_mm(const InkedSurface& surface, const ElementLayout& layout, const Neighbours& pair) {
  return connect(surface, layout.centres[index(pair.a)].point, layout.centres[index(pair.b)].point).mm;
}

// What an offset moves an array by: its centre lies at the end of the offset as it lies at the beginning without one.
Result<std::optional<Anchor>> anchor_of(const ChartedSurface& charted, const Drawing& drawing,
                                        const ElementLayout& layout, PatternSettings settings,
                                        const Context& context) {
  if (!layout.origin || layout.pairs.empty() || settings.offset_mm == PatternSettings().offset_mm)
    return std::optional<Anchor>();
  settings.offset_mm = PatternSettings().offset_mm;
  VACUFORM_TRY(alignment, align(charted, settings));
  ElementLayout still = lay_by_chart(charted, drawing, alignment);
  VACUFORM_CHECK(multilaterate(charted, still.centres, still.pairs, context));
  Anchor anchor{*layout.origin};
  if (still.origin && still.centres.size() == layout.centres.size())
    anchor.off = off_origin(charted.surface(), *still.origin, still.centres);
  return std::optional(anchor);
}

// Puts coils where a layout has put them, if it was made for this surface. A coil that the drawing has elsewhere than
// then, against most others, is moved by as much.
std::optional<Warning> use_places(const ChartedSurface& charted, const Drawing& drawing,
                                  const PatternSettings& settings, ElementLayout& layout) {
  constexpr double same_surface_mm = 0.5,
                   same_place_mm = 0.02;  // the coarser sheet of a preview lies within the first
  const InkedSurface& surface = charted.surface();
  const auto place_of = [&](std::size_t i) -> const std::optional<CoilPlace>& {
    return drawing.elements[index(layout.elements[i].element)].place;
  };
  std::vector<std::size_t> placed;
  std::array<std::vector<double>, 2> shifts;
  for (std::size_t i = 0; i < layout.elements.size(); ++i) {
    if (layout.elements[i].leader >= 0 || !place_of(i)) continue;
    placed.push_back(i);
    for (std::size_t k = 0; k < 2; ++k)
      shifts[k].push_back(layout.centres[i].drawn[static_cast<Eigen::Index>(k)] -
                          place_of(i)->drawn[static_cast<Eigen::Index>(k)]);
  }
  if (placed.empty()) return std::nullopt;
  Warning unused{"places-unused", ""};
  const PatternSettings untouched;
  if (settings.scale != untouched.scale || settings.rotate_deg != untouched.rotate_deg ||
      settings.offset_mm != untouched.offset_mm || !settings.points.empty()) {
    unused.text =
        "The drawing says where its coils lie on the head, and the settings move it: the coils are placed "
        "by their distances";
    unused.place = "pattern.offset_mm, pattern.rotate_deg, pattern.scale, pattern.points";
    return unused;
  }
  std::vector<NearestPoint> found;
  double farthest = 0;
  for (const std::size_t i : placed) {
    found.push_back(
        nearest_point(surface.triangles(), surface.inked(), charted.flattening().triangles, place_of(i)->at));
    farthest = std::max(farthest, found.back().distance_mm);
  }
  if (farthest > same_surface_mm) {
    unused.text = "The drawing was laid out for another head, or with other settings: its places lie up to " +
                  decimal(farthest, 1) + " mm off this surface, and the coils are placed by their distances";
    unused.figure = Warning::Figure{farthest, "mm", same_surface_mm};
    return unused;
  }
  Vector2d most;
  for (std::size_t k = 0; k < 2; ++k) {
    std::nth_element(shifts[k].begin(), shifts[k].begin() + static_cast<std::ptrdiff_t>(placed.size() / 2),
                     shifts[k].end());
    most[static_cast<Eigen::Index>(k)] = shifts[k][placed.size() / 2];
  }
  for (std::size_t p = 0; p < placed.size(); ++p) {
    Centre& centre = layout.centres[placed[p]];
    const CoilPlace& place = *place_of(placed[p]);
    const SheetPoint from = centre.point;
    centre.point = found[p].point;
    const Vector3d& normal = surface.normal(centre.point.triangle);
    centre.axis = (place.u - place.u.dot(normal) * normal).normalized();
    centre.fixed = true;
    if (const Vector2d by = centre.drawn - place.drawn - most; by.norm() > same_place_mm)
      move(surface, centre, by);
    centre.moved = {connect(surface, from, centre.point).mm, 0};
  }
  return std::nullopt;
}

// A single coil has no neighbour that says where it lies: it lies at its drawn distance from the drawing's centre.
void place_alone(const InkedSurface& surface, ElementLayout& layout) {
  std::vector<std::size_t> own;
  for (std::size_t i = 0; i < layout.elements.size(); ++i)
    if (layout.elements[i].leader < 0) own.push_back(i);
  if (own.size() != 1 || !layout.origin || layout.centres[own.front()].fixed) return;
  Centre& centre = layout.centres[own.front()];
  Centre there = *layout.origin;
  move(surface, there, centre.drawn);
  const double moved = connect(surface, centre.point, there.point).mm;
  centre.point = there.point, centre.axis = there.axis, centre.moved = {moved, 0};
}

Result<void> place_elements(const ChartedSurface& charted, const Drawing& drawing, const Alignment& alignment,
                            const PatternSettings& pattern, const CoilSettings& settings,
                            const Context& context, Placement& out) {
  const InkedSurface& surface = charted.surface();
  ElementLayout layout = lay_by_chart(charted, drawing, alignment);
  layout.keep = settings.keep;
  // Where the user says where the drawing lies, only coils next to each other move from there.
  if (!pattern.points.empty())
    std::erase_if(layout.pairs, [](const Neighbours& pair) { return pair.weight < 1; });
  for (const Neighbours& n : layout.pairs)
    out.pairs.push_back({n.a, n.b, n.drawn_mm, geodesic_mm(surface, layout, n), 0, {}, {}});
  out.places_unused = use_places(charted, drawing, pattern, layout);
  VACUFORM_TRY(anchor, anchor_of(charted, drawing, layout, pattern, context));
  VACUFORM_CHECK(multilaterate(charted, layout.centres, layout.pairs, context, anchor));
  if (pattern.points.empty()) place_alone(surface, layout);
  follow_leaders(charted, layout);
  VACUFORM_TRY(laid, lay_on_surface(charted, layout, context));
  take_layout(surface, drawing, alignment.scale, std::move(layout), std::move(laid), out);
  return {};
}

}  // namespace

Result<Placement> place(const ChartedSurface& charted, const Drawing* drawing, const Settings& settings,
                        const Context& context, const std::vector<Edge>& cuts) {
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  VACUFORM_TRY(alignment, align(charted, settings.pattern));
  Placement out;
  Whole whole = whole_region(charted, alignment);
  if (settings.pattern.placement == PatternPlacement::segments) {
    VACUFORM_CHECK(place_segments(std::move(whole), alignment, settings.pattern, cuts, context, out));
    return out;
  }
  out.charts.push_back(std::move(whole.chart));
  const bool elements = drawing && std::any_of(drawing->elements.begin(), drawing->elements.end(),
                                               [](const Element& e) { return !e.id.empty(); });
  if (settings.pattern.placement == PatternPlacement::elements && !elements)
    return fail(Code::unusable_pattern, "the drawing has no elements", "pattern.placement",
                "give a drawing whose coils or figures are at most 150 mm across, or pattern.placement=auto");
  if (elements && settings.pattern.placement != PatternPlacement::chart)
    VACUFORM_CHECK(
        place_elements(charted, *drawing, alignment, settings.pattern, settings.coils, context, out));
  return out;
}

void take_layout(const InkedSurface& surface, const Drawing& drawing, double scale, ElementLayout layout,
                 std::vector<ElementOnSurface> laid, Placement& out) {
  out.layout = std::move(layout), out.laid = std::move(laid);
  double squares = 0;
  int counted = 0;
  for (std::size_t i = 0; i < out.pairs.size(); ++i) {
    PlacedPair& pair = out.pairs[i];
    pair.mm = geodesic_mm(surface, out.layout, out.layout.pairs[i]);
    if (!out.laid[index(pair.a)].on_head || !out.laid[index(pair.b)].on_head) continue;
    squares += (pair.mm - pair.drawn_mm) * (pair.mm - pair.drawn_mm);
    ++counted;
  }
  out.spacing_rms_mm = counted > 0 ? std::sqrt(squares / counted) : 0;
  out.warnings.clear();
  say_what_was_found(drawing, out.layout, out.laid, out.warnings);
  if (out.places_unused) out.warnings.push_back(*out.places_unused);
  out.elements.clear();
  for (std::size_t i = 0; i < out.laid.size(); ++i)
    out.elements.push_back(
        placed(surface, drawing, scale, out.layout.elements[i], out.layout.centres[i], out.laid[i]));
}

Result<Placement> on_other_face(const ChartedSurface& charted, const Drawing& drawing,
                                const Placement& placement, double scale, const Context& context) {
  Placement out = placement;
  const InkedSurface& surface = charted.surface();
  std::vector<double> turn;
  for (std::size_t i = 0; i < out.laid.size(); ++i) {
    Centre& centre = out.layout.centres[i];
    const Vector3d& normal = surface.normal(centre.point.triangle);
    centre.axis = (centre.axis - centre.axis.dot(normal) * normal).normalized();
    turn.push_back(out.laid[i].turn);
  }
  VACUFORM_TRY(laid, lay_turned(charted, out.layout, turn, context));
  out.laid = std::move(laid);
  for (std::size_t i = 0; i < out.laid.size(); ++i)
    out.elements[i] =
        placed(surface, drawing, scale, out.layout.elements[i], out.layout.centres[i], out.laid[i]);
  return out;
}

Placement lay_flat(const ChartedSurface& charted) {
  const InkedSurface& surface = charted.surface();
  const std::vector<int>& region = charted.flattening().triangles;
  Segment sheet{{{}, surface.rest(), surface.rest(), surface.inked()}, {}, 1};
  for (const int t : region) {
    sheet.triangles.push_back(static_cast<int>(sheet.triangles.size()));
    sheet.patch.triangles.push_back(surface.triangles()[t]);
  }
  Placement placement;
  placement.charts.push_back(std::move(sheet));
  return placement;
}

}  // namespace vacuform
