// A DXF as an SVG of lines. Internal to worker/pattern.
#pragma once

#include <string>
#include <string_view>

#include "worker/pattern/svg_size.hpp"

namespace vacuform {

// Its page is the box around all lines with their widths. Warning: "pattern-left-out", what is not drawn.
//
// Reads lines, arcs, circles, ellipses, polylines with arcs and widths, splines with control points, solids, and blocks in
// blocks, to be turned, scaled, mirrored and repeated. All of it is black. What is drawn on a layer is one group with its
// name, what is in a block one group for each place of it and each layer that is named after a step of printing; ends that
// meet within 0.01 mm are one line. A line has the constant width of its polyline, or its own line weight or that of its
// layer, or settings.line_mm. Nothing is drawn of layers that are off or frozen. Errors: corrupt_file, too_large (200,000
// curves, blocks more than 16 deep), unusable_pattern (no unit, with the sizes that it could have; lines without a width;
// tapered lines; shapes out of the plane; nothing to draw).
Result<SizedSvg> dxf_drawing(std::string_view text, const std::string& file_name,
                             const PatternSettings& settings);

}  // namespace vacuform
