// What an SVG costs to draw, counted before anything is drawn. Internal to worker/pattern.
#pragma once

#include <pugixml.hpp>
#include <string>

#include "api/base/error.hpp"

namespace vacuform {

// Every copy that <use>, patterns, markers, masks and clipping paths make counts. Doubles, so that no product
// overflows.
struct SvgWork {
  double elements = 0;   // drawn
  double text = 0;       // bytes of path data and of text that is drawn
  double crossings = 0;  // of outlines with themselves, estimated from length and box
  double pages = 0;      // painted: a page's area counts as 1
  double sides = 0;      // of outlines: a page's side counts as 1
  double layers = 0;     // painted, in pages, again for each band of the picture
  double surfaces = 0;   // pictures of a whole page that are held at the same time

  // Seconds of the processor for a picture of so many pixels; rather too many than too few.
  double seconds(double pixels) const;
};

// Adds up the work without expanding: what is used several times is counted once and multiplied. Errors:
// too_large for references nested deeper than 100, for more elements or crossings than can be drawn in ten
// seconds, and for style sheets with too many rules for the number of elements; unsupported_format for values
// by entities.
Result<SvgWork> work_to_draw(const pugi::xml_document& document, const std::string& file_name);

// The most pixels, at most `wanted`, that can be drawn in ten seconds and in 500 MB. Errors: too_large if these are
// fewer than `wanted` and than a quarter of a million.
Result<double> affordable_pixels(const SvgWork& work, double wanted, const std::string& file_name);

}  // namespace vacuform
