// The bundled models with colours: a face mask and a figurine. Each is closed and lies on z = 0 without an undercut.
// The painted texture has a net of lines every 10 degrees of the model's own grid, and landmarks with a cross and a
// label.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

enum class Model { mask, figurine };

// A point that the texture marks: its label and its place on the model, mm.
struct Landmark {
  std::string label;
  Eigen::Vector3d place;
};

struct PaintedModel {
  TriangleMesh mesh;                // mm, Z up, a person's top towards +Y
  std::vector<Eigen::Vector2d> uv;  // of each vertex, as in glTF: v down
  std::vector<Landmark> landmarks;
};

// The mask is 144 x 192 x 73 mm, the figurine (a penguin on its back) 134 x 197 x 46 mm. Deterministic.
PaintedModel painted_model(Model model);

// The model with its texture of 2048 x 2048 pixels as a GLB; +Y is up there, the model's +y at +Z, metres.
std::vector<std::uint8_t> painted_glb(Model model);

}  // namespace vacuform
