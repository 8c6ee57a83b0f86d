// How far the colours of a scan lie off their place on the formed part, and how different they look, measured through
// the pixels of the print.
//
// Places of the sheet are examined on an even grid of print pixels, at most 1 mm apart, each a quarter of a pixel off
// the centre of its pixel. The pixel gives the colour that shows there, as the file of the print has it, and the places
// of the scan from which the raster took that colour; their mean is the pixel's origin. The triangles of the sheet give
// the formed place, on the face that lies on the mold. Neither side knows of the other, so a shift, a mirroring or a
// jump in the print shows as an error. The simulated sheet itself is taken as true.
#pragma once

#include <vector>

#include "worker/inspection/inspection.hpp"
#include "worker/printing/colour_ink.hpp"

namespace vacuform {

// By formed area.
struct PlacedStatistics {
  Statistics values;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // of the largest, on the formed sheet, mm
};

struct ColourErrors {
  struct Figures {
    // From the pixel's origin on the scan to the formed place, mm. Contains the gap where the sheet does not reach the
    // scan.
    PlacedStatistics position;
    // From the pixel's origin to the place of the scan that is nearest to the formed place, mm: how far the colours
    // have moved on the scan.
    PlacedStatistics along;
    // CIEDE2000 between the pixel, on white, and the scan nearest to the formed place, both seen over a pixel. If the
    // ink is compensated, the pixel is as the stretched sheet shows it.
    PlacedStatistics colour;
  };
  Figures whole;     // where the print has colour, faded or not
  Figures touching;  // where the formed place is within reach of full colour
  // Means around each vertex of the sheet; NaN where the print has no colour.
  std::vector<double> position_of_vertices, colour_of_vertices;

  // The same where the sheet touches, if the print lies this far off its place on the sheet: towards +s, -s, +t and -t
  // in equal parts.
  struct OffRegister {
    double shift_mm = 0;
    Figures touching;
  };
  std::vector<OffRegister> off_register;  // by register_errors_mm
  // Where the largest of these shifts changes most what is seen of full colour: the place, the outward normal of the
  // sheet there, and the direction of the shift on the flat sheet, one of the four.
  struct Change {
    Eigen::Vector3d place = Eigen::Vector3d::Zero(), outward = Eigen::Vector3d::UnitZ();
    Eigen::Vector2d towards = Eigen::Vector2d::UnitX();
  };
  Change most_changed;
};

// Errors of registration that people make when they lay a print onto the machine by its marks.
inline constexpr double register_errors_mm[] = {0.5, 1};

// `print` is that of make_print() for these colours; its file must be one that it wrote. `resolution_mm` is the spacing
// of the sheet's grid; `ink` is what the print was compensated with, null without. Deterministic for any number of
// threads. Errors: cancelled.
Result<ColourErrors> colour_errors(const SheetColours& colours, const Print& print, const ColourInk* ink,
                                   double resolution_mm, const Context& context);

}  // namespace vacuform
