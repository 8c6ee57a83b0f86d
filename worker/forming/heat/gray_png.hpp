// Gray pictures whose gray is a quantity: read without any change of colour. Untrusted bytes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "api/base/error.hpp"

namespace vacuform {

struct GrayPicture {
  int width, height;
  std::vector<std::uint16_t> pixels;  // row by row from the top; 0 is black, 65535 white
};

bool is_png(std::span<const std::uint8_t> bytes);

// A PNG of gray of any depth; transparency is ignored. Memory is taken only for pictures whose file is long enough to
// hold them. Errors: too_large (over 4 million pixels), unsupported_format (colour, which has no scale), corrupt_file.
Result<GrayPicture> read_gray_png(std::span<const std::uint8_t> bytes, const std::string& file_name);

}  // namespace vacuform
