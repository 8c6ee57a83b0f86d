#include "worker/inspection/view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/inspection/side_marks.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/surface/vertex_normals.hpp"

namespace vacuform {
namespace {

using Eigen::Vector3d;
// Azimuths are those of the eye, from +y towards -x.
constexpr double from_the_front = 28 * M_PI / 180, slanted = 52 * M_PI / 180;
constexpr double straight = 18 * M_PI / 180;   // so that the foot is visible
constexpr double half_view = 11 * M_PI / 180;  // a long lens: little perspective
const Vector3d key_light = Vector3d(0.25, 0.67, 0.75).normalized();

const Vector3d& at(const std::vector<Vector3d>& points, int i) { return points[i]; }

// Near the foot, where the sheet turns from the wall to the platform, the grid makes steps that the part does not have.
constexpr double platform_mm = 0.3, foot_mm = 8;
constexpr int foot_rounds = 6, sky_rounds = 3;

double lowest(const TriangleMesh& mesh) {
  double low = INFINITY;
  for (const Vector3d& p : mesh.vertices) low = std::min(low, p.z());
  return low;
}

// The mean of each value and its neighbours', repeated; `part` selects the vertices.
template <class Value, class Part>
void smooth(const TriangleMesh& mesh, std::vector<Value>& values, int rounds, Part&& part) {
  for (int round = 0; round < rounds; ++round) {
    std::vector<Value> sum = values;
    std::vector<float> count(values.size(), 1);
    for (const Triangle& t : mesh.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto v = static_cast<std::size_t>(t[k]);
        for (const std::size_t other : {(k + 1) % 3, (k + 2) % 3}) sum[v] += values[t[other]], ++count[v];
      }
    for (std::size_t v = 0; v < values.size(); ++v)
      if (part(v)) values[v] = sum[v] / count[v];
  }
}

std::vector<Vector3d> shading_normals(const TriangleMesh& mesh) {
  std::vector<Vector3d> normals = vertex_normals(mesh.vertices, mesh.triangles);
  const double low = lowest(mesh);
  smooth(mesh, normals, foot_rounds, [&](std::size_t v) { return mesh.vertices[v].z() < low + foot_mm; });
  for (Vector3d& n : normals) n = n.squaredNorm() > 0 ? n.normalized() : Vector3d(0, 0, 1);
  return normals;
}

// What stands above the platform of a sheet on its mold.
std::vector<Vector3d> drawn_part(const FormedSheet& sheet) {
  double highest = 0;
  for (const auto& p : sheet.formed) highest = std::max(highest, p.z());
  std::vector<Vector3d> drawn;
  for (std::size_t i = 0; i < sheet.formed.size(); ++i)
    if (sheet.contact[i] == Contact::mold ||
        (sheet.contact[i] != Contact::clamp && sheet.formed[i].z() > 0.15 * highest))
      drawn.push_back(sheet.formed[i]);
  return drawn.empty() ? sheet.formed : drawn;
}

// Evenly spread directions about +z, denser towards it by the cosine (a Fibonacci spiral on the disk,
// lifted).
std::vector<Vector3d> sky(int count) {
  std::vector<Vector3d> directions;
  for (int i = 0; i < count; ++i) {
    const double r = std::sqrt((i + 0.5) / count), angle = i * M_PI * (3 - std::sqrt(5.0));
    directions.emplace_back(r * std::cos(angle), r * std::sin(angle), std::sqrt(1 - r * r));
  }
  return directions;
}

Rgb background_at(double height) {
  return Rgb(0.985f, 0.985f, 0.99f) - static_cast<float>(height) * Rgb(0.085f, 0.08f, 0.07f);
}

std::uint32_t pixel_of(const Rgb& c) {
  const auto byte = [](float v) {
    return static_cast<std::uint32_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255));
  };
  return 0xff000000u | byte(c.x()) << 16 | byte(c.y()) << 8 | byte(c.z());
}

}  // namespace

View::View(TriangleMesh mesh, std::vector<Vector3d> shown, SideLetters letters, int width, int height,
           int top, int bottom, bool shadows)
    : mesh_(std::move(mesh)),
      shown_(std::move(shown)),
      letters_(std::move(letters)),
      width_(width),
      height_(height),
      top_(top),
      bottom_(bottom),
      azimuth_(from_the_front),
      elevation_(slanted),
      rays_(shadows ? mesh_ : TriangleMesh{}),
      normals_(shading_normals(mesh_)) {
  if (!shadows) open_.assign(mesh_.vertices.size(), 1.0f);
  if (shown_.empty()) shown_.push_back(Vector3d::Zero());
  frame();
}

