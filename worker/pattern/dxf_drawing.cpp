#include "worker/pattern/dxf_drawing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "api/base/decimal.hpp"
#include "api/base/markup.hpp"
#include "api/base/utf8.hpp"
#include "api/print_step.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/pattern/dxf_file.hpp"
#include "worker/pattern/svg_path.hpp"
#include "worker/pattern/svg_size.hpp"

namespace vacuform {

namespace {

using Eigen::Affine2d;
using Eigen::AlignedBox2d;
using Eigen::Vector2d;

constexpr std::size_t most_curves = 200'000;
constexpr std::size_t most_dxf_points = 2'000'000;
constexpr int deepest_block = 16;
constexpr double farthest = 1e9;  // drawing units
constexpr double join_mm = 0.01;
constexpr double most_mm = 2000;  // no print is larger

struct DxfLine {
  Curve curve;
  std::optional<double> drawn_width;  // in drawing units: of a polyline
  std::optional<double> weight_mm;    // else
  bool filled = false;
};
struct DxfFigure {
  std::string name;
  std::string step;  // the name of its layer, if that is of drawn_layer()
  std::vector<DxfLine> lines;
};

struct DxfUnit {
  int code;
  const char* name;
  double mm;
};

constexpr std::array<DxfUnit, 10> dxf_units{{{1, "inches", 25.4},
                                             {2, "feet", 304.8},
                                             {4, "mm", 1},
                                             {5, "cm", 10},
                                             {6, "m", 1000},
                                             {8, "microinches", 25.4e-6},
                                             {9, "mils", 0.0254},
                                             {10, "yards", 914.4},
                                             {13, "microns", 1e-3},
                                             {14, "dm", 100}}};

// The polynomial pieces of a rational B-spline (L. Piegl, W. Tiller, "The NURBS Book", 1997, algorithm A4.1), by points.
std::vector<Vector2d> spline_points(const DxfEntity& e, int degree) {
  constexpr int pieces = 48;  // of each span: within 1e-4 of the radius of a quarter of a circle
  const auto x = e.numbers(10), y = e.numbers(20), knots = e.numbers(40);
  auto weights = e.numbers(41);
  const std::size_t n = x.size(), p = static_cast<std::size_t>(degree);
  if (degree < 1 || degree > 10 || n <= p || y.size() != n || knots.size() != n + p + 1) return {};
  if (!std::is_sorted(knots.begin(), knots.end())) return {};
  if (weights.size() != n) weights.assign(n, 1);
  const auto at = [&](double t, std::size_t span) {
    std::vector<Eigen::Vector3d> d(p + 1);
    for (std::size_t j = 0; j <= p; ++j) {
      const std::size_t i = span - p + j;
      d[j] = Eigen::Vector3d(x[i], y[i], 1) * weights[i];
    }
    for (std::size_t r = 1; r <= p; ++r)
      for (std::size_t j = p; j >= r; --j) {
        const double low = knots[j + span - p], high = knots[j + 1 + span - r];
        const double a = high > low ? (t - low) / (high - low) : 0;
        d[j] = (1 - a) * d[j - 1] + a * d[j];
      }
    return Vector2d(d[p].head<2>() / d[p].z());
  };
  std::vector<Vector2d> points;
  for (std::size_t span = p; span < n; ++span) {
    if (!(knots[span + 1] > knots[span])) continue;
    for (int k = points.empty() ? 0 : 1; k <= pieces; ++k)
      points.push_back(at(knots[span] + (knots[span + 1] - knots[span]) * k / pieces, span));
    if (points.size() > most_dxf_points) return {};
  }
  return points;
}

class DxfReader {
 public:
  DxfReader(const DxfFile& file, const std::string& file_name, const PatternSettings& settings)
      : file_(file), file_name_(file_name), settings_(settings) {}

