// An array of loops made for one formed head: spread evenly over a region, and overlapped critically and decoupled on the
// surface, or as much as the settings ask for.
#pragma once

#include <optional>

#include "api/settings.hpp"
#include "worker/coils/coupling_matrix.hpp"
#include "worker/placement/placement.hpp"

namespace vacuform {

inline constexpr double loop_trace_mm = 3;  // line width of the loops

struct Array {
  // Circles with the ids coil-1, coil-2... from the back to the front, around (0, 0). They form the best flat image of
  // the array: their neighbours are as far apart as on the surface, as nearly as the plane allows. Laid without an
  // offset, and with coils.decouple, they land on their places in the array with the same accuracy.
  Drawing drawing;
  std::vector<Eigen::Vector3d> centres;  // on the inked surface, mm
  double diameter_mm = 0;                // of the loops before decoupling changed their sizes
  double spacing_mm = 0;                 // mean geodesic distance of neighbours
  double spacing_rms_mm = 0;             // of the deviations from the mean
  // The strongest pair of neighbours and of all loops, as indices into drawing.elements; nothing if the loops extend
  // beyond the sheet.
  std::optional<StrongestPair> strongest_neighbours, strongest;
  int pairs = 0, off_head = 0;
};

// Loops of equal size. With a given diameter: a piece of a hexagonal lattice about the middle of the region. Fitted:
// the centres of a centroidal Voronoi tessellation of it (hexagons where it is flat, pentagons where the curvature
// needs them). Then the loops are moved to equal geodesic distances. With wish.overlap that is all. Otherwise they are
// decoupled with sizes within coils.size_limit. Where loops end off the head or stay coupled, they are spread farther from
// the border, and a given size by a tessellation; the best counts, and off_head and strongest_neighbours show it. The
// settings decouple and stretch_limit of `coils` have no effect. Deterministic. Errors: unusable_surface (they do not fit), cancelled.
Result<Array> lay_out_array(const ChartedSurface& charted, const LayoutSettings& wish,
                            const CoilSettings& coils, const Context& context);

// The drawing as an SVG in millimetres, one group per coil.
std::string svg_of_rings(const Drawing& drawing, const std::string& title);

}  // namespace vacuform
