// The figures of DESIGN.md for closed loops and for pairs of neighbours, measured on the inked surface from the print itself.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "worker/printing/vector_print.hpp"

namespace vacuform {

// One closed loop: the largest closed centre line of an element.
struct CoilFigures {
  std::string id;
  bool on_head = true;              // all of it lies on the mold
  Eigen::Vector3d centre{0, 0, 0};  // mm
  double drawn_diameter_mm = 0;     // of the circle of equal area, in the pattern at its scale
  double diameter_mm = 0;           // of the formed loop: twice the mean geodesic radius
  double circularity = 0;           // largest |r - mean r| / mean r, r the geodesic radius from its centre
  double drawn_circularity = 0;     // the same in the drawing: 0 of a circle
  double area_error = 0;            // enclosed area on the surface / drawn - 1
  double worst_stretch = 1;         // of the plastic along the trace, formed length / flat length
  double inductance_nh = 0;
};

struct PairFigures {
  int a = 0, b = 0;                             // indices into coils
  double drawn_mm = 0, mm = 0;                  // distance of the centres: drawn, and geodesic
  double drawn_overlap_mm = 0, overlap_mm = 0;  // sum of the radii less the distance; negative: a gap
  double k = 0;                                 // coupling
};

struct CoilTable {
  std::vector<CoilFigures> coils;
  std::vector<PairFigures> pairs;
  // Over the coils and pairs that lie on the head.
  double mean_circularity = 0, worst_circularity = 0, mean_area_error = 0, worst_area_error = 0;  // of |...|
  double spacing_rms_mm = 0, worst_k = 0;
};

// Geodesics are exact on the triangles of the sheet (Xin and Wang 2009, CGAL). Deterministic. Errors: cancelled.
Result<CoilTable> measure_coils(const FormedSheet& sheet, const Flattening& flattening,
                                const VectorPrint& print, const Drawing& drawing, const Placement& placement,
                                const Settings& settings, const Context& context);

}  // namespace vacuform
