#include "worker/scan/ply_texture.hpp"

#include <cmath>

namespace vacuform {

namespace {

constexpr float largest_ply_uv = 1e6f;

Eigen::Vector2f from_above(double u, double v) {  // v counts from below
  return {static_cast<float>(u), static_cast<float>(1 - v)};
}

}  // namespace

void PlyTexture::add_vertex(double u, double v) { of_vertex_.push_back(from_above(u, v)); }

void PlyTexture::add_face(const std::vector<double>& uv, double number, std::size_t first_triangle,
                          std::size_t triangles) {
  of_triangle_.resize(triangles);
  const std::size_t made = triangles - first_triangle;
  if (made == 0 || uv.size() != 2 * (made + 2)) return;
  const bool known = number >= 0 && number < static_cast<double>(names_.size());
  for (std::size_t i = 0; i < made && known; ++i) {
    OfTriangle& triangle = of_triangle_[first_triangle + i];
    triangle.image = static_cast<int>(number);
    const std::array<std::size_t, 3> corners{0, i + 1, i + 2};
    for (std::size_t k = 0; k < 3; ++k)
      triangle.uv[k] = from_above(uv[2 * corners[k]], uv[2 * corners[k] + 1]);
  }
}

Result<void> PlyTexture::lay(const TriangleMesh& mesh, const std::string& where, ScanColours& colours) const {
  for (const std::string& name : names_) {
    const auto found = files_->images.find(name);
    if (found == files_->images.end())
      return fail(Code::unusable_scan, "the zip lacks an image that the model names", where,
                  "pack it with the model");
    ScanMaterial material;
    material.image = static_cast<int>(colours.images.size());
    colours.materials.push_back(material);
    colours.images.push_back({name, found->second});
  }
  const int plain = static_cast<int>(colours.materials.size());
  colours.materials.emplace_back();
  colours.uv.resize(mesh.triangles.size());
  colours.material.assign(mesh.triangles.size(), plain);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    auto& uv = colours.uv[t];
    if (t < of_triangle_.size() && of_triangle_[t].image >= 0) {
      colours.material[t] = of_triangle_[t].image;
      uv = of_triangle_[t].uv;
    } else if (!of_vertex_.empty()) {
      colours.material[t] = 0;
      for (std::size_t k = 0; k < 3; ++k) uv[k] = of_vertex_[mesh.triangles[t][k]];
    } else {
      for (Eigen::Vector2f& corner : uv) corner.setZero();
    }
    for (const Eigen::Vector2f& corner : uv)
      if (!(corner.cwiseAbs().maxCoeff() <= largest_ply_uv))
        return corrupt("a texture coordinate of the PLY file is not a plausible number",
                       where + ", face " + std::to_string(t));
  }
  return {};
}

}  // namespace vacuform
