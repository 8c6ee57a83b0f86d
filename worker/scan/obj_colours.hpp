// The colours of an OBJ: the numbers that may follow a vertex, and of its MTL the colour Kd and the image map_Kd.
// Internal to worker/scan.
#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "worker/scan/model_zip.hpp"

namespace vacuform {

// Kd and vertex colours are encoded as sRGB. The options -o, -s and -clamp of map_Kd are applied, no others.
class ObjColours {
 public:
  // Keeps a reference to the files, which may be null.
  explicit ObjColours(const ModelFiles* files) : files_(files) {}

  // Reads the MTL. Errors: corrupt_file, unusable_scan (an image is missing).
  Result<void> read_library(const std::string& where);
  // The rest of the line of vertex `index`, after its place.
  void add_vertex(std::string_view rest, std::size_t index);
  // The rest of a vt line. Errors: corrupt_file.
  Result<void> add_uv(std::string_view rest, const std::string& where);
  // The material of the triangles that follow; an unknown one is white.
  void use(std::string_view material);
  // The index in the list of vt that a corner v/vt/vn names; -1 if it names none.
  std::int64_t uv_of(std::string_view corner) const;
  void add_triangle(const std::array<std::int64_t, 3>& uv);
  // Nothing if no triangle has a colour. Errors: corrupt_file (a triangle names a vt that does not exist).
  Result<std::optional<ScanColours>> take(const TriangleMesh& mesh, const std::string& where);

 private:
  struct Laid {
    int material = 0;
    Eigen::Vector2f scale{1, 1}, shift{0, 0};
  };
  Result<void> lay_image(std::string_view rest, const std::string& where, Laid& laid);
  Result<int> image(std::string_view name, const std::string& where);
  int without_image(int material);
  void take_vertex_colours(std::size_t vertices);

  const ModelFiles* files_;
  ScanColours colours_;                             // materials[0] is white
  std::map<std::string, Laid, std::less<>> named_;  // materials of the MTL
  std::map<std::string, int, std::less<>> images_;
  std::map<int, int> plain_;  // for materials with an image: the same material without it
  std::vector<Laid> laid_;    // those in use
  int using_ = -1;            // of laid_; -1: white
  std::vector<Eigen::Vector2f> uv_;
  struct Corners {
    std::array<std::int64_t, 3> uv;
    int laid;
  };
  std::vector<Corners> triangles_;
  std::vector<Eigen::Vector3f> vertex_;  // as the file has them; negative: none
};

}  // namespace vacuform
