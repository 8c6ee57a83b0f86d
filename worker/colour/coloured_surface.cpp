#include "worker/colour/coloured_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace vacuform {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

// If a place lies over a triangle that the walk reached and this near to it, no other triangle is searched: the sheet
// touches the surface there.
constexpr double beside_mm = 0.25;
// Across sharper edges, as the cosine of the turn, the other side may be nearer.
constexpr double gentle = 0.5;
constexpr int longest_walk = 32;
// A vertex of more triangles is not worth the look around it.
constexpr std::size_t most_around = 32;

using UvCorners = std::array<Eigen::Vector2f, 3>;

Vector2d uv_at(const UvCorners& uv, const Vector3d& weights) {
  return weights[0] * uv[0].cast<double>() + weights[1] * uv[1].cast<double>() +
         weights[2] * uv[2].cast<double>();
}

void mark_shown(const ScanColours& colours, std::vector<Texture>& textures) {
  std::vector<std::vector<UvCorners>> of_material(colours.materials.size());
  for (std::size_t t = 0; t < colours.material.size(); ++t) {
    const auto m = static_cast<std::size_t>(colours.material[t]);
    if (colours.materials[m].image >= 0) of_material[m].push_back(colours.uv[t]);
  }
  for (std::size_t m = 0; m < of_material.size(); ++m)
    if (const ScanMaterial& material = colours.materials[m]; material.image >= 0)
      textures[static_cast<std::size_t>(material.image)].mark_shown(of_material[m], material.across,
                                                                    material.down);
}

}  // namespace

Result<ColouredSurface> ColouredSurface::read(std::span<const std::uint8_t> bytes,
                                              const std::string& file_name, const ScanPlacing& placing,
                                              const Context& context) {
  const ScanProgress progress(context);
  VACUFORM_TRY(scan, read_scan(bytes, file_name, progress, ScanParts::with_colours));
  if (!scan.colours)
    return fail(Code::unusable_scan, "the scan has no colours (" + scan.format + ")", file_name,
                "give a GLB with textures, an OBJ or PLY with its textures in a zip or with vertex colours, "
                "or pattern.source=file and a "
                "pattern");
  for (auto& p : scan.mesh.vertices) p = placing(p);
  std::vector<Texture> textures;
  std::int64_t left = most_texture_pixels;
  for (ScanImage& image : scan.colours->images) {
    VACUFORM_CHECK(progress.tick());
    VACUFORM_TRY(texture, Texture::read(image, file_name, left));
    left -= texture.pixels();
    image.bytes = std::vector<std::uint8_t>();  // `= {}` would keep the memory
    textures.push_back(std::move(texture));
  }
  mark_shown(*scan.colours, textures);
  for (Texture& texture : textures) {
    VACUFORM_CHECK(progress.tick());
    texture.build();
  }
  auto parts = std::make_shared<Parts>(std::move(scan.mesh), *std::move(scan.colours));
  parts->textures = std::move(textures);
  return ColouredSurface(std::move(parts));
}

Vector3f ColouredSurface::colour(int triangle, const Vector3d& weights, double side_mm) const {
  const Triangle& corners = parts_->mesh.triangles[static_cast<std::size_t>(triangle)];
  const auto side = [&](std::size_t k) -> Vector3d {
    return parts_->mesh.vertices[static_cast<std::size_t>(corners[k])] -
           parts_->mesh.vertices[static_cast<std::size_t>(corners[0])];
  };
  const Vector3d across = side(1).normalized(), down = (side(2) - side(2).dot(across) * across).normalized();
  ColourWalk walk(*this, side_mm * across, side_mm * down);
  walk.enter(triangle, walk.plane_of(triangle));
  return walk.colour(weights);
}

ColourWalk::Plane ColourWalk::plane_of(int triangle) const {
  const Triangle& corners = parts_->mesh.triangles[static_cast<std::size_t>(triangle)];
  const auto corner = [&](std::size_t k) -> const Vector3d& {
    return parts_->mesh.vertices[static_cast<std::size_t>(corners[k])];
  };
  const Vector3d ab = corner(1) - corner(0), ac = corner(2) - corner(0);
  const double bb = ab.squaredNorm(), bc = ab.dot(ac), cc = ac.squaredNorm(), d = bb * cc - bc * bc;
  const Vector3d none = Vector3d::Zero();
  if (!(d > 0)) return {corner(0), none, none, none};
  const double one = 1 / d;  // d is the square of the length of the cross product
  return {corner(0), std::sqrt(one) * ab.cross(ac), one * (cc * ab - bc * ac), one * (bb * ac - bc * ab)};
}

