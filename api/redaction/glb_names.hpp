// Names in GLB (glTF 2.0, ISO/IEC 12113): of its JSON chunk the contents of all texts but those that the geometry needs
// become blanks, and "extras" become a nought; pictures in the binary chunk (a texture is a photograph), and whatever stands
// behind it, become zeros. Numbers, positions and triangles stay, bit for bit. A JSON chunk with more than 65,536 buffer views
// or nested more than 64 deep, in which the pictures cannot be told, is blanked from there on, and so unreadable.
#pragma once

#include <memory>

#include "api/redaction/names.hpp"

namespace vacuform {

std::unique_ptr<NameFilter::Format> glb_names();

}  // namespace vacuform
