// The surface of a scan with its colours, placed as the mold is.
//
// Takes a scan file with colours (scan/scan_file.hpp) and the placing of the mold (scan/mold.hpp); gives colours of
// places on or near the surface. Nothing is flattened: the colour of a place is that of the closest point of the
// original triangles, whatever was welded, closed, rebuilt, grown or cut away from the mold.
#pragma once

#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "worker/colour/texture.hpp"
#include "worker/scan/mold.hpp"
#include "worker/scan/mold_distance.hpp"
#include "worker/scan/scan_file.hpp"
#include "worker/surface/adjacency.hpp"

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
        : mesh(std::move(placed)),
          colours(std::move(of_file)),
          distance(mesh),
          at_vertex(mesh.triangles, mesh.vertices.size()) {}
    TriangleMesh mesh;
    ScanColours colours;
    std::vector<Texture> textures;  // parallel to colours.images
    MoldDistance distance;
    VertexTriangles at_vertex;
  };
  explicit ColouredSurface(std::shared_ptr<const Parts> parts) : parts_(std::move(parts)) {}
  std::shared_ptr<const Parts> parts_;
};

// Colours at places near each other. Where a place is close to the surface, the walk reaches its triangle from that of
// the last place across shared edges (O. Devillers, S. Pion, M. Teillaud 2001, "Walking in a triangulation"); only the
// others are searched. The same places in the same order give the same colours.
class ColourWalk {
 public:
  // Each colour is the mean over a parallelogram around its place with sides `across` and `down`, mm in space,
  // projected along the normal of the surface. The walk begins at triangle `start` of the mesh, or by a search if that
  // is -1. Keeps a reference to the surface.
  ColourWalk(const ColouredSurface& surface, const Eigen::Vector3d& across, const Eigen::Vector3d& down,
             int start = -1)
      : parts_(surface.parts_.get()), across_(across), down_(down) {
    if (start >= 0) enter(start, plane_of(start));
  }

  struct Found {
    Eigen::Vector3f linear;  // red, green, blue in linear light
    Eigen::Vector3d place;   // where the surface has it, mold's frame, mm
    double distance_mm;
  };
  // Nothing if the surface is further away than `within_mm`.
  std::optional<Found> at(const Eigen::Vector3d& place, double within_mm);

 private:
  friend class ColouredSurface;
  // A triangle in space: a corner, and the gradients of the weights of the other two.
  struct Plane {
    Eigen::Vector3d origin, normal, second, third;  // the normal is zero if the triangle has no area

    Eigen::Vector3d weights(const Eigen::Vector3d& place) const {
      const double b = second.dot(place - origin), c = third.dot(place - origin);
      return {1 - b - c, b, c};
    }
    double distance(const Eigen::Vector3d& place) const { return std::abs(normal.dot(place - origin)); }
  };
  Plane plane_of(int triangle) const;
  // The triangle on the other side of the edge opposite to a corner; -1 if there is not exactly one.
  int neighbour(int triangle, Eigen::Index corner) const;
  // The distance of the triangle below the place, if the walk reaches one. Enters it if the distance is at most
  // `within_mm`.
  std::optional<double> reach(const Eigen::Vector3d& place, double within_mm);
  void enter(int triangle, const Plane& plane);
  Eigen::Vector3f colour(const Eigen::Vector3d& weights) const;

  const ColouredSurface::Parts* parts_;
  Eigen::Vector3d across_, down_;
  int triangle_ = -1;  // that of the last place
  Plane plane_;
  Eigen::Vector3d last_ =
      Eigen::Vector3d::Zero();  // the last place whose distance was searched, and the distance
  double last_mm_ = std::numeric_limits<double>::infinity();
  const Texture* texture_ = nullptr;
  const ScanMaterial* material_ = nullptr;
  Footprint footprint_;
};

}  // namespace vacuform