  Result<SizedSvg> run() {
    for (const DxfEntity& e : file_.entities) VACUFORM_CHECK(draw(e, {}));
    if (curves_ == 0)
      return fail(Code::unusable_pattern, "the DXF has no lines" + left_out_text(": left out are "),
                  file_name_, "export the model with its lines, or save the drawing as SVG");
    VACUFORM_CHECK(check_widths());
    VACUFORM_TRY(scale, find_scale());
    for (auto& [key, figure] : figures_) join(figure, scale);
    write(scale);
    if (const std::string left_out = left_out_text(""); !left_out.empty()) {
      Warning warning{"pattern-left-out", "Parts of the DXF are not drawn: " + left_out + "."};
      warning.place = "the drawing";
      out_.warnings.push_back(std::move(warning));
    }
    return std::move(out_);
  }

 private:
  struct Place {
    Affine2d to_model = Affine2d::Identity();
    std::string figure;  // of a block
    std::string_view layer;
    std::optional<double> weight_mm;
    int depth = 0;
  };

  Result<void> unusable(const std::string& what, const std::string& fix) const {
    return fail(Code::unusable_pattern, "the DXF " + what, file_name_, fix);
  }
  Result<void> too_much() const {
    return fail(Code::too_large,
                "the DXF draws more than " + std::to_string(most_curves) +
                    " curves, or nests blocks more than " + std::to_string(deepest_block) + " deep",
                file_name_, "simplify the drawing");
  }

  // What is not drawn, by kinds.
  std::string left_out_text(const std::string& before) const {
    std::string text;
    for (const auto& [kind, count] : left_out_)
      text += (text.empty() ? before : ", ") + std::to_string(count) + " " + kind;
    if (file_.on_paper > 0)
      text += (text.empty() ? before : ", ") + std::to_string(file_.on_paper) + " on layouts";
    return text;
  }

  Result<void> draw(const DxfEntity& e, const Place& place) {
    if (++entities_ > most_dxf_points) return too_much();
    const std::string_view own = e.text(8), layer = own == "0" && place.depth > 0 ? place.layer : own;
    const auto known = file_.layers.find(layer);
    if (known != file_.layers.end() && !known->second.drawn) {
      ++left_out_["on layers that are off"];
      return {};
    }
    const double up = e.number_or(230, 1);
    if (std::abs(e.number_or(210, 0)) > 1e-6 || std::abs(e.number_or(220, 0)) > 1e-6)
      return unusable("has shapes that do not lie in the xy plane", "project the drawing onto the xy plane");
    Place here = place;
    here.layer = layer;
    // -1, as after mirroring in the program: x counts the other way round. Lines and splines have no such frame.
    const bool own_frame = e.type != "LINE" && e.type != "SPLINE" && e.type != "ELLIPSE";
    if (up < 0 && own_frame) here.to_model.scale(Vector2d(-1, 1));
    const auto weight = e.number(370);
    if (weight && *weight > 0)
      here.weight_mm = *weight / 100;
    else if (weight != -2.0)
      here.weight_mm = known != file_.layers.end() ? known->second.line : std::nullopt;
    if (e.type == "INSERT") return insert(e, here);
    return shape(e, here, up);
  }

  Result<void> insert(const DxfEntity& e, const Place& place) {
    const auto block = file_.blocks.find(e.text(2));
    if (block == file_.blocks.end()) {
      ++left_out_["blocks that are missing"];
      return {};
    }
    if (place.depth >= deepest_block) return too_much();
    const double columns = std::max(1.0, e.number_or(70, 1)), rows = std::max(1.0, e.number_or(71, 1));
    if (!(columns * rows <= static_cast<double>(most_curves))) return too_much();
    Affine2d turned = place.to_model;
    turned.translate(Vector2d(e.number_or(10, 0), e.number_or(20, 0)))
        .rotate(e.number_or(50, 0) * M_PI / 180);
    for (int row = 0; row < static_cast<int>(rows); ++row)
      for (int column = 0; column < static_cast<int>(columns); ++column) {
        Place inside = place;
        inside.to_model = turned;
        inside.to_model.translate(Vector2d(column * e.number_or(44, 0), row * e.number_or(45, 0)))
            .scale(Vector2d(e.number_or(41, 1), e.number_or(42, 1)))
            .translate(-Vector2d(block->second.x, block->second.y));
        ++inside.depth;
        if (inside.figure.empty())
          inside.figure = std::to_string(++blocks_) + " " + std::string(block->first);
        for (const DxfEntity& each : block->second.entities) VACUFORM_CHECK(draw(each, inside));
      }
    return {};
  }

