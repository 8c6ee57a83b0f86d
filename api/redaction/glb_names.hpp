// Names in GLB (glTF 2.0, ISO/IEC 12113): of its JSON chunk the contents of all texts but those that the geometry needs
// become blanks, and "extras" become a nought. Pictures in the binary chunk keep their pixels, which a print can show, and
// lose their texts (picture_names.hpp); pictures that are neither PNG nor JPEG, and whatever stands behind the chunk, become
// zeros. Numbers, positions and triangles stay, bit for bit. A JSON chunk with more than 65,536 buffer views
// or nested more than 64 deep, in which the pictures cannot be told, is blanked from there on, and so unreadable.
#pragma once

#include <memory>

#include "api/redaction/names.hpp"

namespace vacuform {

std::unique_ptr<NameFilter::Format> glb_names();

}  // namespace vacuform
