#include "worker/inspection/stretched_traces.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "api/base/decimal.hpp"
#include "worker/inspection/loop_figures.hpp"
#include "worker/pattern/curve.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double piece_mm = 1;  // of the flat sheet
constexpr std::size_t most_marks = 20;

struct Piece {
  double flat = 0, formed = 0;
  Vector3d from{0, 0, 0}, to{0, 0, 0};
  double stretch() const { return formed / flat; }
};

// About a millimetre each; skips what lies off the sheet.
std::vector<Piece> pieces_of(const MeasuredSheet& sheet, const Curve& curve) {
  std::vector<Vector2d> line;
  for (const CurvePoint& point : flatten(curve, {})) line.push_back(point.at);
  line = densified(line, piece_mm / 4, false);
  std::vector<Piece> pieces;
  Piece piece;
  Vector3d last(0, 0, 0);
  bool follows = false;  // `last` is the previous point
  for (std::size_t i = 0; i < line.size(); ++i) {
    const auto at = sheet.find(line[i]);
    const Vector3d place = at ? sheet.place(*at) : Vector3d(0, 0, 0);
    if (at && follows) {
      if (piece.flat == 0) piece.from = last;
      piece.flat += (line[i] - line[i - 1]).norm();
      piece.formed += (place - last).norm();
      piece.to = place;
    }
    if (piece.flat >= piece_mm || ((!at || i + 1 == line.size()) && piece.flat > piece_mm / 4)) {
      pieces.push_back(piece);
      piece = {};
    }
    if (!at) piece = {};
    last = place, follows = at.has_value();
  }
  return pieces;
}

// A connected part of a line that is stretched beyond the limit.
struct Run {
  std::vector<Vector3d> points;
  double worst = 0;
  Vector3d place{0, 0, 0};

  void add(const Piece& piece) {
    points.push_back(piece.from), points.push_back(piece.to);
    if (piece.stretch() > worst) worst = piece.stretch(), place = (piece.from + piece.to) / 2;
  }
  double across() const {
    Vector3d low = points.front(), high = low;
    for (const Vector3d& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
    return (high - low).norm();
  }
};

void take(const std::vector<Piece>& pieces, double limit, StretchedTrace& trace, std::vector<Run>& runs) {
  bool in_run = false;
  for (const Piece& piece : pieces) {
    const bool beyond = piece.stretch() > 1 + limit;
    trace.length_mm += piece.formed;
    if (piece.stretch() > trace.worst_stretch)
      trace.worst_stretch = piece.stretch(), trace.worst_place = (piece.from + piece.to) / 2;
    if (beyond) {
      if (!in_run) runs.emplace_back();
      runs.back().add(piece);
      trace.stretched_mm += piece.formed;
    }
    in_run = beyond;
  }
}

Warning warning_of(const TraceFigures& figures) {
  const std::size_t count = figures.stretched.size();
  Warning warning{"trace-stretched", "", {}};
  for (const StretchedTrace& trace : figures.stretched)
    warning.marks.insert(warning.marks.end(), trace.marks.begin(), trace.marks.end());
  warning.marks.resize(std::min(warning.marks.size(), most_marks));
  const std::string& worst = figures.stretched.front().id;
  warning.text = std::to_string(count) + " of " + std::to_string(figures.traces) +
                 (count == 1 ? " traces is" : " traces are") + " stretched by more than the " +
                 decimal(100 * figures.limit, 0) + " % that the ink withstands (coils.stretch_limit), over " +
                 decimal(figures.stretched_mm, 0) + " of " + decimal(figures.length_mm, 0) +
                 " mm; the worst, " + (worst.empty() ? "a line between elements" : worst) + ", by " +
                 in_percent(figures.stretched.front().worst_stretch - 1) + ".";
  warning.figure =
      Warning::Figure{100 * (figures.stretched.front().worst_stretch - 1), "%", 100 * figures.limit};
  return warning;
}

}  // namespace

TraceFigures measure_traces(const MeasuredSheet& measured, const VectorPrint& print, double stretch_limit) {
  TraceFigures out;
  out.limit = stretch_limit;
  // A line in no element may come in several parts, between the elements.
  std::vector<StretchedTrace> traces;
  std::map<std::string, std::size_t> known;
  std::vector<std::vector<Run>> runs;
  for (const PrintedElement& element : print.elements)
    for (const Centreline& line : element.centrelines) {
      const auto pieces = pieces_of(measured, line.curve);
      if (pieces.empty()) continue;
      const auto [found, is_new] = known.emplace(element.id, traces.size());
      if (is_new) traces.push_back({element.id, 1, {0, 0, 0}, 0, 0, {}}), runs.emplace_back();
      take(pieces, stretch_limit, traces[found->second], runs[found->second]);
    }
  for (std::size_t i = 0; i < traces.size(); ++i) {
    StretchedTrace& trace = traces[i];
    ++out.traces;
    out.length_mm += trace.length_mm, out.stretched_mm += trace.stretched_mm;
    out.worst_stretch = std::max(out.worst_stretch, trace.worst_stretch);
    if (runs[i].empty()) continue;
    std::stable_sort(runs[i].begin(), runs[i].end(),
                     [](const Run& a, const Run& b) { return a.worst > b.worst; });
    for (const Run& run : runs[i])
      trace.marks.push_back({{run.place.x(), run.place.y(), run.place.z()}, run.across()});
    out.stretched.push_back(std::move(trace));
  }
  std::stable_sort(
      out.stretched.begin(), out.stretched.end(),
      [](const StretchedTrace& a, const StretchedTrace& b) { return a.worst_stretch > b.worst_stretch; });
  if (!out.stretched.empty()) out.warnings.push_back(warning_of(out));
  return out;
}

}  // namespace vacuform