  Result<void> shape(const DxfEntity& e, const Place& place, double up) {
    CurveBuilder path;
    std::optional<double> width;
    const Vector2d at(e.number_or(10, 0), e.number_or(20, 0));
    const auto polar = [&](double degrees) {
      return Vector2d(at + e.number_or(40, 0) *
                               Vector2d(std::cos(degrees * M_PI / 180), std::sin(degrees * M_PI / 180)));
    };
    bool filled = false;
    if (e.type == "LINE") {
      if (std::abs(e.number_or(30, 0) - e.number_or(31, 0)) > 1e-6)
        return unusable("has lines that do not lie in the xy plane", "project the drawing onto the xy plane");
      path.move_to(at);
      path.line_to({e.number_or(11, 0), e.number_or(21, 0)});
    } else if (e.type == "CIRCLE") {
      const double r = e.number_or(40, 0);
      if (!(r > 0)) return {};
      return add(svg_ellipse(at, {r, r}), width, filled, place);
    } else if (e.type == "ARC") {
      const double r = e.number_or(40, 0), first = e.number_or(50, 0);
      if (!(r > 0)) return {};
      double sweep = std::fmod(e.number_or(51, 0) - first, 360.0);
      if (!(sweep > 0)) sweep += 360;
      path.move_to(polar(first));
      path.arc_to({r, r}, 0, false, true, polar(first + sweep / 2));
      path.arc_to({r, r}, 0, false, true, sweep < 360 ? polar(first + sweep) : polar(first));
      if (sweep >= 360) path.close();
    } else if (e.type == "ELLIPSE") {
      ellipse(e, at, up, path);
    } else if (e.type == "LWPOLYLINE" || e.type == "POLYLINE") {
      VACUFORM_TRY(drawn, polyline(e, path, width));
      if (!drawn) return {};
    } else if (e.type == "SPLINE") {
      const int flags = static_cast<int>(std::clamp(e.number_or(70, 0), 0.0, 1e6));
      const auto z = e.numbers(30);
      if (!z.empty() && *std::max_element(z.begin(), z.end()) - *std::min_element(z.begin(), z.end()) > 1e-6)
        return unusable("has splines that do not lie in the xy plane",
                        "project the drawing onto the xy plane");
      const auto points = spline_points(e, static_cast<int>(std::clamp(e.number_or(71, 0), 0.0, 100.0)));
      if (points.empty()) {
        ++left_out_["SPLINE without usable control points"];
        return {};
      }
      path.move_to(points.front());
      for (const Vector2d& p : points) path.line_to(p);
      if ((flags & 1) != 0) path.close();
    } else if (e.type == "SOLID" || e.type == "TRACE") {
      // Its third and fourth corner are the other way round.
      path.move_to(at);
      for (const int corner : {1, 3, 2})
        path.line_to({e.number_or(10 + corner, at.x()), e.number_or(20 + corner, at.y())});
      path.close();
      filled = true;
    } else {
      ++left_out_[std::string(e.type.substr(0, 32))];
      return {};
    }
    return add(path.finish(), width, filled, place);
  }

