// The formed sheet as files that other programs open. Internal to worker/inspection.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/inspection/inspection.hpp"

namespace vacuform {

// Binary little-endian PLY: x y z s t u v thickness temperature (float), contact (uchar); u, v are NaN off
// the chart.
std::vector<std::uint8_t> formed_ply(const Finished& job);

// The formed sheet; vt = Print::picture_uv of each vertex's sheet coordinates, material "print" of
// formed.mtl.
std::vector<std::uint8_t> formed_obj(const Finished& job);
std::vector<std::uint8_t> formed_mtl();

// The chart's triangles; vt = pattern coordinates over the pattern's size, + 0.5.
std::vector<std::uint8_t> uv_map_obj(const Finished& job);

}  // namespace vacuform
