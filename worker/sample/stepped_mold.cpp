#include "worker/sample/stepped_mold.hpp"

#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "worker/sample/cairo_png.hpp"
#include "worker/sample/textured_glb.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// At size 1, for a window of 280 x 280 mm; lengths in mm.
constexpr double top_half = 30, wall_run = 6, terrace = 20, corner_centre = 22;
constexpr std::array<double, 5> heights{96, 84, 62, 30, 0};  // of the steps, and of the platform
constexpr int steps = 4, arc = 8, coverages = 5;
constexpr double patch = 10, top_pitch = 13.5, side_pitch = 16;
constexpr double outer_half = top_half + steps * wall_run + (steps - 1) * terrace;
constexpr double texture_half = outer_half + 1;
constexpr int texture_side = 2048;
constexpr double window_for_1 = 280, circle_for_1 = 340, largest_size = 1.5, least_patch = 6;

double height_of(int step) { return heights[step]; }

// A square with round corners around the origin, counter-clockwise.
std::vector<Vector2d> outline_of_step(double half) {
  std::vector<Vector2d> out;
  for (int corner = 0; corner < 4; ++corner)
    for (int i = 0; i <= arc; ++i) {
      const double angle = std::numbers::pi / 2 * (corner + static_cast<double>(i) / arc);
      const Vector2d centre(corner == 0 || corner == 3 ? 1 : -1, corner < 2 ? 1 : -1);
      out.push_back(corner_centre * centre +
                    (half - corner_centre) * Vector2d(std::cos(angle), std::sin(angle)));
    }
  return out;
}

struct Pyramid {
  TriangleMesh mesh;
  std::vector<Vector2d> uv;

  int add(const Vector2d& at, double z) {
    mesh.vertices.emplace_back(at.x(), at.y(), z);
    uv.emplace_back(0.5 + at.x() / (2 * texture_half), 0.5 - at.y() / (2 * texture_half));
    return static_cast<int>(mesh.vertices.size()) - 1;
  }
};

Pyramid pyramid() {
  Pyramid out;
  const int top = out.add({0, 0}, height_of(0));
  int before = -1, count = 0;
  const auto ring = [&](double half, double z) {
    const auto points = outline_of_step(half);
    count = static_cast<int>(points.size());
    const int first = static_cast<int>(out.mesh.vertices.size());
    for (const Vector2d& p : points) out.add(p, z);
    for (int k = 0; k < count; ++k) {
      const int next = (k + 1) % count;
      if (before < 0) {
        out.mesh.triangles.push_back({top, first + k, first + next});
        continue;
      }
      out.mesh.triangles.push_back({before + k, first + k, first + next});
      out.mesh.triangles.push_back({before + k, first + next, before + next});
    }
    before = first;
  };
  double half = top_half;
  for (int step = 0; step < steps; ++step) {
    ring(half, height_of(step));
    ring(half += wall_run, height_of(step + 1));
    if (step + 1 < steps) half += terrace;
  }
  const int below = out.add({0, 0}, 0);
  for (int k = 0; k < count; ++k) out.mesh.triangles.push_back({below, before + (k + 1) % count, before + k});
  return out;
}

// The middle of a place for a patch: on the top four rows of four, on a terrace four along each side.
Vector2d place_for(int step, int slot) {
  const double along = slot % 4 - 1.5;
  const int group = slot / 4;  // the row on the top, or the side of a terrace
  if (step == 0) return top_pitch * Vector2d(along, 1.5 - group);
  const double out = top_half + step * wall_run + (step - 0.5) * terrace;
  const Vector2d at(side_pitch * along, out);
  // From one side to the next by a quarter turn.
  if (group == 0) return at;
  if (group == 2) return -at;
  return group == 1 ? Vector2d(-at.y(), at.x()) : Vector2d(at.y(), -at.x());
}

