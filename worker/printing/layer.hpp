// A print is a list of layers, from the top to the bottom. A layer is ink of one kind on one face of the sheet, and has
// files of its own.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/print_step.hpp"
#include "worker/colour/ink_curve.hpp"
#include "worker/pattern/ink_parts.hpp"
#include "worker/placement/placement.hpp"
#include "worker/printing/row_source.hpp"
#include "worker/printing/vector_print.hpp"

namespace vacuform {

class SheetColours;     // worker/colour
struct PrintedColours;  // colour_ink.hpp

// Where the ink of a layer comes from. Rows keep a reference to their source. Deterministic for any number of threads.
class LayerSource {
 public:
  virtual ~LayerSource() = default;

  // For the files: what the printer lays, so that it comes out right on the formed part.
  virtual std::unique_ptr<RowSource> printed(const PrintGrid& grid) const = 0;
  // For pictures of the sheet. `state` matters only to what is compensated for the stretch.
  virtual std::unique_ptr<RowSource> shown(const PrintGrid& grid, InkState state) const = 0;
  // For figures of where ink lies: as it is drawn, without compensation.
  virtual std::unique_ptr<RowSource> laid(const PrintGrid& grid) const = 0;

  virtual bool black() const = 0;          // all its ink is black, in shades
  virtual double ink_printed() const = 0;  // the fraction of its ink that has a place on the sheet, in [0, 1]
  virtual bool compensates_shades() const { return false; }  // print.compensate_ink acts on it
  virtual std::vector<Warning> warnings() const { return {}; }
  // Boxes around ink that may lie off the chart; sheet coordinates, mm.
  virtual std::vector<Eigen::AlignedBox2d> boxes() const { return {}; }

  // What only some layers have, otherwise null.
  virtual const VectorPrint* vectors() const { return nullptr; }
  virtual const PrintedColours* colours() const { return nullptr; }
  // The pattern, if all of the layer is that pattern under the charts of the placement: it can be sampled directly.
  virtual const Pattern* under_charts() const { return nullptr; }
};

// A number that is printed beside its place, such as that of a gap, so that a table can name it.
struct PlaceNumber {
  int number = 0;
  Eigen::Vector2d at{0, 0}, towards{1, 0};  // sheet coordinates, mm; a unit vector: the side to try first
};

struct Layer {
  std::string name;  // of its files: name.png, name.svg and name.pdf of api/job.hpp
  InkedFace face = InkedFace::outer;
  std::shared_ptr<const LayerSource> source;
  // Of a layer of an array that is printed in several steps: all that have one together are what the pattern is.
  std::optional<PrintStep> step = {};
  std::vector<PlaceNumber> numbers = {};

  struct Files {
    // The whole sheet, exact dpi in pHYs, mirrored if the face is the inner one. Black ink gives 8-bit gray on white,
    // any other 8-bit RGB on white, or RGBA if settings.print.background is transparent. With marks if
    // settings.print.marks is set.
    std::vector<std::uint8_t> png;
    // The same at 1:1: user units mm, origin the centre of the sheet, x = s, y = -t. Group "pattern", under
    // scale(-1 1) if mirrored, holds each element in a group with its id, painted outlines and unpainted centre lines
    // of class "centreline"; for a layer without lines, its part of the sheet as an image. Group "marks": vectors and
    // text.
    std::string svg;
    // The same on a page of the size of the sheet, vectors or a losslessly embedded image, texts as texts. That of the
    // main layer has the pages of all others too, in the order of printing.
    std::vector<std::uint8_t> pdf;
  };
  Files files = {};
  // The fractions of its ink that lie on the chart or on their element's patch, and that lie on the chart, and so on
  // the mold, once formed; in [0, 1].
  double ink_printed = 0, ink_on_head = 0;

  bool mirrored() const { return face == InkedFace::inner; }
};

// The sources keep references to what they are made of: it must outlive them.

// The lines of a drawing, pulled back as vectors and drawn anti-aliased. `drawing` is the result of read_drawing() for
// the file of the pattern, `placement` that of place() for it. Errors: cancelled.
Result<std::shared_ptr<const LayerSource>> drawing_layer(const Pattern& pattern, const Drawing& drawing,
                                                         const Placement& placement, const Settings& settings,
                                                         const Context& context);

// The same of lines that were pulled back.
std::shared_ptr<const LayerSource> drawing_layer(const Pattern& pattern, VectorPrint vectors);

// A picture. `parts` are those whose drawing() was placed, null if none were: each is then printed through its own
// patch. Every pixel is the mean of 4 to 16 samples, each filtered by the footprint that its triangle gives it, so that
// edges are smooth, including those of the chart. With `compensate`, shades of gray are printed darker where the sheet
// stretches more (ink_compensation.hpp).
std::shared_ptr<const LayerSource> picture_layer(const Pattern& pattern, const Placement& placement,
                                                 const InkParts* parts, bool compensate);

// The colours of a scan. All of the ink counts as printed. `as_picture` is the layer of picture_of(), if figures of the
// ink are those of that picture: it has no ink off the charts.
std::shared_ptr<const LayerSource> colour_layer(PrintedColours colours,
                                                std::shared_ptr<const LayerSource> as_picture = {});

// The colours of a scan as a picture of the flat sheet in sheet coordinates, for code that shows a drawing: 0.2 mm a
// pixel, or 4000 pixels on the longer side if that is coarser. Errors: cancelled.
Result<Pattern> picture_of(const SheetColours& colours, const SheetSettings& sheet, const Context& context);

}  // namespace vacuform