View::View(const FormedSheet& sheet, SideLetters letters, int width, int height, int top, int bottom)
    : View({sheet.formed, sheet.triangles}, drawn_part(sheet), std::move(letters), width, height, top,
           bottom) {}

void View::look_from(Side side, int height, int top, int bottom) {
  look_from(side, width_, height, top, bottom);
}

void View::look_from(Side side, int width, int height, int top, int bottom) {
  width_ = width, height_ = height, top_ = top, bottom_ = bottom;
  elevation_ = straight;
  switch (side) {
    case Side::front:
    case Side::behind:
      azimuth_ = from_the_front + (side == Side::behind ? M_PI : 0);
      elevation_ = slanted;
      break;
    case Side::straight_front:
      azimuth_ = 0;
      break;
    case Side::straight_back:
      azimuth_ = M_PI;
      break;
    case Side::minus_x:
      azimuth_ = M_PI / 2;
      break;
    case Side::plus_x:
      azimuth_ = -M_PI / 2;
      break;
    case Side::above:
      azimuth_ = M_PI, elevation_ = M_PI / 2;  // the front is at the top of the picture
      break;
  }
  frame();
}

// Moves the eye so that the part to be shown just fills the picture.
void View::frame() {
  back_ = {-std::sin(azimuth_) * std::cos(elevation_), std::cos(azimuth_) * std::cos(elevation_),
           std::sin(elevation_)};
  right_ = {-std::cos(azimuth_), -std::sin(azimuth_), 0};
  up_ = back_.cross(right_);
  tangent_ = std::tan(half_view);
  const double room_x = 0.88 * tangent_;
  const double room_y = 0.88 * tangent_ * (height_ - top_ - bottom_) / width_;

  Vector3d target = Vector3d::Zero();
  double distance = 1;
  for (int pass = 0; pass < 4; ++pass) {
    // The picture's middle is where the extremes on either side are equally far away, seen from the present distance.
    double left = INFINITY, low = INFINITY, rightmost = -INFINITY, high = -INFINITY;
    for (const auto& p : shown_) {
      const Vector3d d = p - target;
      const double scale = pass == 0 ? 1 : distance / (distance - d.dot(back_));
      left = std::min(left, d.dot(right_) * scale), rightmost = std::max(rightmost, d.dot(right_) * scale);
      low = std::min(low, d.dot(up_) * scale), high = std::max(high, d.dot(up_) * scale);
    }
    target += (left + rightmost) / 2 * right_ + (low + high) / 2 * up_;
    distance = 1;
    for (const auto& p : shown_) {
      const Vector3d d = p - target;
      distance = std::max({distance, d.dot(back_) + std::abs(d.dot(right_)) / room_x,
                           d.dot(back_) + std::abs(d.dot(up_)) / room_y});
    }
  }
  eye_ = target + distance * back_;
}

