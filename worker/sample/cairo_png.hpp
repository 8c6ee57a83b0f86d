// A picture that cairo has drawn, as a file. Internal to worker/sample.
#pragma once

#include <cairo.h>

#include <cstdint>
#include <vector>

namespace vacuform {

// The pixels of an image surface of format RGB24 as PNG, RGB.
std::vector<std::uint8_t> png_of(cairo_surface_t* surface);

}  // namespace vacuform