  static void ellipse(const DxfEntity& e, const Vector2d& centre, double up, CurveBuilder& path) {
    const Vector2d major(e.number_or(11, 0), e.number_or(21, 0));
    const double ratio = e.number_or(40, 1), first = e.number_or(41, 0);
    double sweep = e.number_or(42, 2 * M_PI) - first;
    if (!(sweep > 0)) sweep += 2 * M_PI;
    const Vector2d minor = (up < 0 ? -ratio : ratio) * Vector2d(-major.y(), major.x());
    const auto point = [&](double t) { return Vector2d(centre + std::cos(t) * major + std::sin(t) * minor); };
    const double turned = std::atan2(major.y(), major.x()) * 180 / M_PI;
    const Vector2d radii(major.norm(), std::abs(ratio) * major.norm());
    if (!(radii.minCoeff() > 0)) return;
    const bool counter_clockwise = (up >= 0) == (ratio >= 0);
    path.move_to(point(first));
    path.arc_to(radii, turned, false, counter_clockwise, point(first + sweep / 2));
    const bool whole = sweep >= 2 * M_PI - 1e-9;
    path.arc_to(radii, turned, false, counter_clockwise, point(whole ? first : first + sweep));
    if (whole) path.close();
  }

  struct Corner {
    Vector2d at;
    double bulge = 0;
    double begin = 0, end = 0;  // width
  };

  // False if it is of a kind that is not drawn.
  Result<bool> polyline(const DxfEntity& e, CurveBuilder& path, std::optional<double>& width) {
    const int flags = static_cast<int>(std::clamp(e.number_or(70, 0), 0.0, 1e6));
    std::vector<Corner> corners;
    std::optional<double> height;
    if (e.type == "POLYLINE") {
      if ((flags & (16 | 64)) != 0) {
        ++left_out_["meshes"];
        return false;
      }
      for (const DxfEntity& v : e.vertices) {
        if ((static_cast<int>(std::clamp(v.number_or(70, 0), 0.0, 1e6)) & 16) != 0)
          continue;  // controls a curve
        const double z = v.number_or(30, 0);
        if (std::abs(z - height.value_or(z)) > 1e-6)
          return fail(Code::unusable_pattern, "the DXF has polylines that do not lie in the xy plane",
                      file_name_, "project the drawing onto the xy plane");
        height = z;
        corners.push_back({{v.number_or(10, 0), v.number_or(20, 0)},
                           v.number_or(42, 0),
                           v.number_or(40, e.number_or(40, 0)),
                           v.number_or(41, e.number_or(41, 0))});
      }
    } else {
      const double all = e.number_or(43, 0);
      for (const DxfGroup& group : e.groups) {
        const double value = dxf_number(group.value).value_or(0);
        if (group.code == 10) corners.push_back({{value, 0}, 0, all, all});
        if (corners.empty()) continue;
        Corner& last = corners.back();
        if (group.code == 20) last.at.y() = value;
        if (group.code == 40) last.begin = value;
        if (group.code == 41) last.end = value;
        if (group.code == 42) last.bulge = value;
      }
    }
    if (corners.size() < 2) return false;
    const bool closed = (flags & 1) != 0;
    const std::size_t sides = corners.size() - (closed ? 0 : 1);
    for (std::size_t i = 0; i < sides; ++i)
      if (std::abs(corners[i].begin - corners[0].begin) > 1e-9 ||
          std::abs(corners[i].end - corners[0].begin) > 1e-9)
        return fail(Code::unusable_pattern, "the DXF has polylines whose width changes", file_name_,
                    "give each its own constant width, or turn them into outlines");
    if (corners[0].begin > 0) width = corners[0].begin;
    path.move_to(corners[0].at);
    for (std::size_t i = 0; i < sides; ++i) {
      const Vector2d &a = corners[i].at, &b = corners[(i + 1) % corners.size()].at;
      const double bulge = corners[i].bulge, chord = (b - a).norm();
      if (bulge == 0 || !(chord > 0)) {
        if (chord > 0) path.line_to(b);
        continue;
      }
      // A bulge is the tangent of a quarter of the arc's angle.
      const double r = chord * (1 + bulge * bulge) / (4 * std::abs(bulge));
      path.arc_to({r, r}, 0, std::abs(bulge) > 1, bulge > 0, b);
    }
    if (closed) path.close();
    return true;
  }

