// The program that wrote an SVG, as far as the size of the drawing depends on it: pixels have another length in each of them.
// Redaction leaves this of a file's comments and notes, in one fixed form, and nothing else.
#pragma once

#include <string>
#include <string_view>

namespace vacuform {

// Of a comment, without its marks: "Generator: Adobe Illustrator 24.0.1" if it begins with that, with or without a version
// and whatever follows; otherwise empty. Applied to its own result, it changes nothing.
std::string svg_generator_comment(std::string_view comment);

// Of the attribute inkscape:version: the number at its beginning, as "0.91" of "0.91 r13725". Empty if there is none, or one
// with more than three parts or four digits a part.
std::string svg_inkscape_version(std::string_view value);

}  // namespace vacuform
