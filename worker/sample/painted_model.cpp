#include "worker/sample/painted_model.hpp"

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

constexpr double degree = std::numbers::pi / 180, quarter = std::numbers::pi / 2;
constexpr int sectors = 360, circles = 140;  // of the mesh
constexpr int side = 2048;                   // pixels of the texture
constexpr double share = 0.98;               // of half the texture that the model covers

double bell(double x, double width) { return std::exp(-(x / width) * (x / width)); }
double step(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// A relief over a plan whose outline every ray from the origin crosses once.
class Relief {
 public:
  virtual ~Relief() = default;
  virtual double reach(double angle) const = 0;                   // from the origin to the rim
  virtual double height(const Vector2d& at, double t) const = 0;  // t: share of the reach

  Vector3d place(const Vector2d& at) const {
    const double t = std::min(1.0, at.norm() / reach(std::atan2(at.y(), at.x())));
    return {at.x(), at.y(), height(at, t)};
  }
  // The place on the texture, from 0 to 1: even steps on an ellipsoid are even steps there.
  Vector2d uv(const Vector2d& at) const {
    const double angle = std::atan2(at.y(), at.x());
    const double t = std::min(1.0, at.norm() / reach(angle));
    const double radius = 0.5 * share * std::asin(t) / quarter;
    return {0.5 + radius * std::cos(angle), 0.5 - radius * std::sin(angle)};
  }
};

class Face : public Relief {
 public:
  double reach(double angle) const override {
    return 1 / std::hypot(std::cos(angle) / half_width, std::sin(angle) / half_length);
  }
  double height(const Vector2d& at, double t) const override {
    const double x = std::abs(at.x()), y = at.y();
    double features = 17 * bell(x, 10) * step(34, -10, y) * step(-26, -16, y);  // nose
    features += 5 * bell(x - 10, 6) * bell(y + 14, 8);                          // its wings
    features += -8 * bell(x - 30, 16) * bell(y - 22, 11) + 5 * bell(x - 30, 10) * bell(y - 22, 7);  // eyes
    features += 4 * bell(x - 30, 20) * bell(y - 40, 8);                                             // brows
    features += 5 * bell(x - 38, 19) * bell(y + 16, 20);                                            // cheeks
    features += 5 * bell(x, 20) * bell(y + 43, 4.5) + 5 * bell(x, 17) * bell(y + 52, 5);            // lips
    features += 7 * bell(x, 16) * bell(y + 76, 11);                                                 // chin
    const double bulge = 1 - t * t;
    return deep * std::sqrt(std::max(0.0, bulge)) + features * bulge;
  }

 private:
  static constexpr double half_width = 72, half_length = 96, deep = 56;
};

class Penguin : public Relief {
 public:
  // The outline of the parts, smoothed over some degrees: otherwise it would jump where a ray leaves one part for
  // another.
  Penguin() {
    constexpr int width = 8;
    std::array<double, sectors> outline{};
    for (int k = 0; k < sectors; ++k) outline[k] = far_end(k * degree);
    for (int k = 0; k < sectors; ++k) {
      double sum = 0, weights = 0;
      for (int d = -3 * width; d <= 3 * width; ++d) {
        const double weight = bell(d, width);
        sum += weight * outline[(k + d + sectors) % sectors];
        weights += weight;
      }
      reach_[k] = sum / weights;
    }
  }
  double reach(double angle) const override {
    const double at = (angle < 0 ? angle + 4 * quarter : angle) / degree;
    const auto before = static_cast<std::size_t>(at) % sectors;
    const double part = at - std::floor(at);
    return (1 - part) * reach_[before] + part * reach_[(before + 1) % sectors];
  }
  double height(const Vector2d& at, double t) const override {
    double sum = std::pow(12 * std::sqrt(std::max(0.0, 1 - t * t)), 4);  // what all parts lie on
    for (const Part& part : parts_) {
      const double left = 1 - ((at - part.centre).array() / part.half.array()).matrix().squaredNorm();
      if (left > 0) sum += std::pow(part.high * std::sqrt(left), 4);
    }
    const double beak = 12 * bell(at.x(), 7) * bell(at.y() - 58, 9);
    return std::pow(sum, 0.25) + beak * (1 - t * t);
  }

 private:
  struct Part {
    Vector2d centre, half;
    double high;
  };
  // Where the ray from the origin leaves the last part.
  double far_end(double angle) const {
    double most = 0;
    for (const Part& part : parts_) {
      const Vector2d d = Vector2d(std::cos(angle), std::sin(angle)).cwiseQuotient(part.half);
      const Vector2d c = part.centre.cwiseQuotient(part.half);
      const double a = d.squaredNorm(), b = d.dot(c), root = b * b - a * (c.squaredNorm() - 1);
      if (root >= 0) most = std::max(most, (b + std::sqrt(root)) / a);
    }
    return most;
  }

  // Body, head, wings, feet.
  const std::array<Part, 6> parts_{{{{0, -18}, {52, 66}, 44},
                                    {{0, 64}, {36, 38}, 38},
                                    {{50, -8}, {17, 42}, 20},
                                    {{-50, -8}, {17, 42}, 20},
                                    {{24, -80}, {20, 18}, 18},
                                    {{-24, -80}, {20, 18}, 18}}};
  std::array<double, sectors> reach_{};
};

std::unique_ptr<Relief> relief_of(Model model) {
  if (model == Model::mask) return std::make_unique<Face>();
  return std::make_unique<Penguin>();
}

std::vector<std::pair<const char*, Vector2d>> landmarks_of(Model model) {
  if (model == Model::mask)
    return {{"F", {0, 66}},     {"N", {0, 28}},    {"T", {0, -12}},    {"E1", {-48, 22}}, {"E2", {48, 22}},
            {"C1", {-40, -16}}, {"C2", {40, -16}}, {"M1", {-28, -47}}, {"M2", {28, -47}}, {"G", {0, -76}}};
  return {{"H", {0, 84}},    {"E1", {-26, 62}},  {"E2", {26, 62}},  {"B", {0, 0}},      {"S1", {-30, -30}},
          {"S2", {30, -30}}, {"W1", {-54, -10}}, {"W2", {54, -10}}, {"F1", {-24, -86}}, {"F2", {24, -86}}};
}

// Paints at places that are given on the model's plan, mm.
class Paint {
 public:
  explicit Paint(const Relief& relief)
      : relief_(relief),
        surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, side, side), cairo_surface_destroy),
        cairo_(cairo_create(surface_.get()), cairo_destroy) {
    cairo_set_line_join(cairo_.get(), CAIRO_LINE_JOIN_ROUND);
    cairo_set_line_cap(cairo_.get(), CAIRO_LINE_CAP_ROUND);
  }

  void colour(int rgb) {
    cairo_set_source_rgb(cairo_.get(), (rgb >> 16) / 255.0, (rgb >> 8 & 255) / 255.0, (rgb & 255) / 255.0);
  }
  void everywhere() { cairo_paint(cairo_.get()); }
  void polygon(std::vector<Vector2d> corners) {
    corners.push_back(corners.front());
    path(corners);
    cairo_close_path(cairo_.get());
    cairo_fill(cairo_.get());
  }
  void ellipse(const Vector2d& centre, double half_width, double half_height) {
    std::vector<Vector2d> points;
    for (int i = 0; i < 90; ++i)
      points.push_back(
          centre + Vector2d(half_width * std::cos(4 * i * degree), half_height * std::sin(4 * i * degree)));
    polygon(points);
  }
  // Width in mm of the middle of the model, where the texture is the finest.
  void line(const std::vector<Vector2d>& points, double width) {
    path(points);
    cairo_set_line_width(cairo_.get(), width * pixels_per_mm());
    cairo_stroke(cairo_.get());
  }
  void label(const char* words, const Vector2d& at, double height) {
    const Vector2d p = pixel(at);
    cairo_select_font_face(cairo_.get(), "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_BOLD);
    cairo_set_font_size(cairo_.get(), height * pixels_per_mm());
    cairo_move_to(cairo_.get(), p.x(), p.y());
    cairo_show_text(cairo_.get(), words);
    cairo_new_path(cairo_.get());
  }
  // Circles and rays of the texture itself, every ten degrees.
  void net(double width) {
    cairo_set_line_width(cairo_.get(), width * pixels_per_mm());
    for (int ring = 1; ring < 9; ++ring) {
      cairo_arc(cairo_.get(), side / 2.0, side / 2.0, ring / 9.0 * share * side / 2, 0, 4 * quarter);
      cairo_stroke(cairo_.get());
    }
    for (int ray = 0; ray < 36; ++ray) {
      const Vector2d d(std::cos(10 * ray * degree), std::sin(10 * ray * degree));
      cairo_move_to(cairo_.get(), side / 2.0 * (1 + d.x() * share / 9), side / 2.0 * (1 + d.y() * share / 9));
      cairo_line_to(cairo_.get(), side / 2.0 * (1 + d.x()), side / 2.0 * (1 + d.y()));
      cairo_stroke(cairo_.get());
    }
  }

  std::vector<std::uint8_t> png() { return png_of(surface_.get()); }

 private:
  Vector2d pixel(const Vector2d& at) const { return relief_.uv(at) * side; }
  double pixels_per_mm() const { return (pixel({0.5, 0}) - pixel({-0.5, 0})).norm(); }
  // In small steps: what is straight on the model is not straight on the texture.
  void path(const std::vector<Vector2d>& points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector2d &from = points[i == 0 ? 0 : i - 1], &to = points[i];
      const int steps = std::max(1, static_cast<int>(std::ceil((to - from).norm())));
      for (int k = 1; k <= steps; ++k) {
        const Vector2d p = pixel(from + k / static_cast<double>(steps) * (to - from));
        cairo_line_to(cairo_.get(), p.x(), p.y());
      }
    }
  }

  const Relief& relief_;
  std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface_;
  std::unique_ptr<cairo_t, void (*)(cairo_t*)> cairo_;
};

