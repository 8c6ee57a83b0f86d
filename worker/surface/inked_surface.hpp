// The sheet's inked surface as one triangulation to walk on: the whole sheet, not only the chart.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "worker/surface/path_mesh.hpp"
#include "worker/surface/sheet_point.hpp"

namespace vacuform {

// Made once of a formed sheet and its inked face (forming/inked_face.hpp), in one pass over the triangles.
class InkedSurface {
 public:
  // `inked`: in space, mm; `rest`: sheet coordinates, mm; both one a vertex.
  InkedSurface(std::vector<Triangle> triangles, std::vector<Eigen::Vector3d> inked,
               std::vector<Eigen::Vector2d> rest);

  const std::vector<Triangle>& triangles() const { return path_mesh_.triangles(); }
  const std::vector<Eigen::Vector3d>& inked() const { return path_mesh_.places(); }
  const std::vector<Eigen::Vector2d>& rest() const { return rest_; }
  // Neighbour of triangle t across the edge opposite its corner k; -1 on the sheet's border.
  int across(int t, int k) const {
    const int opposite = path_mesh_.side(3 * t + k).opposite;
    return opposite < 0 ? -1 : opposite / 3;
  }
  // Outward unit normal of a triangle; zero where it has no area.
  const Eigen::Vector3d& normal(int t) const { return faces_[t].normal; }
  // Change of the barycentric weight k per millimetre, a vector in the triangle's plane; zero without area.
  const Eigen::Vector3d& gradient(int t, int k) const { return faces_[t].gradient[k]; }
  const PathMesh& path_mesh() const { return path_mesh_; }

  Eigen::Vector3d place(const SheetPoint& p) const { return interpolate(triangles(), p, inked()); }  // mm
  Eigen::Vector2d rest(const SheetPoint& p) const { return interpolate(triangles(), p, rest_); }     // mm

  // The direction in the plane of triangle t that is the first axis of coordinates `flat` of the vertices, by the
  // rotation nearest to their map there.
  Eigen::Vector3d axis(int t, const std::vector<Eigen::Vector2d>& flat) const;

 private:
  struct Face {
    Eigen::Vector3d normal;
    std::array<Eigen::Vector3d, 3> gradient;
  };
  PathMesh path_mesh_;
  std::vector<Eigen::Vector2d> rest_;
  std::vector<Face> faces_;
};

}  // namespace vacuform
