// What no job may pass, beside the bytes of its files (input_kinds in job.hpp): the programs that hold it and the one
// that tells people agree here.
#pragma once

#include <cstdint>

namespace vacuform {

struct JobLimits {
  std::int64_t scan_triangles = 5'000'000;
  std::int64_t scan_vertices = 15'000'000;            // three corners a triangle, as in STL
  std::int64_t scan_components = 1'000'000;           // connected pieces of its surface
  std::int64_t pattern_pixels = 64'000'000;           // of a picture, or that an SVG is drawn with
  std::int64_t sheet_cells = 640'000;                 // of the simulation's grid
  std::int64_t seconds = 900;                         // of the job's process, from its start
  std::int64_t cpu_seconds = 900;                     // of all its threads
  std::int64_t memory_bytes = std::int64_t{8} << 30;  // of its address space
};
inline constexpr JobLimits job_limits;

inline constexpr std::uint64_t largest_artifact = 2ull << 30;  // bytes, of each

}  // namespace vacuform