  Result<void> add(std::vector<Curve> curves, const std::optional<double>& width, bool filled,
                   const Place& place) {
    for (Curve& curve : curves) {
      points_ += curve.points.size();
      if (++curves_ > most_curves || points_ > most_dxf_points) return too_much();
      for (Vector2d& p : curve.points) {
        p = place.to_model * p;
        if (!p.allFinite() || p.cwiseAbs().maxCoeff() > farthest)
          return unusable("has coordinates that are no places", "check the shapes far away");
      }
      box_.extend(box_of(curve));
      DxfLine line{std::move(curve), {}, place.weight_mm, filled};
      if (width) line.drawn_width = *width * std::sqrt(std::abs(place.to_model.linear().determinant()));
      // Layers in the order in which they are first drawn on; each place of a block is a figure of its own, on each step
      // of printing.
      const std::string step = drawn_layer(place.layer) ? std::string(place.layer) : std::string();
      const std::string key = place.figure.empty()
                                  ? "layer " + std::string(place.layer)
                                  : std::string("block ").append(place.figure).append("\n").append(step);
      const auto [at, made] = index_.emplace(key, figures_.size());
      if (made)
        figures_.push_back({key,
                            {.name = place.figure.empty() ? std::string(place.layer)
                                                          : place.figure.substr(place.figure.find(' ') + 1),
                             .step = step,
                             .lines = {}}});
      figures_[at->second].second.lines.push_back(std::move(line));
    }
    return {};
  }

  Result<void> check_widths() {
    std::size_t without = 0;
    for (auto& [key, figure] : figures_)
      for (DxfLine& line : figure.lines) {
        if (line.filled || line.drawn_width || line.weight_mm) continue;
        ++without;
        line.weight_mm = settings_.line_mm;
      }
    if (without == 0 || settings_.line_mm) return {};
    return unusable(
        "has " + std::to_string(without) + " of " + std::to_string(curves_) + " lines without a width",
        "say how wide they are printed, for example pattern.line_mm=2");
  }

  // Millimetres of a drawing unit.
  Result<double> find_scale() {
    double weight = 0, drawn = 0;  // half of the widest line
    for (const auto& [key, figure] : figures_)
      for (const DxfLine& line : figure.lines) {
        if (line.filled) continue;
        if (line.drawn_width)
          drawn = std::max(drawn, *line.drawn_width / 2);
        else
          weight = std::max(weight, *line.weight_mm / 2);
      }
    const Vector2d sides = box_.sizes();
    const auto page = [&](double scale) {
      return Vector2d(scale * sides + Vector2d::Constant(2 * std::max(weight, drawn * scale)));
    };
    double scale = 0;
    if (settings_.width_mm) {
      if (sides.x() > 0) scale = (*settings_.width_mm - 2 * weight) / sides.x();
      if (sides.x() + 2 * drawn > 0) scale = std::min(scale, *settings_.width_mm / (sides.x() + 2 * drawn));
      if (!(scale > 0))
        return fail(Code::unusable_pattern, "the lines of the DXF are wider than the drawing", file_name_,
                    "give a larger pattern.width_mm");
      out_.size_from =
          "a width of " + short_decimal(*settings_.width_mm, 8) + " mm, as pattern.width_mm says";
    } else {
      const auto unit = std::find_if(dxf_units.begin(), dxf_units.end(),
                                     [&](const DxfUnit& u) { return u.code == file_.units; });
      if (unit == dxf_units.end())
        return ask_unit(page, "the DXF does not say its unit ($INSUNITS): it is " +
                                  short_decimal(box_.sizes().x(), 6) + " x " +
                                  short_decimal(box_.sizes().y(), 6));
      // Many never set the unit, which is inches in an empty drawing of AutoCAD.
      if (page(unit->mm).maxCoeff() > most_mm)
        return ask_unit(page, "the DXF is " + size_text(page(unit->mm)) + " large, in " + unit->name +
                                  " as its $INSUNITS says");
      scale = unit->mm;
      out_.size_from = short_decimal(sides.x(), 6) + " x " + short_decimal(sides.y(), 6) + " " + unit->name +
                       ", as its $INSUNITS says";
    }
    size_mm_ = page(scale);
    out_.size_mm = size_mm_;
    margin_mm_ = std::max(weight, drawn * scale);
    return scale;
  }

