// A look at the formed sheet, or at the mold, without a display. Internal to worker/inspection.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "worker/forming/formed_sheet.hpp"
#include "worker/inspection/visible_triangles.hpp"
#include "worker/scan/ray_caster.hpp"
#include "worker/scan/sides.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

// 0xffRRGGBB, rows from the top.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint32_t> pixels;
};

// Where one sample of a pixel meets the mesh.
struct Seen {
  int triangle;
  std::array<double, 3> weights;  // barycentric
  double spacing_mm;              // between neighbouring samples on the mesh there
  float light;                    // how bright the surface is, about 0.3 to 1.1
  float gloss;                    // white to add
};
using Rgb = Eigen::Vector3f;  // red, green, blue in [0, 1]
inline const Rgb black_ink(0.07f, 0.08f, 0.10f);

// A view from the front, which is +y (worker/scan/sides.hpp), a little from -x and from above. What is `shown` (of a sheet:
// its drawn part) fills the picture, except for `top` and `bottom` rows that are left empty for captions. Smooth normals, a
// key light from the upper left of the front, a sky, and the sky's occlusion by the mesh itself, which makes dents and
// skirts visible.
class View {
 public:
  // Without shadows the mesh hides none of its sky, and spot() takes everything as seen: for meshes so fine that their
  // shadows take too long.
  View(TriangleMesh mesh, std::vector<Eigen::Vector3d> shown, SideLetters letters, int width, int height,
       int top, int bottom, bool shadows = true);
  View(const FormedSheet& sheet, SideLetters letters, int width, int height, int top, int bottom);

  // Sets the side that the next pictures and spots are seen from; the width stays. Front and behind are a little from
  // the side and from above; the others look straight at the head.
  enum class Side { front, behind, straight_front, straight_back, minus_x, plus_x, above };
  void look_from(Side side, int height, int top, int bottom);
  // The same in a picture of another width.
  void look_from(Side side, int width, int height, int top, int bottom);

  // What fills the picture from the next look_from() on, and whether it is the part or a detail of it.
  const std::vector<Eigen::Vector3d>& shown() const { return shown_; }
  void show(std::vector<Eigen::Vector3d> shown, bool detail) { shown_ = std::move(shown), detail_ = detail; }
  const SideLetters& letters() const { return letters_; }

  // Draws `count` pictures, with the letters of the patient's sides around the part unless it is a detail, from one side, 2 x 2 samples a pixel: `shade` gives the colour of a sample in each.
  // Deterministic, whatever the number of threads. Reports fractions of the inspection stage in [from, to].
  Result<std::vector<Picture>> draw(int count, const std::function<void(const Seen&, Rgb*)>& shade,
                                    const Context& context, double from, double to);

  // Where a point in space lies in a picture. Nothing behind the eye.
  struct Spot {
    double x, y;  // pixels from the picture's left and top
    double pixels_per_mm;
    double behind_mm;  // behind what is seen there; 0: the point itself is seen
  };
  std::optional<Spot> spot(const Eigen::Vector3d& place) const;
  // From what is shown to the eye, one unit long.
  const Eigen::Vector3d& towards_eye() const { return back_; }

 private:
  double middle_row() const { return 0.5 * (top_ + height_ - bottom_); }
  void frame();
  Result<void> light(const Context& context, double from, double to);
  Camera camera() const;
  Seen seen(const VisibleTriangles::Sample& sample, const Eigen::Vector3d& aim) const;

  TriangleMesh mesh_;
  std::vector<Eigen::Vector3d> shown_;
  bool detail_ = false;
  SideLetters letters_;
  int width_, height_, top_, bottom_;
  double azimuth_, elevation_;
  RayCaster rays_;
  std::vector<Eigen::Vector3d> normals_;
  std::vector<float> open_;  // per vertex: the part of the sky that it sees
  Eigen::Vector3d right_, up_, back_, eye_;
  double tangent_ = 1;  // half the picture's width at distance 1
};

}  // namespace vacuform