std::vector<Vector2d> mirrored(std::vector<Vector2d> points) {
  for (Vector2d& p : points) p.x() = -p.x();
  return points;
}

void paint_face(Paint& paint) {
  paint.colour(0xe9c2a0);
  paint.everywhere();
  paint.colour(0xe0a48c);
  for (const double x : {-40.0, 40.0}) paint.ellipse({x, -18}, 17, 14);
  paint.colour(0xc99b78);
  paint.net(0.5);
  const std::vector<Vector2d> eye{{15, 20}, {22, 27}, {30, 29.5}, {38, 27},
                                  {45, 21}, {37, 16}, {29, 14.5}, {21, 16.5}};
  const std::vector<Vector2d> arch{{13, 36}, {22, 42}, {32, 44}, {42, 42}, {50, 36}};
  for (const bool left : {false, true}) {
    const double x = left ? -30 : 30;
    paint.colour(0xffffff);
    paint.polygon(left ? mirrored(eye) : eye);
    paint.colour(0x2f6f8f);
    paint.ellipse({x, 22}, 6.5, 6.8);
    paint.colour(0x101418);
    paint.ellipse({x, 22}, 2.8, 3);
    paint.colour(0x5a3a26);
    paint.line(left ? mirrored(arch) : arch, 3);
  }
  paint.colour(0xb5323c);
  paint.polygon({{-22, -47},
                 {-12, -41},
                 {-4, -38},
                 {0, -40},
                 {4, -38},
                 {12, -41},
                 {22, -47},
                 {12, -55},
                 {0, -58},
                 {-12, -55}});
  paint.colour(0x7a1f28);
  paint.line({{-20, -47}, {-8, -48}, {0, -47}, {8, -48}, {20, -47}}, 0.8);
}

