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

// Kd and vertex colours are encoded as sRGB. A material with an image whose Kd is black has the colours of the image:
// Maya writes so. Keywords are in any case. The options -o, -s and -clamp of map_Kd are applied, no others.
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
  // After take(): how materials in use were read where the file is not as its format demands or darkens its images, and
  // which materials are not there. Sentences without their ends.
  const std::vector<std::string>& notes() const { return notes_; }
  const std::vector<std::string>& missing() const { return missing_; }

 private:
  struct Laid {
    int material = 0;
    Eigen::Vector2f scale{1, 1}, shift{0, 0};
    std::string note = {};
  };
  void settle(Laid& laid, const std::array<double, 3>& kd, const std::string& keyword);
  void note_use();
  Result<void> lay_image(std::string_view rest, const std::string& where, Laid& laid);
  Result<int> image(std::string_view name, const std::string& where);
  int without_image(int material);
  void take_vertex_colours(std::size_t vertices);

  const ModelFiles* files_;
  ScanColours colours_;                             // materials[0] is white
  std::map<std::string, Laid, std::less<>> named_;  // materials of the MTL
  std::map<std::string, int, std::less<>> images_;
  std::map<int, int> plain_;   // for materials with an image: the same material without it
  std::vector<Laid> laid_;     // those in use
  int using_ = -1;             // of laid_; -1: white
  bool unknown_used_ = false;  // the triangles that follow name a material that the library does not define
  std::size_t unknown_triangles_ = 0;
  std::vector<std::string> notes_, missing_;
  std::vector<Eigen::Vector2f> uv_;
  struct Corners {
    std::array<std::int64_t, 3> uv;
    int laid;
  };
  std::vector<Corners> triangles_;
  std::vector<Eigen::Vector3f> vertex_;  // as the file has them; negative: none
};

}  // namespace vacuform
