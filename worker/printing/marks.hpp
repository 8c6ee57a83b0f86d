// The marks around a print: they show a person at the press which side is up, whose print this is and whether its scale
// is correct. They are laid out once, as strokes and texts in print millimetres, and then drawn both into the rows of
// print.png and as vectors and text into print.svg.
//
// Print coordinates: mm, origin the sheet's centre, x to the right and y up *as the print is read*, mirrored
// or not.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/settings.hpp"
#include "worker/printing/print_label.hpp"
#include "worker/printing/row_source.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

struct Line {
  std::vector<Eigen::Vector2d> points;
  bool closed = false, filled = false, dashed = false;
};
struct MarkCircle {
  Eigen::Vector2d centre;
  double radius;
  bool dashed = false;
};
struct Text {
  Eigen::Vector2d at;                     // start or middle of the baseline
  double size;                            // mm, of the letters' em
  bool centred = false, upwards = false;  // upwards: reads from below to above
  std::string text;
};
struct Mark {
  std::string name;  // an id in the SVG
  std::vector<Line> lines;
  std::vector<MarkCircle> circles;
  std::vector<Text> texts;
};

struct Marks {
  std::vector<Mark> marks;
  std::optional<double> ruler_mm;  // its length, if it is there
  std::vector<Warning> warnings;   // "marks-left-out"
};

// What the marks of one page are laid out around.
struct MarkedPage {
  bool mirrored = false;
  std::string step = {};                        // of printing, for the legend: which, and with what ink
  std::vector<Eigen::AlignedBox2d> taken = {};  // boxes of the chart's triangles, print coordinates
  std::vector<Line> outline = {};               // where the plastic leaves the mold, clear of the ink
  std::vector<Text> numbers = {};               // beside gaps, clear of the ink
};

// Lays the marks out along the sheet's edge, print.margin_mm from it: frame, window, crosses to register by, ruler, the
// direction of +t, the letters of the patient's sides, and a legend. A mark that would touch one of page.taken
// is left out with a warning: marks never lie on the pattern. `label` must be as printable() gives it.
//
// The formed part is cut or checked along page.outline. The arrow makes the operator lay every sheet with its extrusion
// direction along +t, so that effects of the sheet itself repeat from sheet to sheet.
Marks lay_out_marks(const Settings& settings, const PrintLabel& label, MarkedPage page);

// How much of each pixel the marks cover, 0 to 255, in `rows` rows of the grid from `first_row` on.
std::vector<std::uint8_t> draw_marks(const Marks& marks, const PrintGrid& grid, int first_row, int rows);

// The elements inside the layer "marks" of print.svg; y down.
std::string svg_of(const Marks& marks);

}  // namespace vacuform
