// The scan stage: bytes of a scan in, a mold on the platform out.
//
// A scan is read (STL, OBJ, PLY, OFF, GLB), welded, reduced to its outer skin, turned right side out, scaled to
// millimetres, turned with its up axis to +Z, closed, offset by the clearance, trimmed, and placed on the platform,
// which is z = 0. The centre of the smallest circle around the mold, seen from above, lies at x = y = 0: the mold fits
// the smallest round window, and stays in place when it is turned.
//
// The automatic trim is the lowest cut above which no undercut is deeper than R / 70 and larger than R^2 / 300, where R
// is the radius of the smallest circle around the scan seen from above: 1.5 mm and 36 mm2 on an adult head. On a sphere
// that is 0.17 R below the equator. Grain is not an undercut: if the noise of the surface is more than R / 500 and 5 % of
// an edge, the cut is chosen on a smoothed copy, and the mold keeps the surface as it is. The cut does not change if the
// scan is turned about the vertical axis, mirrored or shifted, and it scales with the size of the scan. If it
// leaves less than a third of the height of the scan, a warning is given; less than a twentieth is rejected. A given
// trim is kept. Undercuts deeper than 1.5 R / 70 are reported if they are larger than R^2 / 2500.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/base/patient_space.hpp"
#include "api/settings.hpp"
#include "worker/stage/context.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// A pocket of the scan that the sheet, coming from above, cannot reach or that locks the formed part.
struct Undercut {
  Eigen::Vector3d place;  // its deepest point, in the mold's frame, mm
  double depth_mm;        // how far it reaches under what overhangs it, horizontally
  double area_mm2;        // its area seen from above
};

// What was found in the file and how it was repaired, for people and for report.json.
struct ScanFindings {
  std::string format;  // "STL (binary)", "PLY (ASCII)", ...
  std::int64_t triangles_read = 0;
  Unit unit = Unit::mm;  // as used
  bool unit_guessed = false;
  bool size_given = false;     // scaled to scan.size_mm; `unit` says nothing then
  UpAxis up = UpAxis::plus_z;  // as used
  bool up_guessed = false;
  FrontSide front = FrontSide::plus_y;  // of the upright scan, turned to +y of the mold before the yaw
  bool front_from_format = false;  // glTF defines +Z of the file as the front, or `space` says where it is
  PatientSpace space = PatientSpace::unknown;  // the axes that the file names (SPACE=LPS)
  std::optional<FrontSide> left_from_file;     // by `space`: the patient's left side of the upright scan
  bool front_assumed = false;                  // neither given nor told by the format
  LeftSide left_side = LeftSide::unknown;      // as a person saw it; make_mold() does not set it
  bool mirrored = false;                       // left and right swapped, as scan.mirror asked
  int outliers_dropped = 0;                    // vertices far from all others
  int components = 0;                          // connected pieces in the file
  int components_dropped = 0;                  // debris and inner skins
  bool turned_inside_out = false;              // the skin was inside out and has been turned
  int holes_closed = 0;                        // small holes filled
  int holes_capped = 0;                        // large openings closed by the platform
  bool rebuilt = false;  // the skin was beyond repair and was wrapped again (CGAL's alpha wrap)
  Eigen::Vector3d size_mm = Eigen::Vector3d::Zero();  // of the whole scan, upright, before trimming
  double trim_mm = 0;        // height above the scan's lowest point at which it was cut
  bool trim_chosen = false;  // by Vacuform, where undercuts would begin
  int crumbs_dropped = 0;  // pieces that the cut left next to the mold, each below a thousandth of its volume
};

// Maps the file's coordinates to the mold's frame, mm: its origin, and its axes one unit long. A similarity, which
// mirrors if scan.mirror asks for it. The mold's surface is that of the placed scan where nothing was closed, rebuilt
// or grown.
struct ScanPlacing {
  Eigen::Vector3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin{0, 0, 0};
  Eigen::Vector3d operator()(const Eigen::Vector3d& p) const {
    return origin + p.x() * x + p.y() * y + p.z() * z;
  }
};

struct Mold {
  TriangleMesh mesh;                // watertight, oriented outwards, z >= 0
  Eigen::Vector3d top;              // the middle of its highest part (mold_top.hpp); z: of the highest vertex
  std::vector<Undercut> undercuts;  // of the mold as trimmed, those reported, deepest first
  ScanFindings findings;
  std::vector<Warning> warnings;
  ScanPlacing placing = {};  // of the coordinates of the file
};

// Makes the mold. Pure: the same bytes and settings give the same mold. Its coordinates are those of mold.stl, exactly.
// Warnings: file-unusual, space-contradicted, outliers, inside-out, up-guessed, tilted, large-hole, rebuilt, trim-discards, undercut. Takes a few tenths of
// a second for 27,000 triangles, most of it for the pose of a scan without a foot; some seconds for a million. `file_name` is used for messages and, if the bytes do not tell the format,
// for its extension. Errors: unsupported_format, corrupt_file, too_large, ambiguous_units, unusable_scan, cancelled.
Result<Mold> make_mold(std::span<const std::uint8_t> bytes, const std::string& file_name,
                       const ScanSettings& settings, const Context& context);

// Whether the mold fits the sheet and the window of the machine, with room to draw; does_not_fit says what is missing, and
// proposes first the units in which it would fit, if its unit was guessed.
Result<void> check_fit(const Mold& mold, const SheetSettings& sheet, const MachineSettings& machine);

// Warnings for a mold that fits, with place and size: "window-close" if the sheet between mold and frame, which must
// follow the side of the mold down, thins below `thin_limit` of its thickness (size: the gap); "deep-draw" at the top
// (size: the draw) if the draw is more than half of the shorter side of the window, or more than the width of the mold;
// "clamp-narrow" at the edge of the sheet if less than 5 mm of the sheet lie in the clamp (size: those mm).
std::vector<Warning> fit_findings(const Mold& mold, const SheetSettings& sheet,
                                  const MachineSettings& machine, double thin_limit);

}  // namespace vacuform
