// What hostile bytes meet: one entry point for each kind of file and text that comes from outside.
//
// An entry point returns whether the bytes were refused or read; it aborts when a promise of the code behind it does not
// hold. The same entry points are run by libFuzzer (guided.cpp, Clang, `VACUFORM_FUZZERS`) and, without it, by
// replay.cpp, which every run of the tests includes.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace vacuform::fuzz {

using Bytes = std::span<const std::uint8_t>;

struct Target {
  std::string_view name;  // also the folder of its seeds
  void (*run)(Bytes);
};

// stl, obj, ply, off, glb, zip, png, jpeg, svg, settings, multipart, redaction, temperature, patches, icc,
// request.
std::span<const Target> targets();
const Target* target(std::string_view name);  // null: none of that name

void read_stl(Bytes), read_obj(Bytes), read_ply(Bytes), read_off(Bytes), read_glb(Bytes), read_zip(Bytes);
void read_png(Bytes), read_jpeg(Bytes), read_svg(Bytes);
void read_settings(Bytes), read_multipart(Bytes), redact_file(Bytes), read_temperature(Bytes),
    read_ink_chart(Bytes), read_icc(Bytes), read_request(Bytes);

// Ends the program, with the promise in its last words.
void require(bool holds, const char* promise);

inline std::string_view text(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace vacuform::fuzz
