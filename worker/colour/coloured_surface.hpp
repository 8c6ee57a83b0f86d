// The surface of a scan with its colours, placed as the mold is.
//
// Takes a scan file with colours (scan/scan_file.hpp) and the placing of the mold (scan/mold.hpp); gives colours of
// places on or near the surface. Nothing is flattened: the colour of a place is that of the closest point of the
// original triangles, whatever was welded, closed, rebuilt, grown or cut away from the mold.
#pragma once

#include <memory>
#include <optional>

#include "worker/colour/texture.hpp"
#include "worker/scan/mold.hpp"
#include "worker/scan/mold_distance.hpp"
#include "worker/scan/scan_file.hpp"

namespace vacuform {

// Immutable, cheap to copy and safe to use from several threads.
class ColouredSurface {
 public:
  // Reads the scan again, with its colours, and unpacks its images. `file_name` as in make_mold(). Errors: those of
  // read_scan() and Texture::read(); unusable_scan (no colours).
  static Result<ColouredSurface> read(std::span<const std::uint8_t> bytes, const std::string& file_name,
                                      const ScanPlacing& placing, const Context& context);

  const TriangleMesh& mesh() const { return parts_->mesh; }  // in the mold's frame, mm
  std::optional<MoldDistance::Nearest> nearest(const Eigen::Vector3d& place, double within_mm) const {
    return parts_->distance.nearest(place, within_mm);
  }
  // Red, green and blue in linear light at a place of a triangle of mesh(): the mean over a square around it in its
  // plane, whose side is in mm.
  Eigen::Vector3f colour(int triangle, const Eigen::Vector3d& weights, double side_mm) const;

 private:
  friend class ColourWalk;
  struct Parts {
    Parts(TriangleMesh placed, ScanColours of_file)
        : mesh(std::move(placed)), colours(std::move(of_file)), distance(mesh) {}
    TriangleMesh mesh;
    ScanColours colours;
    std::vector<Texture> textures;  // parallel to colours.images
    MoldDistance distance;
  };
  explicit ColouredSurface(std::shared_ptr<const Parts> parts) : parts_(std::move(parts)) {}
  std::shared_ptr<const Parts> parts_;
};

// Colours at places in a row; most are found without a search. The same places in the same order give the same colours.
class ColourWalk {
 public:
  // Each colour is the mean over a parallelogram around its place with sides `across` and `down`, mm in space,
  // projected along the normal of the surface. Keeps a reference to the surface.
  ColourWalk(const ColouredSurface& surface, const Eigen::Vector3d& across, const Eigen::Vector3d& down)
      : parts_(*surface.parts_), across_(across), down_(down) {}

  struct Found {
    Eigen::Vector3f linear;  // red, green, blue in linear light
    Eigen::Vector3d place;   // where the surface has it, mold's frame, mm
    double distance_mm;
  };
  // Nothing if the surface is further away than `within_mm`.
  std::optional<Found> at(const Eigen::Vector3d& place, double within_mm);

 private:
  friend class ColouredSurface;
  void enter(int triangle);
  Eigen::Vector3f colour(const Eigen::Vector3d& weights) const;

  const ColouredSurface::Parts& parts_;
  Eigen::Vector3d across_, down_;
  int triangle_ = -1;                                 // that of the last place
  Eigen::Vector3d origin_, normal_, second_, third_;  // a corner; gradients of the weights of the other two
  const Texture* texture_ = nullptr;
  const ScanMaterial* material_ = nullptr;
  Footprint footprint_;
};

}  // namespace vacuform