  template <class Page>
  tl::unexpected<Error> ask_unit(const Page& page, const std::string& what) const {
    std::vector<Proposal> proposals;
    for (const int code : {4, 5, 1, 9}) {
      const auto unit =
          std::find_if(dxf_units.begin(), dxf_units.end(), [&](const DxfUnit& u) { return u.code == code; });
      const Vector2d mm = page(unit->mm);
      if (mm.x() >= 5 && mm.maxCoeff() <= most_mm)
        proposals.push_back({{{"pattern.width_mm", std::round(1000 * mm.x()) / 1000}},
                             size_text(mm) + ", if it is drawn in " + unit->name});
    }
    return fail(Code::unusable_pattern, what, file_name_, "say how large it is", std::move(proposals),
                "set the unit in the program that made it");
  }

  // Makes one line of those whose ends meet, where no third one does.
  static void join(DxfFigure& figure, double scale) {
    const double reach = join_mm / scale;
    std::vector<DxfLine>& lines = figure.lines;
    using Cell = std::pair<std::int64_t, std::int64_t>;
    const auto cell_of = [&](const Vector2d& p) {
      return Cell(std::llround(p.x() / reach), std::llround(p.y() / reach));
    };
    const auto end_of = [&](std::size_t end) -> const Vector2d& {
      const auto& points = lines[end / 2].curve.points;
      return end % 2 == 0 ? points.front() : points.back();
    };
    std::multimap<Cell, std::size_t> ends;
    const auto open = [&](std::size_t i) { return !lines[i].curve.closed && !lines[i].filled; };
    for (std::size_t i = 0; i < lines.size(); ++i)
      if (open(i))
        for (const std::size_t end : {2 * i, 2 * i + 1}) ends.emplace(cell_of(end_of(end)), end);
    // The only other end at an end; its own number if there is none or more than one.
    const auto partner = [&](std::size_t end) {
      std::size_t found = end, count = 0;
      const Cell cell = cell_of(end_of(end));
      for (std::int64_t dx = -1; dx <= 1; ++dx)
        for (std::int64_t dy = -1; dy <= 1; ++dy)
          for (auto [at, last] = ends.equal_range({cell.first + dx, cell.second + dy});
               at != last && count < 2; ++at)
            if (at->second != end && (end_of(at->second) - end_of(end)).norm() <= reach)
              found = at->second, ++count;
      return count == 1 ? found : end;
    };
    std::vector<std::size_t> mate(2 * lines.size());
    for (std::size_t end = 0; end < mate.size(); ++end) mate[end] = open(end / 2) ? partner(end) : end;
    const auto joined = [&](std::size_t end) {
      return mate[end] != end && mate[mate[end]] == end && same_width(lines[end / 2], lines[mate[end] / 2]);
    };
    std::vector<DxfLine> out;
    std::vector<bool> done(lines.size());
    const auto follow = [&](std::size_t first) {  // from that end of its line
      DxfLine chain = lines[first / 2];
      if (first % 2 == 1) std::reverse(chain.curve.points.begin(), chain.curve.points.end());
      done[first / 2] = true;
      std::size_t end = first ^ 1;
      while (joined(end) && !done[mate[end] / 2]) {
        const std::size_t next = mate[end];
        std::vector<Vector2d> more = lines[next / 2].curve.points;
        if (next % 2 == 1) std::reverse(more.begin(), more.end());
        chain.curve.points.insert(chain.curve.points.end(), more.begin() + 1, more.end());
        done[next / 2] = true;
        end = next ^ 1;
      }
      chain.curve.closed = joined(end) && mate[end] == first;
      out.push_back(std::move(chain));
    };
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (!open(i)) {
        out.push_back(lines[i]);
        done[i] = true;
      }
    }
    for (std::size_t i = 0; i < lines.size(); ++i)
      for (const std::size_t end : {2 * i, 2 * i + 1})
        if (!done[i] && !joined(end)) follow(end);
    for (std::size_t i = 0; i < lines.size(); ++i)
      if (!done[i]) follow(2 * i);
    lines = std::move(out);
  }
  static bool same_width(const DxfLine& a, const DxfLine& b) {
    return a.drawn_width == b.drawn_width && (a.drawn_width || a.weight_mm == b.weight_mm);
  }

