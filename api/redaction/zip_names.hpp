// A zip with a model: one OBJ with its MTL, or one PLY, and PNG or JPEG images (PKWARE, .ZIP File Format Specification 6.3).
#pragma once

#include <memory>

#include "api/redaction/names.hpp"

namespace vacuform {

// The largest archive that is read.
struct ModelZipLimits {
  std::uint64_t entries = 1000;                                // also of what is left out
  std::uint64_t bytes = (std::uint64_t{1} << 30) - (1 << 20);  // unpacked, of what is kept
  std::uint64_t ratio = 200;     // unpacked against packed, of an entry above a mebibyte
  std::uint64_t line = 1 << 20;  // of an OBJ or MTL
};
inline constexpr ModelZipLimits model_zip_limits;

// The archive is written again, uncompressed: model.obj, model.mtl or model.ply, and texture-1 and so on, the images by the
// numbers that the files call them by. The files lose their names, comments and every text, as NameFilter says for each;
// other entries are left out. The same entries in the same order give the same bytes. Unlike the other formats this one
// cannot go on from a state, because unpacking has none that is small, and it refuses: encrypted, damaged and lying
// archives, packing other than deflate, absolute paths and those to a parent folder, links, more than one model, images
// that are missing or neither PNG nor JPEG, and what is beyond the limits.
std::unique_ptr<NameFilter::Format> zip_names();

}  // namespace vacuform
