// The letters of the patient's sides (worker/scan/sides.hpp) in pictures. Internal to worker/inspection.
#pragma once

#include <string>

#include "worker/inspection/canvas.hpp"
#include "worker/scan/sides.hpp"

namespace vacuform {

// What a picture from a side is called: "Front (A)", "Patient's left (L)", "Above, front at the top".
std::string side_words(View::Side side, const SideLetters& letters);

// Writes the letters around the part in a picture that `view` drew, between the rows `top` and `bottom`. A letter that the
// part hides, or that would lie on it because the eye is above it, is left out.
void write_sides(const View& view, const SideLetters& letters, Picture& picture, int top, int bottom);

// Writes one letter about a point, with a white edge.
void write_letter(Canvas& canvas, const std::string& letter, double x, double y);

}  // namespace vacuform