  // Old files have names in the code page of their country.
  static std::string plain_name(const std::string& name) {
    const auto points = code_points(name);
    const bool plain =
        points && std::all_of(points->begin(), points->end(), [](char32_t c) { return c >= 32; });
    return plain ? name : "figure";
  }

  void write(double scale) {
    std::string& svg = out_.text;
    const auto number = [](double value) { return short_decimal(value, 12); };
    svg =
        "<svg xmlns=\"http://www.w3.org/2000/svg\" "
        "xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" width=\"" +
        number(size_mm_.x()) + "mm\" height=\"" + number(size_mm_.y()) + "mm\" viewBox=\"0 0 " +
        number(size_mm_.x()) + " " + number(size_mm_.y()) +
        "\" fill=\"none\" stroke=\"#000\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n";
    const auto point = [&](const Vector2d& p) {
      return number(margin_mm_ + scale * (p.x() - box_.min().x())) + " " +
             number(margin_mm_ + scale * (box_.max().y() - p.y()));
    };
    for (const auto& [key, figure] : figures_) {
      svg += "<g id=\"" + escaped(plain_name(figure.name)) + "\"";
      if (!figure.step.empty()) svg += " inkscape:label=\"" + escaped(figure.step) + "\"";
      svg += ">\n";
      for (const DxfLine& line : figure.lines) {
        const auto& p = line.curve.points;
        svg += "<path d=\"M" + point(p[0]);
        for (std::size_t i = 1; i + 2 < p.size(); i += 3)
          svg += "C" + point(p[i]) + " " + point(p[i + 1]) + " " + point(p[i + 2]);
        if (line.curve.closed) svg += "Z";
        const double width = line.drawn_width ? *line.drawn_width * scale : line.weight_mm.value_or(0);
        // Programs end a polyline of a width flat, and a line of a weight round.
        svg += line.filled ? "\" fill=\"#000\" stroke=\"none\"/>\n"
                           : "\" stroke-width=\"" + number(width) +
                                 (line.drawn_width ? "\" stroke-linecap=\"butt\"/>\n" : "\"/>\n");
      }
      svg += "</g>\n";
    }
    svg += "</svg>\n";
  }

  const DxfFile& file_;
  const std::string& file_name_;
  const PatternSettings& settings_;
  std::vector<std::pair<std::string, DxfFigure>> figures_;
  std::map<std::string, std::size_t> index_, left_out_;
  AlignedBox2d box_;
  std::size_t entities_ = 0, curves_ = 0, points_ = 0, blocks_ = 0;
  Vector2d size_mm_{0, 0};
  double margin_mm_ = 0;
  SizedSvg out_;
};

}  // namespace

Result<SizedSvg> dxf_drawing(std::string_view text, const std::string& file_name,
                             const PatternSettings& settings) {
  VACUFORM_TRY(file, read_dxf_file(text, file_name));
  return DxfReader(file, file_name, settings).run();
}

}  // namespace vacuform
