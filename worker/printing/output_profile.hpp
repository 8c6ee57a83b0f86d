// The colour space of the printed files: sRGB, or that of an ICC profile (ICC.1, versions 2 and 4) given with the job.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "api/base/error.hpp"

namespace vacuform {

// Cheap to copy and safe to use from several threads.
class OutputProfile {
 public:
  static constexpr std::size_t largest_bytes = 4u << 20;

  OutputProfile() = default;  // sRGB: nothing is converted

  // An RGB profile of an output device or a display. Untrusted bytes. Errors: too_large; unsupported_format (not a
  // profile, or one of another colour space such as CMYK, which PNG cannot hold); corrupt_file.
  static Result<OutputProfile> read(std::span<const std::uint8_t> bytes, const std::string& file_name);

  // The file to embed; empty for sRGB.
  std::span<const std::uint8_t> icc() const;
  // From sRGB to the profile, relative colorimetric with black point compensation; 8 bits a channel, straight RGBA.
  // Opacities stay. Nothing to do for sRGB.
  void convert(std::span<std::uint8_t> rgba) const;
  // The other way: what a colour of the files looks like. Colours that the device does not have stay changed.
  void convert_back(std::span<std::uint8_t> rgba) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

// A profile of sRGB, for files that must hold one. The same bytes each time.
std::vector<std::uint8_t> srgb_icc();

}  // namespace vacuform
