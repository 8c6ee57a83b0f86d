// Mesh convergence: how far the points of the formed sheet move when the spacing of the grid is halved.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "worker/forming/formed_sheet.hpp"
#include "worker/studies/preparation.hpp"

namespace vacuform {

// Statistics of distances, mm. A percentile is the smallest distance such that at least its share is no larger. All 0
// if empty.
struct DistanceStatistics {
  std::size_t count = 0;
  double mean = 0, rms = 0, p95 = 0, p99 = 0, max = 0;
};
DistanceStatistics statistics_of(std::vector<double> distances);

// Two formings of one sheet: the distance between the same points of the sheet, at the vertices of the finer grid; the
// coarser one is interpolated linearly.
struct Refinement {
  double coarse_mm = 0, fine_mm = 0;      // spacing of the grids
  DistanceStatistics head;                // what touches the mold on the finer grid
  DistanceStatistics sheet;               // all of it
  Eigen::Vector2d worst_rest{0, 0};       // the sheet point of head.max
  Eigen::Vector3d worst_formed{0, 0, 0};  // and where it lies on the finer grid
  double worst_degrees = 0;               // slope of the sheet there, from level
};

Refinement compare(const FormedSheet& coarse, const FormedSheet& fine);  // all but the spacings

struct Convergence {
  std::vector<Refinement> refinements;  // from the coarsest pair to the finest
  // log2 of the ratio of the last two mean distances on the head; present if there are two and they are conclusive.
  std::optional<double> order;
};

// Forms the sheet on the grid of the settings and on grids of the other factors of its spacing; each grid is compared
// with the next finer one. `factors` descend, with at least two entries. Memory is that of two formings. Deterministic.
// Errors: those of form().
Result<Convergence> converge(const Prepared& prepared, const Settings& settings,
                             const std::vector<double>& factors, const Context& context);

// Lengths in mm.
nlohmann::ordered_json json_of(const DistanceStatistics& statistics);
nlohmann::ordered_json json_of(const Convergence& convergence);

}  // namespace vacuform
