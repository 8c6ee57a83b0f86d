// The figures for coils and for pairs of neighbours, measured on the inked surface, for the print itself and for the
// plain drawing printed as it is. A *coil* is an element of the drawing with a loop (worker/pattern/drawn_loop.hpp).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "worker/coils/coupling_matrix.hpp"
#include "worker/flattening/flattening.hpp"
#include "worker/inspection/both.hpp"
#include "worker/inspection/shape_distance.hpp"
#include "worker/placement/alignment.hpp"
#include "worker/printing/vector_print.hpp"

namespace vacuform {

// One closed trace as it lies on the flat sheet, ready to be formed.
struct FlatLoop {
  std::vector<Eigen::Vector2d>
      line;  // closed polyline, sheet coordinates, mm; empty: the print does not contain all of it
  Eigen::Vector2d near{0, 0};  // a point near its centre, sheet coordinates, mm
};

// The target from the drawing at pattern.scale, and both ways of printing it.
struct CoilLoops : Both<FlatLoop> {
  std::string id;
  Eigen::Vector2d drawn_centre{0, 0};  // mm, at pattern.scale
  double drawn_diameter_mm = 0;        // twice the mean radius from its least squares centre
  double drawn_area_mm2 = 0;
  double drawn_circularity = 0;        // largest |r - mean r| / mean r: 0 of a circle
  std::vector<Eigen::Vector2d> drawn;  // the closed line itself, counter-clockwise
  double size = 1;                     // that decoupling gave it, against the drawing
  double moved_mm = 0;                 // by the placement, from where the chart puts it
  double trace_mm = 0;                 // width of the line once formed
  bool smooth = true;                  // see PlacedElement
  bool reverse = false;                // `with` lies on the other face
};

// The coils of the drawing, in its order, on the `faces` of its elements (1: the other one): `with` from the print, `without` from the drawing laid flat on the sheet. The
// centre of the flat drawing is on the point of the sheet that lands on the top of the mold, and the settings rotate
// and move it.
std::vector<CoilLoops> coil_loops(const Drawing& drawing, const Placement& placement,
                                  const VectorPrint& print, const Flattening& flattening,
                                  const Alignment& alignment, const std::vector<int>& faces = {});

struct NeighbourLoops {
  int a = 0, b = 0;                // indices into the coils, a < b
  std::optional<double> k_before;  // coupling before decoupling moved and resized them
};
// The pairs of the placement; without any, loops that overlap or nearly touch in the drawing: their centres are at most
// 1.15 times the sum of their radii apart.
std::vector<NeighbourLoops> neighbours(const std::vector<CoilLoops>& coils, const Placement& placement,
                                       const Drawing& drawing);

// One way of printing it, formed. Errors are relative to the drawing at the `size` of the coil.
struct CoilFigures {
  bool on_head = false;             // all of it lies on the chart
  Eigen::Vector3d centre{0, 0, 0};  // on the inked surface, mm
  double diameter_mm = 0;           // twice the mean geodesic radius
  double diameter_error = 0;        // against the drawn one, as a ratio less 1
  double circularity = 0;           // largest |r - mean r| / mean r, r the geodesic radius from its centre
  ShapeDistance shape;              // of LoopFigures::shape from the drawn one
  double shape_error = 0;           // shape.largest_mm as a share of the drawn diameter
  double area_mm2 = 0;              // enclosed, on the surface
  double area_error = 0;            // against the drawn one, as a ratio less 1
  double worst_stretch = 1;         // of the plastic along the trace, formed length / flat length
  std::optional<double> inductance_nh;
};
// A way has no figures if the coil lies off the sheet, or is not printed whole.
struct Coil : Both<std::optional<CoilFigures>> {
  std::string id;
  double drawn_diameter_mm = 0, drawn_area_mm2 = 0, drawn_circularity = 0, size = 1, moved_mm = 0;
  bool smooth = true;

  double radius_mm() const { return size * drawn_diameter_mm / 2; }
  // Drawn as a circle, so that circularity shows the accuracy. Other shapes are only compared with the drawn shape.
  bool round() const { return drawn_circularity < 0.005; }
};

struct PairFigures {
  double mm = 0;            // geodesic distance of the centres
  double overlap_mm = 0;    // sum of the radii less that distance; negative: a gap
  std::optional<double> k;  // coupling
};
struct CoilPair : Both<std::optional<PairFigures>> {
  int a = 0, b = 0;                           // indices into coils
  double drawn_mm = 0, drawn_overlap_mm = 0;  // in the drawing at pattern.scale
  std::optional<double> k_before;             // before decoupling
};

// Two coils on the head, and how they couple.
struct CoupledPair {
  int a = 0, b = 0;  // indices into coils, a < b
  double mm = 0;     // geodesic distance of the centres
  double k = 0;      // with its sign
};

// Over the coils, and the pairs of coils, that lie on the head.
struct CoilSummary {
  int coils = 0, pairs = 0;
  int round = 0;                                       // of the coils, those that are drawn as circles
  double mean_circularity = 0, worst_circularity = 0;  // of these
  double mean_shape_error = 0, worst_shape_error = 0;
  double mean_diameter_error = 0, worst_diameter_error = 0, mean_area_error = 0,
         worst_area_error = 0;                      // of |...|
  double spacing_rms_mm = 0, worst_spacing_mm = 0;  // of the distance less the drawn one
  std::optional<CoupledPair> strongest_neighbours;  // of `pairs`, by |k|
  std::optional<CoupledPair> strongest;             // of all pairs of coils, neighbours or not, by |k|
};

class MeasuredSheet;
// The inked face, and the other one if coils lie there.
struct MeasuredFaces {
  const MeasuredSheet& first;
  const MeasuredSheet* reverse = nullptr;
};

// All coils, with the summary of each way.
struct CoilTable : Both<CoilSummary> {
  std::vector<Coil> coils;
  std::vector<CoilPair> pairs;
  // Of all coils, by their index; NaN of coils that lack figures or an inductance.
  Both<CouplingMatrix> k;
  // What the coils preserve, and what shape_error therefore compares: their shape at the drawn area, or at the drawn
  // distances from their centre along the surface. Empty: laid on charts, which preserve neither; compared by area.
  std::optional<CoilKeep> keep;
};

// Geodesics are exact on the triangles of the sheet (exact_geodesics.hpp). Deterministic for any number of threads.
// Errors: cancelled.
Result<CoilTable> measure_coils(const MeasuredFaces& sheet, const std::vector<CoilLoops>& loops,
                                const std::vector<NeighbourLoops>& pairs, std::optional<CoilKeep> keep,
                                const Context& context);
}  // namespace vacuform
