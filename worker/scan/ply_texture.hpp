// The texture of a PLY: "comment TextureFile NAME" in its header, and texture coordinates of the vertices (s t, u v or
// texture_u texture_v) or of the corners of each face (the list texcoord, with texnumber where there are several
// images). Internal to worker/scan.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "worker/scan/model_zip.hpp"

namespace vacuform {

class PlyTexture {
 public:
  // `names`: from the header, in its order. `files`: of the zip; null for a single file, which has no texture.
  PlyTexture(std::vector<std::string> names, const ModelFiles* files)
      : names_(std::move(names)), files_(files) {}

  bool used() const { return files_ && !names_.empty(); }
  void add_vertex(double u, double v);
  // A face whose corners made the triangles from `first_triangle` up to `triangles`, as a fan. `uv` are the numbers of
  // its list, two a corner; `number` is that of its image.
  void add_face(const std::vector<double>& uv, double number, std::size_t first_triangle,
                std::size_t triangles);
  // Gives the triangles their materials and coordinates. Errors: unusable_scan (an image is missing), corrupt_file.
  Result<void> lay(const TriangleMesh& mesh, const std::string& where, ScanColours& colours) const;

 private:
  struct OfTriangle {
    int image = -1;  // -1: its face has no texture coordinates
    std::array<Eigen::Vector2f, 3> uv;
  };
  std::vector<std::string> names_;
  const ModelFiles* files_;
  std::vector<Eigen::Vector2f> of_vertex_;
  std::vector<OfTriangle> of_triangle_;
};

}  // namespace vacuform