// A byte of sRGB (IEC 61966-2-1) with about this much linear light, and the light that it has.
int byte_of(double linear) {
  const double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return static_cast<int>(std::lround(255 * encoded));
}
double light_of(int byte) {
  const double v = byte / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

class ChartTexture {
 public:
  ChartTexture()
      : surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, texture_side, texture_side),
                 cairo_surface_destroy),
        cairo_(cairo_create(surface_.get()), cairo_destroy) {
    cairo_set_source_rgb(cairo_.get(), 1, 1, 1);
    cairo_paint(cairo_.get());
    cairo_scale(cairo_.get(), texture_side / (2 * texture_half), -texture_side / (2 * texture_half));
    cairo_translate(cairo_.get(), texture_half, -texture_half);
    cairo_select_font_face(cairo_.get(), "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    const cairo_matrix_t upright{2.4, 0, 0, -2.4, 0, 0};
    cairo_set_font_matrix(cairo_.get(), &upright);
  }
  void square(const Vector2d& middle, std::array<int, 3> rgb) {
    cairo_set_source_rgb(cairo_.get(), rgb[0] / 255.0, rgb[1] / 255.0, rgb[2] / 255.0);
    cairo_rectangle(cairo_.get(), middle.x() - patch / 2, middle.y() - patch / 2, patch, patch);
    cairo_fill(cairo_.get());
  }
  void frame(const Vector2d& middle) {
    cairo_set_source_rgb(cairo_.get(), 0.5, 0.5, 0.5);
    cairo_set_line_width(cairo_.get(), 0.3);
    cairo_rectangle(cairo_.get(), middle.x() - patch / 2, middle.y() - patch / 2, patch, patch);
    cairo_stroke(cairo_.get());
  }
  void label(const std::string& words, const Vector2d& start) {
    cairo_set_source_rgb(cairo_.get(), 0.25, 0.25, 0.25);
    cairo_move_to(cairo_.get(), start.x(), start.y());
    cairo_show_text(cairo_.get(), words.c_str());
    cairo_new_path(cairo_.get());
  }
  std::vector<std::uint8_t> png() { return png_of(surface_.get()); }

 private:
  std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface_;
  std::unique_ptr<cairo_t, void (*)(cairo_t*)> cairo_;
};

double size_for(const MachineSettings& machine) {
  const double fits = machine.window == WindowShape::circle
                          ? machine.window_width_mm / circle_for_1
                          : std::min(machine.window_width_mm, machine.window_height_mm) / window_for_1;
  return std::min(fits, largest_size);
}

}  // namespace

double least_window_mm(WindowShape window) {
  return least_patch / patch * (window == WindowShape::circle ? circle_for_1 : window_for_1);
}

std::optional<SteppedMold> stepped_mold(const MachineSettings& machine) {
  const double size = size_for(machine);
  if (size * patch < least_patch) return {};
  SteppedMold out;
  out.patch_mm = size * patch;
  ChartTexture texture;
  for (int step = 0; step < steps; ++step)
    for (int k = 0; k < 3 * coverages + 1; ++k) {
      MoldPatch each;
      each.step = step + 1;
      const int ink = k / coverages, level = k % coverages + 1;
      // Spread over the sides, another way on each step, so that a tilted sheet does not look like a curve.
      const Vector2d at = place_for(step, (7 * k + 5 * step) % 16);
      std::array<int, 3> rgb{255, 255, 255};
      if (ink < 3) {
        const int byte = byte_of(1 - static_cast<double>(level) / coverages);
        rgb[ink] = byte;
        each.ink = ink;
        each.coverage = 1 - light_of(byte);
      }
      each.id = (ink < 3 ? std::string(1, "CMY"[ink]) + std::to_string(level) : std::string("W")) +
                static_cast<char>('a' + step);
      each.place = size * Vector3d(at.x(), at.y(), height_of(step));
      texture.square(at, rgb);
      if (ink == 3) texture.frame(at);
      const bool beside =
          step > 0 && std::abs(at.y()) > std::abs(at.x());  // there is more room along the side
      texture.label(each.id,
                    at + (beside ? Vector2d(patch / 2 + 0.5, -0.8) : Vector2d(-patch / 2, -patch / 2 - 2.3)));
      out.patches.push_back(std::move(each));
    }
  Pyramid model = pyramid();
  for (Vector3d& v : model.mesh.vertices) v *= size;
  out.glb = textured_glb(model.mesh, model.uv, texture.png(), "ink chart");
  return out;
}

}  // namespace vacuform
