// A file that gzip packed (RFC 1952), as in SVGZ.
#pragma once

#include <cstddef>
#include <string>

#include "api/base/byte_source.hpp"

namespace vacuform {

inline constexpr std::string_view gzip_mark = "\x1f\x8b";

// Its content. Memory stays below that and 64 KiB. Errors: corrupt_file (also for bytes behind the end other than a further
// packed part or zeros), too_large (more than `most` bytes), and those of the source.
Result<std::string> gunzip(const ByteSource& file, std::size_t most);

}  // namespace vacuform
