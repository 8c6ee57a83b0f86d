// An array of loops made for one formed head: as large as lets them couple little on the surface, or spread evenly over a
// region and overlapped as much as the settings ask for.
#pragma once

#include <optional>

#include "api/settings.hpp"
#include "worker/coils/coupling_matrix.hpp"
#include "worker/placement/placement.hpp"

namespace vacuform {

struct Array {
  // Circles with the ids coil-1, coil-2... from the back to the front, around (0, 0), with their places: printed on the
  // same surface they lie there. They form the best flat image of the array: their neighbours are as far apart as on the
  // surface, as nearly as the plane allows.
  Drawing drawing;
  std::vector<Eigen::Vector3d> centres;  // on the inked surface, mm
  double diameter_mm = 0;                // of the loops before decoupling changed their sizes
  double spacing_mm = 0;                 // mean geodesic distance of neighbours
  double spacing_rms_mm = 0;             // of the deviations from the mean
  // The strongest pair of neighbours and of all loops, as indices into drawing.elements; nothing if the loops extend
  // beyond the sheet.
  std::optional<StrongestPair> strongest_neighbours, strongest;
  double k_rms = 0;                // over all pairs
  std::optional<Warning> coupled;  // "coils-coupled" (coupled_neighbours.hpp)
  int pairs = 0, off_head = 0;
  double covered = 0;  // share of the region's area that lies within a loop
};

// Loops of one size, which decoupling may change within coils.size_limit. With wish.overlap they are spread evenly
// over the region (a centroidal Voronoi tessellation, or a hexagonal lattice of a given diameter), at equal geodesic
// distances. Otherwise many ways to begin, evenly spread and hexagonal, are relaxed (array_relaxation.hpp), for a
// fitted diameter at smaller and smaller sizes. Those without gaps are laid and decoupled exactly, from the first on
// that is likely to couple by less than 0.01 rms: the result is the largest of three with neighbours below 0.01 and
// others below unnulled_k, else the largest that couples so. With more than 32 loops it is the first of them. All of it takes some
// seconds at most. Loops off the head are counted in off_head. The settings decouple and stretch_limit of `coils` have
// no effect. Deterministic. Errors: unusable_surface (they do not fit), cancelled.
Result<Array> lay_out_array(const ChartedSurface& charted, const LayoutSettings& wish,
                            const CoilSettings& coils, const Context& context);

// The drawing as an SVG in millimetres, one group per coil, with its place as `data-place`.
std::string svg_of_rings(const Drawing& drawing, const std::string& title);

}  // namespace vacuform
