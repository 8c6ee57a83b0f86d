// Names in pictures: texts, Exif and whatever follows the picture's end.
#pragma once

#include <memory>

#include "api/redaction/names.hpp"

namespace vacuform {

// PNG (W3C, third edition): the data of all ancillary chunks but those for size and colour (so of texts, Exif, times, colour
// profiles with their names, and private ones) become zeros in a private chunk that every reader steps over, under a checksum
// that is right.
std::unique_ptr<NameFilter::Format> png_names();

// JPEG (ITU-T T.81): the data of comments and application segments become zeros, but for JFIF (density, without its small
// picture), Adobe (colours) and, of Exif, the orientation.
std::unique_ptr<NameFilter::Format> jpeg_names();

}  // namespace vacuform
