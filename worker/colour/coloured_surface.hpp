// The surface of a scan with its colours, placed as the mold is.
//
// Takes a scan file with colours (scan/scan_file.hpp) and the placing of the mold (scan/mold.hpp); gives colours of
// places on or near the surface. Nothing is flattened: the colour of a place is that of the closest point of the
// original triangles, whatever was welded, closed, rebuilt, grown or cut away from the mold.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "worker/colour/texture.hpp"
#include "worker/scan/mold.hpp"
#include "worker/scan/mold_distance.hpp"
#include "worker/scan/scan_file.hpp"
#include "worker/surface/adjacency.hpp"

namespace vacuform {

// A scan with its colours as the file has it, its images unpacked.
struct ColouredScan {
  TriangleMesh mesh;
  ScanColours colours;
  std::vector<Texture> textures;       // parallel to colours.images
  std::vector<Warning> warnings = {};  // file-unusual, colours-missing
};
// `file_name` as in make_mold(). Errors: those of read_scan() and Texture::read(); unusable_scan (no colours).
Result<ColouredScan> read_coloured_scan(std::span<const std::uint8_t> bytes, const std::string& file_name,
                                        const Context& context);

// Immutable, cheap to copy and safe to use from several threads.
class ColouredSurface {
 public:
  // The scan in the mold's frame.
  ColouredSurface(ColouredScan scan, const ScanPlacing& placing);

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
    explicit Parts(ColouredScan placed)
        : mesh(std::move(placed.mesh)),
          colours(std::move(placed.colours)),
          textures(std::move(placed.textures)),
          distance(mesh),
          at_vertex(mesh.triangles, mesh.vertices.size()) {}
    TriangleMesh mesh;
    ScanColours colours;
    std::vector<Texture> textures;
    MoldDistance distance;
    VertexTriangles at_vertex;
  };
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
    go_to(start);
  }
  // The triangle of the last place, or -1.
  int triangle() const { return triangle_; }
  // Goes on from this triangle, or by a search if that is -1.
  void go_to(int triangle) { triangle_ = triangle; }

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
  };
  // What colours in a triangle need. Neighbouring rows of places cross the same few triangles.
  struct CachedTriangle {
    int triangle = -1;
    Plane plane;
    const ScanMaterial* material = nullptr;
    const Texture* texture = nullptr;  // null without
    Footprint footprint;
  };
  const CachedTriangle& cached(int triangle);
  Plane plane_of(int triangle) const;
  // The triangle on the other side of the edge opposite to a corner; -1 if there is not exactly one.
  int neighbour(int triangle, Eigen::Index corner) const;
  // The triangle below the place, if the walk reaches one.
  const CachedTriangle* below(const Eigen::Vector3d& place);
  Eigen::Vector3f colour(const CachedTriangle& held, const Eigen::Vector3d& weights) const;

  const ColouredSurface::Parts* parts_;
  Eigen::Vector3d across_, down_;
  int triangle_ = -1;
  std::array<CachedTriangle, 8> cached_;  // the last ones, each at its triangle modulo their number
};

}  // namespace vacuform
