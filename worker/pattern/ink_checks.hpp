// What of a drawing can hardly be printed as it was meant: lines that are too thin, and ink under all of it.
#pragma once

#include <optional>
#include <vector>

#include "worker/pattern/drawing.hpp"

namespace vacuform {

// Warnings: "coil-cut", coils that reach beyond the page, by their ids; "lines-thin", lines that are narrower on the part than 0.05 mm or half a pixel of the print, with the ids of their
// elements; "pattern-dark", ink on more than half of the page, or a filled shape under all of two or more coils. `lines` are those of the pattern, if it has any.
std::vector<Warning> check_ink(const Pattern& pattern, const std::optional<Drawing>& lines, double scale,
                               int print_dpi);

}  // namespace vacuform
