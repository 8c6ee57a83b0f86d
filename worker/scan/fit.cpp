// Whether a mold fits the sheet and the machine.
//
// Room: around the mold's bounding box (in a round window: around its vertices) the window leaves at least 5
// mm and two sheet thicknesses, so that the sheet can turn down between mold and frame, and at least an
// eleventh of the draw: the film in a gap g that goes down a wall of height H becomes g + H long, and below a
// twelfth of its thickness it tears. Draw: at most 1.5 times the window's shorter side, beyond which no sheet
// in that window holds enough plastic.
#include <algorithm>
#include <cmath>

#include "worker/decimal.hpp"
#include "worker/scan/mold.hpp"
#include "worker/scan/topology.hpp"

namespace vacuform {
namespace {

constexpr double most_draw = 1.5;         // over the window's shorter side
constexpr double least_gap = 1.0 / 11.0;  // over the draw

std::string mm(double value) { return decimal(value, 1) + " mm"; }

}  // namespace

Result<void> check_fit(const Mold& mold, const SheetSettings& sheet, const MachineSettings& machine) {
  const bool circle = machine.window == WindowShape::circle;
  const double width = machine.window_width_mm, height = circle ? width : machine.window_height_mm;
  if (width > sheet.width_mm || height > sheet.height_mm)
    return fail(Code::does_not_fit,
                "the window of " + mm(width) + " x " + mm(height) + " is larger than the sheet of " +
                    mm(sheet.width_mm) + " x " + mm(sheet.height_mm),
                "machine.window_width_mm",
                "give a smaller window or a larger sheet (sheet.width_mm, sheet.height_mm)");
  const Box box = bounds(mold.mesh);
  const double draw = box.high.z() - machine.drape_height_mm;
  const double room = std::max(5 + 2 * sheet.thickness_mm, least_gap * draw);
  if (machine.drape_height_mm >= box.high.z())
    return fail(Code::does_not_fit,
                "the frame stops " + mm(machine.drape_height_mm) + " above the platform, " +
                    mm(machine.drape_height_mm - box.high.z()) +
                    " above the mold's top, and the sheet never meets the mold",
                "machine.drape_height_mm", "give less than " + mm(box.high.z()));
  const double shorter = std::min(width, height);
  if (draw > most_draw * shorter)
    return fail(Code::does_not_fit,
                "the mold is " + mm(draw) + " to draw, " + mm(draw - most_draw * shorter) +
                    " more than a sheet in a window of " + mm(shorter) + " can give",
                "scan.trim_mm", "trim the mold at least that much higher, or give a larger window and sheet");
  const std::string advice =
      "; or trim the mold higher (scan.trim_mm), turn it (scan.yaw_deg), or scan a smaller part";
  if (circle) {
    double radius = 0;
    for (const auto& p : mold.mesh.vertices) radius = std::max(radius, p.head<2>().norm());
    if (const double over = radius + room - width / 2; over > 0)
      return fail(Code::does_not_fit,
                  "the mold reaches " + mm(radius) + " from the middle and with " + mm(room) +
                      " of room is " + mm(over) + " too wide for the round window of " + mm(width),
                  "machine.window_width_mm",
                  "give a window and a sheet of at least " + mm(2 * (radius + room)) + advice);
  } else {
    const double over_x = box.size().x() + 2 * room - width, over_y = box.size().y() + 2 * room - height;
    if (over_x > 0 || over_y > 0) {
      const bool x = over_x >= over_y;
      return fail(Code::does_not_fit,
                  "the mold is " + mm(box.size()[x ? 0 : 1]) + (x ? " wide" : " deep") + " and with " +
                      mm(room) + " of room on each side is " + mm(x ? over_x : over_y) +
                      " too large for the window of " + mm(x ? width : height),
                  x ? "machine.window_width_mm" : "machine.window_height_mm",
                  "give a window and a sheet of at least " + mm(box.size()[x ? 0 : 1] + 2 * room) + advice);
    }
  }
  return {};
}

}  // namespace vacuform
