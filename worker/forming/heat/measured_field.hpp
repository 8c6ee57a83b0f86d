// A measured temperature field: a table of a thermal camera, readings of a hand-held thermometer, or a gray picture.
#pragma once

#include "api/settings.hpp"
#include "worker/forming/heat/temperature_field.hpp"
#include "worker/stage/input_file.hpp"

namespace vacuform {

// One of these formats, detected by content:
//  - text of rows of degrees Celsius that tile the sheet, seen from above, the first row along its upper edge (t most),
//    each row from the left (s least); every value is that of the middle of its cell;
//  - text with a header of the columns s, t (mm from the sheet's centre) and celsius, in any order, then one point a
//    line: the smoothest surface through them (through_points);
//  - a gray PNG that tiles the sheet in the same way, from heat.black_c to heat.white_c.
// Values are separated by commas, or by semicolons (then a comma may be the decimal point), or by blanks. Lines that are
// empty or begin with # are skipped. Untrusted bytes; at most 64 MiB, 4 million values, 200,000 points.
// Errors: corrupt_file with the line, too_large, unsupported_format, bad_settings (a picture without a scale).
Result<TemperatureField> read_measured_field(const InputFile& file, const SheetSettings& sheet,
                                             const HeatSettings& heat);

}  // namespace vacuform
