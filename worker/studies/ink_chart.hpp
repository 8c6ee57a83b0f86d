// The test sheet of `vacuform chart`: what was printed on each patch, how far forming stretches it, what was measured on
// it, and the curve of the inks (worker/colour/ink_curve.hpp) that fits.
#pragma once

#include <Eigen/Core>
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "worker/colour/ink_curve.hpp"
#include "worker/forming/formed_sheet.hpp"
#include "worker/surface/inked_surface.hpp"

namespace vacuform {

struct InkPatch {
  std::string id;
  int ink = -1;                                     // of ink_names; -1: bare plastic
  double coverage = 0;                              // printed, in [0, 1]
  int step = 1;                                     // of the mold, from the top
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // of its middle on the mold, mm
  // By the simulation, over the middle of the patch:
  double area_ratio = 1;                           // its ink is spread this much
  double least_ratio = 1, most_ratio = 1;          // anywhere on it
  double gap_mm = 0;                               // largest height of the sheet over the step
  Eigen::Vector2d rest = Eigen::Vector2d::Zero();  // on the flat sheet, mm
};

// Fills in what the simulation says, over a level square of side `across_mm` around each place. False if the sheet does
// not lie over one of them.
bool find_stretch(const FormedSheet& sheet, const InkedSurface& surface, double across_mm,
                  std::vector<InkPatch>& patches);

// chart.json without what only the caller knows: see docs/reference/files.md.
nlohmann::ordered_json patches_json(const std::vector<InkPatch>& patches);
// The patches of a chart.json, of which only id, step, ink, coverage and area_ratio are read. Errors: corrupt_file.
Result<std::vector<InkPatch>> read_patches(std::span<const std::uint8_t> json, const std::string& file_name);
// A table to fill in: patch, L, a, b.
std::string table_to_fill(const std::vector<InkPatch>& patches);

// The coverage that a patch shows of its ink, relative to the bare patch of its step.
struct MeasuredInk {
  std::size_t patch = 0;  // of the chart
  double shown = 0;       // at most 1.2; what is below -0.2 is refused
};

// Reads a CSV (comma, semicolon or tab) with a column `patch` and either `coverage` (0 to 1), or `L`, `a`, `b` (CIE
// L*a*b*, D50, 2 degrees), or `R`, `G`, `B` (sRGB, 0 to 255). Rows without values are skipped. A colour counts against
// the bare patch of the same step, or the mean of the bare patches. Errors: corrupt_file, which names line and patch.
Result<std::vector<MeasuredInk>> read_measured_patches(std::span<const std::uint8_t> csv,
                                                       const std::string& file_name,
                                                       const std::vector<InkPatch>& patches);

struct InkFit {
  InkCurveRows curve;  // for print.ink_curve, rounded to 0.001; an ink without measured patches stays linear
  std::array<int, 3> count{};  // measured patches of each ink
  std::array<double, 3> rms{},
      rms_linear{};  // of measured minus expected coverage: with the curve, and without one
  double worst = 0;  // the largest difference
  std::string worst_patch;
  std::vector<std::array<double, 2>> by_step;  // mean area ratio and rms of each step, from the top
};

// Least squares over the model shown = min(1, ink / area ratio), with ink rising from 0 and straight between the printed
// coverages of the chart. Exact for patches that are not saturated. Errors: corrupt_file (an ink with fewer than three
// coverages, or one that darkens the patches hardly or not at all).
Result<InkFit> fit_ink_curve(const std::vector<InkPatch>& patches, const std::vector<MeasuredInk>& measured,
                             const std::string& file_name);

nlohmann::ordered_json fit_json(const InkFit& fit);
std::string text_of(const InkFit& fit);

}  // namespace vacuform