int ColourWalk::neighbour(int triangle, Eigen::Index corner) const {
  const Triangle& corners = parts_->mesh.triangles[static_cast<std::size_t>(triangle)];
  const auto k = static_cast<std::size_t>(corner);
  const int from = corners[(k + 1) % 3], to = corners[(k + 2) % 3];
  const auto around = parts_->at_vertex.around(from);
  if (around.size() > most_around) return -1;
  int found = -1;
  for (const int other : around) {
    const Triangle& theirs = parts_->mesh.triangles[static_cast<std::size_t>(other)];
    if (other == triangle || std::find(theirs.begin(), theirs.end(), to) == theirs.end()) continue;
    if (found >= 0) return -1;
    found = other;
  }
  return found;
}

std::optional<double> ColourWalk::reach(const Vector3d& place, double within_mm) {
  int triangle = triangle_;
  Plane plane = plane_;
  for (int step = 0; step < longest_walk && plane.normal != Vector3d::Zero(); ++step) {
    Eigen::Index outside = 0;
    if (plane.weights(place).minCoeff(&outside) >= 0) {
      const double distance = plane.distance(place);
      if (distance <= within_mm) enter(triangle, plane);
      return distance;
    }
    triangle = neighbour(triangle, outside);
    if (triangle < 0) return std::nullopt;
    const Plane next = plane_of(triangle);
    if (!(next.normal.dot(plane.normal) > gentle)) return std::nullopt;
    plane = next;
  }
  return std::nullopt;
}

void ColourWalk::enter(int triangle, const Plane& plane) {
  if (triangle == triangle_) return;
  triangle_ = triangle;
  plane_ = plane;
  const auto t = static_cast<std::size_t>(triangle);
  material_ = &parts_->colours.materials[static_cast<std::size_t>(parts_->colours.material[t])];
  texture_ = material_->image < 0 ? nullptr : &parts_->textures[static_cast<std::size_t>(material_->image)];
  if (!texture_) return;
  const UvCorners& uv = parts_->colours.uv[t];
  const Vector2d along_ab = (uv[1] - uv[0]).cast<double>(), along_ac = (uv[2] - uv[0]).cast<double>();
  const auto change = [&](const Vector3d& by) -> Vector2d {
    return plane.second.dot(by) * along_ab + plane.third.dot(by) * along_ac;
  };
  footprint_ = texture_->footprint(change(across_), change(down_));
}

Vector3f ColourWalk::colour(const Vector3d& weights) const {
  Vector3f out = material_->factor;
  const auto t = static_cast<std::size_t>(triangle_);
  if (texture_)
    out = out.cwiseProduct(texture_->sample(uv_at(parts_->colours.uv[t], weights), footprint_,
                                            material_->across, material_->down));
  if (const auto& vertex = parts_->colours.vertex; !vertex.empty()) {
    const Triangle& corners = parts_->mesh.triangles[t];
    Vector3f mean = Vector3f::Zero();
    for (int k = 0; k < 3; ++k)
      mean += static_cast<float>(weights[k]) *
              vertex[static_cast<std::size_t>(corners[static_cast<std::size_t>(k)])];
    out = out.cwiseProduct(mean);
  }
  return out;
}

std::optional<ColourWalk::Found> ColourWalk::at(const Vector3d& place, double within_mm) {
  const auto below = triangle_ >= 0 ? reach(place, std::min(beside_mm, within_mm)) : std::nullopt;
  if (below && *below <= std::min(beside_mm, within_mm)) {
    const double height = plane_.normal.dot(place - plane_.origin);
    return Found{colour(plane_.weights(place)), place - height * plane_.normal, *below};
  }
  // The surface is at most this far: a smaller sphere holds fewer triangles.
  constexpr double slack = 1.001;
  const double most_mm =
      1e-6 + slack * std::min(last_mm_ + (place - last_).norm(), below.value_or(within_mm));
  const auto nearest = parts_->distance.nearest(place, std::min(within_mm, most_mm));
  if (!nearest) return std::nullopt;
  last_ = place;
  last_mm_ = nearest->distance_mm;
  enter(nearest->triangle, plane_of(nearest->triangle));
  const Triangle& corners = parts_->mesh.triangles[static_cast<std::size_t>(nearest->triangle)];
  Vector3d on_surface = Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    on_surface += nearest->weights[k] *
                  parts_->mesh.vertices[static_cast<std::size_t>(corners[static_cast<std::size_t>(k)])];
  return Found{colour(nearest->weights), on_surface, nearest->distance_mm};
}

}  // namespace vacuform
