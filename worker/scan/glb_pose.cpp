#include "worker/scan/glb_pose.hpp"

#include <bit>
#include <cmath>
#include <string>

namespace vacuform {

using Eigen::Affine3d;
using Eigen::Vector3d;
using nlohmann::json;

namespace {

constexpr std::uint64_t most_instances = 65'536, most_joints = 65'536;
constexpr std::size_t most_targets = 256;

float float_at(const GlbView& view, std::uint64_t i, std::uint64_t k) {
  return std::bit_cast<float>(u32(Bytes(view.data + i * view.stride, 4 * k + 4), 4 * k));
}

std::uint64_t integer_at(const GlbView& view, std::uint64_t i, std::uint64_t k) {
  const std::uint8_t* at = view.data + i * view.stride;
  if (view.component == 5121) return at[k];
  if (view.component == 5123) return at[2 * k] | std::uint64_t{at[2 * k + 1]} << 8;
  const float value = float_at(view, i, k);
  return value >= 0 && value < 1e6f ? static_cast<std::uint64_t>(std::lround(value)) : most_joints;
}

double share_at(const GlbView& view, std::uint64_t i, std::uint64_t k) {
  if (view.component == 5126) return float_at(view, i, k);
  return static_cast<double>(integer_at(view, i, k)) / (view.component == 5121 ? 255 : 65535);
}

}  // namespace

Result<std::vector<Affine3d>> GlbPose::places(const json& node, const Affine3d& world) const {
  const json* extensions = child(node, "extensions");
  const json* extension = extensions ? child(*extensions, "EXT_mesh_gpu_instancing") : nullptr;
  if (!extension) return std::vector<Affine3d>{world};
  if (node.contains("skin"))
    return fail(Code::unsupported_format,
                "a node of the GLB file has a skin and instances (EXT_mesh_gpu_instancing)", file_.where,
                "apply the skin or the instances in the program that made it");
  const json* attributes = child(*extension, "attributes");
  if (!attributes) return corrupt("the instances of a node of the GLB file have no attributes", file_.where);
  const auto view = [&](const char* name, const char* type,
                        std::uint64_t components) -> Result<std::optional<GlbView>> {
    if (!attributes->contains(name)) return std::optional<GlbView>();
    VACUFORM_TRY(found, file_.view(whole(*attributes, name), type, components));
    if (found.component != 5126)
      return fail(Code::unsupported_format, "the instances of a node of the GLB file are not in floats",
                  file_.where, "export it without instances (EXT_mesh_gpu_instancing)");
    return std::optional(found);
  };
  VACUFORM_TRY(shifts, view("TRANSLATION", "VEC3", 3));
  VACUFORM_TRY(turns, view("ROTATION", "VEC4", 4));
  VACUFORM_TRY(scales, view("SCALE", "VEC3", 3));
  std::optional<std::uint64_t> count;
  for (const auto& given : {shifts, turns, scales}) {
    if (!given) continue;
    if (count.value_or(given->count) != given->count)
      return corrupt("the instances of a node of the GLB file have attributes of different lengths",
                     file_.where);
    count = given->count;
  }
  if (!count) return corrupt("the instances of a node of the GLB file have no known attributes", file_.where);
  if (*count > most_instances)
    return fail(Code::too_large,
                "a node of the GLB file has " + std::to_string(*count) + " instances, above the limit of " +
                    std::to_string(most_instances),
                file_.where, "export one surface");
  std::vector<Affine3d> all;
  for (std::uint64_t i = 0; i < *count; ++i) {
    Affine3d place = world;
    if (shifts)
      place.translate(Vector3d(float_at(*shifts, i, 0), float_at(*shifts, i, 1), float_at(*shifts, i, 2)));
    if (turns) {
      const Eigen::Quaterniond turn(float_at(*turns, i, 3), float_at(*turns, i, 0), float_at(*turns, i, 1),
                                    float_at(*turns, i, 2));
      if (!(turn.norm() > 1e-6))
        return corrupt("an instance of the GLB file has no valid rotation", file_.where);
      place.rotate(turn.normalized());
    }
    if (scales)
      place.scale(Vector3d(float_at(*scales, i, 0), float_at(*scales, i, 1), float_at(*scales, i, 2)));
    all.push_back(place);
  }
  return all;
}

Result<void> GlbPose::morph(const json& node, const json& mesh, const json& primitive,
                            const GlbPrimitive& part, std::vector<Vector3d>& points) const {
  const auto given = node.contains("weights") ? node.find("weights") : mesh.find("weights");
  const auto targets = primitive.find("targets");
  if (targets == primitive.end() || given == (node.contains("weights") ? node.end() : mesh.end())) return {};
  if (!targets->is_array() || !given->is_array() || given->size() > targets->size())
    return corrupt("the morph targets of the GLB file do not fit their weights", file_.where);
  std::size_t used = 0;
  for (std::size_t t = 0; t < given->size(); ++t) {
    const double weight = (*given)[t].is_number() ? (*given)[t].get<double>() : NAN;
    if (!std::isfinite(weight))
      return corrupt("a weight of the GLB file's morph targets is no number", file_.where);
    const json& target = (*targets)[t];
    if (weight == 0 || !target.is_object() || !target.contains("POSITION")) continue;
    if (part.compressed())
      return fail(Code::unsupported_format, "a primitive of the GLB file is compressed and has morph targets",
                  file_.where, "export it without compression, or with the shape keys applied");
    if (++used > most_targets)
      return fail(Code::too_large, "a primitive of the GLB file has more than 256 morph targets in use",
                  file_.where, "export it with the shape keys applied");
    VACUFORM_TRY(moves, file_.view(whole(target, "POSITION"), "VEC3", 3));
    if (moves.component != 5126)
      return fail(Code::unsupported_format, "the morph targets of the GLB file are not in floats",
                  file_.where, "export it without quantization, or with the shape keys applied");
    if (moves.count != points.size())
      return corrupt("a morph target of the GLB file does not fit its positions", file_.where);
    for (std::uint64_t i = 0; i < moves.count; ++i)
      points[i] += weight * Vector3d(float_at(moves, i, 0), float_at(moves, i, 1), float_at(moves, i, 2));
  }
  return {};
}

Result<const GlbPose::Matrices*> GlbPose::joints_of(std::uint64_t index) {
  if (const auto known = skins_.find(index); known != skins_.end()) return &known->second;
  const json* skin = nth(file_.root, "skins", index);
  if (!skin || !skin->contains("joints") || !(*skin)["joints"].is_array() || (*skin)["joints"].empty())
    return corrupt("skin " + std::to_string(index) + " of the GLB file has no joints", file_.where);
  const json& joints = (*skin)["joints"];
  if (joints.size() > most_joints)
    return fail(Code::too_large, "a skin of the GLB file has more than 65,536 joints", file_.where,
                "export the scan with its skin applied");
  std::optional<GlbView> inverse;
  if (skin->contains("inverseBindMatrices")) {
    VACUFORM_TRY(view, file_.view(whole(*skin, "inverseBindMatrices"), "MAT4", 16));
    if (view.component != 5126 || view.count < joints.size())
      return corrupt("the inverse bind matrices of the GLB file do not fit its joints", file_.where);
    inverse = view;
  }
  Matrices matrices;
  for (std::uint64_t j = 0; j < joints.size(); ++j) {
    const auto world =
        joints[j].is_number_unsigned() ? worlds_.find(joints[j].get<std::uint64_t>()) : worlds_.end();
    if (world == worlds_.end())
      return fail(Code::unsupported_format,
                  "joint " + std::to_string(j) + " of a skin of the GLB file is not a node of its scene",
                  file_.where, "export the scan with its skin applied, or as STL");
    Affine3d matrix = world->second;
    if (inverse) {
      Affine3d bind = Affine3d::Identity();
      for (std::uint64_t k = 0; k < 16; ++k)
        if (k % 4 < 3)
          bind(static_cast<Eigen::Index>(k % 4), static_cast<Eigen::Index>(k / 4)) = float_at(*inverse, j, k);
      matrix = matrix * bind;
    }
    matrices.push_back(matrix);
  }
  return &(skins_[index] = std::move(matrices));
}

Result<bool> GlbPose::skin(std::uint64_t index, const GlbPrimitive& part, std::vector<Vector3d>& points) {
  VACUFORM_TRY(joints, joints_of(index));
  struct Influence {
    GlbView joints, weights;
  };
  std::vector<Influence> influences;
  for (int set = 0; set < 16; ++set) {
    const std::string n = std::to_string(set), joint_name = std::string("JOINTS_").append(n),
                      weight_name = std::string("WEIGHTS_").append(n);
    if (!part.has(joint_name) || !part.has(weight_name)) break;
    VACUFORM_TRY(of_joints, part.attribute(joint_name, "VEC4", 4));
    VACUFORM_TRY(of_weights, part.attribute(weight_name, "VEC4", 4));
    if (of_joints.count < points.size() || of_weights.count < points.size() || of_joints.component == 5125 ||
        of_weights.component == 5125)
      return corrupt("JOINTS_" + n + " or WEIGHTS_" + n + " of the GLB file does not fit its positions",
                     file_.where);
    influences.push_back({of_joints, of_weights});
  }
  if (influences.empty())
    return corrupt("a primitive of a skinned node of the GLB file has no joints and weights", file_.where);
  bool mirrored = false;
  for (std::uint64_t i = 0; i < points.size(); ++i) {
    Eigen::Matrix<double, 3, 4> matrix = Eigen::Matrix<double, 3, 4>::Zero();
    double sum = 0;
    for (const Influence& given : influences)
      for (std::uint64_t k = 0; k < 4; ++k) {
        const double share = share_at(given.weights, i, k);
        if (share == 0) continue;
        const std::uint64_t joint = integer_at(given.joints, i, k);
        if (!std::isfinite(share) || joint >= joints->size())
          return corrupt("vertex " + std::to_string(i) +
                             " of a skinned primitive of the GLB file names joint " + std::to_string(joint) +
                             ", or its weight is no number",
                         file_.where);
        matrix += share * (*joints)[joint].affine();
        sum += share;
      }
    if (!(sum > 1e-6))
      return corrupt("vertex " + std::to_string(i) + " of a skinned primitive of the GLB file has no weights",
                     file_.where);
    matrix /= sum;
    points[i] = matrix.leftCols<3>() * points[i] + matrix.col(3);
    if (i == 0) mirrored = matrix.leftCols<3>().determinant() < 0;
  }
  return mirrored;
}

}  // namespace vacuform