void paint_penguin(Paint& paint) {
  paint.colour(0x2b3440);
  paint.everywhere();
  paint.colour(0xf4f2ea);
  paint.ellipse({0, -20}, 36, 50);
  for (const double x : {-13.0, 13.0}) paint.ellipse({x, 66}, 13, 17);
  paint.colour(0x8a94a0);
  paint.net(0.5);
  paint.colour(0xf08a24);
  paint.polygon({{-9, 60}, {0, 66}, {9, 60}, {0, 47}});
  for (const double x : {-24.0, 24.0}) paint.ellipse({x, -88}, 19, 14);
  paint.colour(0x101418);
  for (const double x : {-13.0, 13.0}) paint.ellipse({x, 72}, 4, 4.5);
  paint.colour(0xc62f3b);
  paint.polygon(
      {{-44, 34}, {-20, 27}, {0, 25}, {20, 27}, {44, 34}, {40, 45}, {20, 38}, {0, 36}, {-20, 38}, {-40, 45}});
  paint.colour(0x2b7a4b);
  for (const double y : {4.0, -14.0, -32.0}) paint.ellipse({0, y}, 3.5, 3.5);
}

std::vector<std::uint8_t> texture_of(Model model, const Relief& relief) {
  Paint paint(relief);
  if (model == Model::mask)
    paint_face(paint);
  else
    paint_penguin(paint);
  for (const auto& [label, at] : landmarks_of(model)) {
    paint.colour(0xffffff);
    for (const double width : {1.6, 0.8}) {
      paint.line({at - Vector2d(3, 0), at + Vector2d(3, 0)}, width);
      paint.line({at - Vector2d(0, 3), at + Vector2d(0, 3)}, width);
      paint.colour(0x153a8a);
    }
    paint.label(label, at + Vector2d(2, 2), 5);
  }
  return paint.png();
}

}  // namespace