Result<void> View::light(const Context& context, double from, double to) {
  if (!open_.empty()) return {};  // seen from elsewhere, the sky is the same
  const int vertices = static_cast<int>(mesh_.vertices.size());
  // Enough directions for a smooth shade on coarse meshes, fewer on fine ones, where neighbours smooth it.
  const auto directions = sky(std::clamp(500'000 / std::max(1, vertices), 8, 32));
  open_.assign(mesh_.vertices.size(), 1.0f);
  // No shadow on the platform; shadows fade towards it.
  const double low = lowest(mesh_);
  const auto on_platform = [&](std::size_t v) { return mesh_.vertices[v].z() < low + platform_mm; };
  constexpr int batch = 20'000;
  for (int begin = 0; begin < vertices; begin += batch) {
    VACUFORM_CHECK(context.step(Stage::inspection, from + (to - from) * begin / vertices));
    in_parallel(begin, std::min(begin + batch, vertices), [&](int first, int last) {
      for (int i = first; i < last; ++i) {
        if (on_platform(static_cast<std::size_t>(i))) continue;
        const Vector3d n = at(normals_, i);
        const Vector3d a = n.unitOrthogonal(), b = n.cross(a);
        int hidden = 0;
        for (const auto& d : directions) {
          const Vector3d ray = d.x() * a + d.y() * b + d.z() * n;
          if (rays_.first_hit(at(mesh_.vertices, i) + 0.8 * n + 0.4 * ray, 90 * ray)) ++hidden;
        }
        open_[i] = 1 - static_cast<float>(hidden) / static_cast<float>(directions.size());
      }
    });
  }
  smooth(mesh_, open_, sky_rounds, [](std::size_t) { return true; });
  smooth(mesh_, open_, foot_rounds, [&](std::size_t v) { return mesh_.vertices[v].z() < low + foot_mm; });
  return {};
}

Seen View::seen(const VisibleTriangles::Sample& sample, const Vector3d& aim) const {
  const auto& t = mesh_.triangles[sample.triangle];
  const double u = sample.u, v = sample.v;
  const std::array<double, 3> w{1 - u - v, u, v};
  const auto mix = [&](const auto& values) {
    return w[0] * values[t[0]] + w[1] * values[t[1]] + w[2] * values[t[2]];
  };
  const double length = aim.norm(), spacing = tangent_ / width_ * length / sample.nearness;
  Vector3d normal = mix(normals_);
  if (const double size = normal.norm(); size > 0) normal *= 1 / size;
  const Vector3d towards = -1 / length * aim;
  double facing = normal.dot(towards);
  if (facing < 0) normal = -normal, facing = -facing;
  const double open = mix(open_);
  const double key = std::max(0.0, normal.dot(key_light));
  const Vector3d halfway = key_light + towards;
  const double ahead = std::max(0.0, normal.dot(halfway)), square = halfway.squaredNorm();
  // The 64th power of a cosine; what the condition cuts off is far below one level of gray.
  double gloss = ahead * ahead > 0.7 * square ? ahead * ahead / square : 0;
  for (int power = 2; power < 64; power *= 2) gloss *= gloss;
  const double light = (0.25 + 0.75 * open) * (0.47 + 0.13 * normal.z()) + 0.40 * key * (0.4 + 0.6 * open);
  return {sample.triangle, w, spacing / std::max(0.35, facing), static_cast<float>(light),
          static_cast<float>(0.10 * gloss * open)};
}

Camera View::camera() const {
  return {eye_, right_, up_, back_, 2 * tangent_ / width_, 0.5 * width_, middle_row()};
}

std::optional<View::Spot> View::spot(const Vector3d& place) const {
  const Vector3d way = place - eye_;
  const double depth = -way.dot(back_);
  if (depth <= 0) return std::nullopt;
  const double pixel = 2 * tangent_ / width_;  // at distance 1
  const auto hit = rays_.first_hit(eye_, way);
  return Spot{0.5 * width_ + way.dot(right_) / depth / pixel, middle_row() - way.dot(up_) / depth / pixel,
              1 / (depth * pixel), hit ? (1 - hit->t) * way.norm() : 0};
}

Result<std::vector<Picture>> View::draw(int count, const std::function<void(const Seen&, Rgb*)>& shade,
                                        const Context& context, double from, double to) {
  const double lit = from + 0.2 * (to - from);
  VACUFORM_CHECK(light(context, from, lit));
  const std::size_t n = static_cast<std::size_t>(count), columns = static_cast<std::size_t>(width_);
  std::vector<Picture> pictures(n);
  for (auto& p : pictures)
    p = {width_, height_, std::vector<std::uint32_t>(columns * static_cast<std::size_t>(height_))};
  const int end = height_ - bottom_;
  const Camera camera = this->camera();
  const VisibleTriangles visible(mesh_, camera, width_);

  const auto rows = [&](int first, int last) {
    std::vector<Rgb> sums(n), colours(n);
    std::vector<VisibleTriangles::Sample> samples;
    visible.see(first, last, samples);
    for (int y = first; y < last; ++y) {
      const Rgb behind = background_at(static_cast<double>(y) / height_);
      for (int x = 0; x < width_; ++x) {
        std::fill(sums.begin(), sums.end(), Rgb(0, 0, 0));
        for (const int dy : {0, 1})
          for (const int dx : {0, 1}) {
            const VisibleTriangles::Sample& sample =
                samples[static_cast<std::size_t>(2 * (y - first) + dy) * 2 * columns +
                        static_cast<std::size_t>(2 * x + dx)];
            if (sample.triangle >= 0)
              shade(seen(sample, camera.aim(x + 0.25 + 0.5 * dx, y + 0.25 + 0.5 * dy)), colours.data());
            else
              std::fill(colours.begin(), colours.end(), behind);
            for (std::size_t k = 0; k < n; ++k) sums[k] += colours[k];
          }
        for (std::size_t k = 0; k < n; ++k)
          pictures[k].pixels[static_cast<std::size_t>(y) * columns + static_cast<std::size_t>(x)] =
              pixel_of(sums[k] / 4);
      }
    }
  };
  constexpr int band = 50;
  for (int y = top_; y < end; y += band) {
    VACUFORM_CHECK(context.step(Stage::inspection, lit + (to - lit) * (y - top_) / (end - top_)));
    in_parallel(y, std::min(y + band, end), rows);
  }
  if (!detail_)
    for (Picture& picture : pictures) write_sides(*this, letters_, picture, top_, end);
  return pictures;
}

}  // namespace vacuform
