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

std::string reasons(const ScanFile& scan) {
  std::string text;
  for (const auto* list : {&scan.colours_missing, &scan.colour_notes})
    for (const std::string& reason : *list) text.append(text.empty() ? ": " : "; ").append(reason);
  return text;
}

void mark_shown(const ScanColours& colours, std::vector<Texture>& textures) {
  std::vector<std::vector<UvCorners>> of_material(colours.materials.size());
  for (std::size_t t = 0; t < colours.material.size(); ++t) {
    const auto m = static_cast<std::size_t>(colours.material[t]);
    if (colours.materials[m].image >= 0) of_material[m].push_back(colours.uv[t]);
  }
  for (std::size_t m = 0; m < of_material.size(); ++m)
    if (const ScanMaterial& material = colours.materials[m]; material.image >= 0)
      textures[material.image].mark_shown(of_material[m], material.across, material.down);
}

}  // namespace

Result<ColouredScan> read_coloured_scan(std::span<const std::uint8_t> bytes, const std::string& file_name,
                                        const Context& context) {
  const ScanProgress progress(context);
  VACUFORM_TRY(scan, read_scan(bytes, file_name, progress, ScanParts::with_colours));
  if (!scan.colours)
    return fail(Code::unusable_scan, "the scan has no colours (" + scan.format + ")" + reasons(scan),
                file_name,
                "give a GLB with textures, an OBJ or PLY with its textures in a zip or with vertex colours, "
                "or pattern.source=file and a "
                "pattern");
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
  std::vector<Warning> warnings;
  for (const std::string& note : scan.colour_notes) warnings.push_back({"file-unusual", note});
  for (const std::string& missing : scan.colours_missing) warnings.push_back({"colours-missing", missing});
  return ColouredScan{std::move(scan.mesh), *std::move(scan.colours), std::move(textures),
                      std::move(warnings)};
}

ColouredSurface::ColouredSurface(ColouredScan scan, const ScanPlacing& placing) {
  for (auto& p : scan.mesh.vertices) p = placing(p);
  parts_ = std::make_shared<const Parts>(std::move(scan));
}

Vector3f ColouredSurface::colour(int triangle, const Vector3d& weights, double side_mm) const {
  const Triangle& corners = parts_->mesh.triangles[triangle];
  const auto side = [&](std::size_t k) -> Vector3d {
    return parts_->mesh.vertices[corners[k]] - parts_->mesh.vertices[corners[0]];
  };
  const Vector3d across = side(1).normalized(), down = (side(2) - side(2).dot(across) * across).normalized();
  ColourWalk walk(*this, side_mm * across, side_mm * down);
  return walk.colour(walk.cached(triangle), weights);
}

ColourWalk::Plane ColourWalk::plane_of(int triangle) const {
  const Triangle& corners = parts_->mesh.triangles[triangle];
  const auto corner = [&](std::size_t k) -> const Vector3d& { return parts_->mesh.vertices[corners[k]]; };
  const Vector3d ab = corner(1) - corner(0), ac = corner(2) - corner(0);
  const double bb = ab.squaredNorm(), bc = ab.dot(ac), cc = ac.squaredNorm(), d = bb * cc - bc * bc;
  const Vector3d none = Vector3d::Zero();
  if (!(d > 0)) return {corner(0), none, none, none};
  const double one = 1 / d;  // d is the square of the length of the cross product
  return {corner(0), std::sqrt(one) * ab.cross(ac), one * (cc * ab - bc * ac), one * (bb * ac - bc * ab)};
}

int ColourWalk::neighbour(int triangle, Eigen::Index corner) const {
  const Triangle& corners = parts_->mesh.triangles[triangle];
  const auto k = static_cast<std::size_t>(corner);
  const int from = corners[(k + 1) % 3], to = corners[(k + 2) % 3];
  const auto around = parts_->at_vertex.around(from);
  if (around.size() > most_around) return -1;
  int found = -1;
  for (const int other : around) {
    const Triangle& theirs = parts_->mesh.triangles[other];
    if (other == triangle || std::find(theirs.begin(), theirs.end(), to) == theirs.end()) continue;
    if (found >= 0) return -1;
    found = other;
  }
  return found;
}

const ColourWalk::CachedTriangle& ColourWalk::cached(int triangle) {
  const auto t = static_cast<std::size_t>(triangle);
  CachedTriangle& held = cached_[t % cached_.size()];
  if (held.triangle == triangle) return held;
  held.triangle = triangle;
  held.plane = plane_of(triangle);
  held.material = &parts_->colours.materials[parts_->colours.material[t]];
  held.texture = held.material->image < 0 ? nullptr : &parts_->textures[held.material->image];
  if (!held.texture) return held;
  const UvCorners& uv = parts_->colours.uv[t];
  const Vector2d along_ab = (uv[1] - uv[0]).cast<double>(), along_ac = (uv[2] - uv[0]).cast<double>();
  const auto change = [&](const Vector3d& by) -> Vector2d {
    return held.plane.second.dot(by) * along_ab + held.plane.third.dot(by) * along_ac;
  };
  held.footprint = held.texture->footprint(change(across_), change(down_));
  return held;
}

const ColourWalk::CachedTriangle* ColourWalk::below(const Vector3d& place) {
  const CachedTriangle* here = &cached(triangle_);
  for (int step = 0; step < longest_walk && here->plane.normal != Vector3d::Zero(); ++step) {
    Eigen::Index outside = 0;
    if (here->plane.weights(place).minCoeff(&outside) >= 0) return here;
    const int next = neighbour(here->triangle, outside);
    if (next < 0) return nullptr;
    const Vector3d normal = here->plane.normal;
    here = &cached(next);
    if (!(here->plane.normal.dot(normal) > gentle)) return nullptr;
  }
  return nullptr;
}

Vector3f ColourWalk::colour(const CachedTriangle& held, const Vector3d& weights) const {
  Vector3f out = held.material->factor;
  const auto t = static_cast<std::size_t>(held.triangle);
  if (held.texture)
    out = out.cwiseProduct(held.texture->sample(uv_at(parts_->colours.uv[t], weights), held.footprint,
                                                held.material->across, held.material->down));
  if (const auto& vertex = parts_->colours.vertex; !vertex.empty()) {
    const Triangle& corners = parts_->mesh.triangles[t];
    Vector3f mean = Vector3f::Zero();
    for (int k = 0; k < 3; ++k)
      mean += static_cast<float>(weights[k]) * vertex[corners[static_cast<std::size_t>(k)]];
    out = out.cwiseProduct(mean);
  }
  return out;
}

std::optional<ColourWalk::Found> ColourWalk::at(const Vector3d& place, double within_mm) {
  if (triangle_ >= 0)
    if (const CachedTriangle* const under = below(place)) {
      const double height = under->plane.normal.dot(place - under->plane.origin);
      if (std::abs(height) <= std::min(beside_mm, within_mm)) {
        triangle_ = under->triangle;
        return Found{colour(*under, under->plane.weights(place)), place - height * under->plane.normal,
                     std::abs(height)};
      }
    }
  const auto nearest = parts_->distance.nearest(place, within_mm, triangle_);
  if (!nearest) return std::nullopt;
  triangle_ = nearest->triangle;
  const Triangle& corners = parts_->mesh.triangles[triangle_];
  Vector3d on_surface = Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    on_surface += nearest->weights[k] * parts_->mesh.vertices[corners[static_cast<std::size_t>(k)]];
  return Found{colour(cached(triangle_), nearest->weights), on_surface, nearest->distance_mm};
}

}  // namespace vacuform