PaintedModel painted_model(Model model) {
  const std::unique_ptr<Relief> relief = relief_of(model);
  PaintedModel out;
  const auto add = [&](const Vector2d& at, double height) {
    out.mesh.vertices.emplace_back(at.x(), at.y(), height);
    out.uv.push_back(relief->uv(at));
    return static_cast<int>(out.mesh.vertices.size()) - 1;
  };
  const int top = add({0, 0}, relief->height({0, 0}, 0));
  for (int ring = 1; ring <= circles; ++ring)
    for (int k = 0; k < sectors; ++k) {
      const double angle = 4 * quarter * k / sectors, t = std::sin(quarter * ring / circles);
      const Vector2d at = t * relief->reach(angle) * Vector2d(std::cos(angle), std::sin(angle));
      add(at, ring == circles ? 0 : relief->height(at, t));
    }
  const auto at = [&](int ring, int k) { return 1 + (ring - 1) * sectors + k % sectors; };
  for (int k = 0; k < sectors; ++k) out.mesh.triangles.push_back({top, at(1, k), at(1, k + 1)});
  for (int ring = 1; ring < circles; ++ring)
    for (int k = 0; k < sectors; ++k) {
      out.mesh.triangles.push_back({at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)});
      out.mesh.triangles.push_back({at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)});
    }
  const int below = add({0, 0}, 0);
  for (int k = 0; k < sectors; ++k) out.mesh.triangles.push_back({below, at(circles, k + 1), at(circles, k)});
  for (const auto& [label, plan] : landmarks_of(model)) out.landmarks.push_back({label, relief->place(plan)});
  return out;
}

std::vector<std::uint8_t> painted_glb(Model model) {
  const PaintedModel painted = painted_model(model);
  return textured_glb(painted.mesh, painted.uv, texture_of(model, *relief_of(model)),
                      model == Model::mask ? "mask" : "figurine");
}

}  // namespace vacuform
