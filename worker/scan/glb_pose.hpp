// What moves the vertices of a GLB's meshes besides the transforms of the nodes: morph targets, skins, and copies of a node
// (EXT_mesh_gpu_instancing). The pose is that of the file without its animations. Internal to worker/scan.
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <vector>

#include "worker/scan/glb_primitive.hpp"

namespace vacuform {

class GlbPose {
 public:
  explicit GlbPose(const GlbFile& file) : file_(file) {}

  // Of a node of the scene.
  void set_world(std::uint64_t node, const Eigen::Affine3d& world) { worlds_.insert_or_assign(node, world); }

  // Where the mesh of the node is to be: at the node, or at each of its instances. Errors: corrupt_file,
  // unsupported_format (an instanced skin, integer attributes), too_large (more than 65,536 instances).
  Result<std::vector<Eigen::Affine3d>> places(const nlohmann::json& node, const Eigen::Affine3d& world) const;

  // Adds the morph targets to the points of a primitive, by the weights of the node, or else those of its mesh. Errors:
  // corrupt_file, unsupported_format (sparse, integers, or a compressed primitive), too_large (more than 256 targets).
  Result<void> morph(const nlohmann::json& node, const nlohmann::json& mesh, const nlohmann::json& primitive,
                     const GlbPrimitive& part, std::vector<Eigen::Vector3d>& points) const;

  // Moves the points of a primitive of a skinned node to where its joints hold them, in the coordinates of the scene:
  // the transform of the node itself does not count (glTF 2.0, 3.7.3.3). Gives whether the first point's matrix mirrors.
  // Errors: corrupt_file, unsupported_format (a joint that is not in the scene).
  Result<bool> skin(std::uint64_t index, const GlbPrimitive& part, std::vector<Eigen::Vector3d>& points);

 private:
  using Matrices = std::vector<Eigen::Affine3d>;
  Result<const Matrices*> joints_of(std::uint64_t skin);

  const GlbFile& file_;
  std::map<std::uint64_t, Eigen::Affine3d> worlds_;
  std::map<std::uint64_t, Matrices> skins_;
};

}  // namespace vacuform
