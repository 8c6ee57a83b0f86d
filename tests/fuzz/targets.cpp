#include "tests/fuzz/targets.hpp"

#include <array>
#include <cstdio>
#include <cstdlib>

namespace vacuform::fuzz {

namespace {
constexpr std::array<Target, 16> all{{{"stl", read_stl},
                                      {"obj", read_obj},
                                      {"ply", read_ply},
                                      {"off", read_off},
                                      {"glb", read_glb},
                                      {"zip", read_zip},
                                      {"png", read_png},
                                      {"jpeg", read_jpeg},
                                      {"svg", read_svg},
                                      {"settings", read_settings},
                                      {"multipart", read_multipart},
                                      {"redaction", redact_file},
                                      {"temperature", read_temperature},
                                      {"patches", read_ink_chart},
                                      {"icc", read_icc},
                                      {"request", read_request}}};
}

std::span<const Target> targets() { return all; }

const Target* target(std::string_view name) {
  for (const Target& t : all)
    if (t.name == name) return &t;
  return nullptr;
}

void require(bool holds, const char* promise) {
  if (holds) return;
  std::fprintf(stderr, "a promise does not hold: %s\n", promise);
  std::abort();
}

}  // namespace vacuform::fuzz
