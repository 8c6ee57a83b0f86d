// The sheet's inked surface as one triangulation to walk on: all of the sheet, also beyond the chart.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "worker/flattening/flattening.hpp"
#include "worker/forming/sheet_map.hpp"
#include "worker/surface/path_mesh.hpp"

namespace vacuform {

// Keeps references to both: they must outlive it. Made in one pass over the triangles.
class InkedSurface {
 public:
  InkedSurface(const FormedSheet& sheet, const Flattening& flattening);

  const std::vector<Triangle>& triangles() const { return sheet_->triangles; }
  const std::vector<Eigen::Vector3d>& inked() const { return flattening_->inked; }
  const std::vector<Eigen::Vector2d>& rest() const { return sheet_->rest; }
  // Neighbour of triangle t across the edge opposite its corner k; -1 on the sheet's border.
  int across(int t, int k) const {
    const int beyond = path_mesh_.side(3 * t + k).beyond;
    return beyond < 0 ? -1 : beyond / 3;
  }
  // Outward unit normal of a triangle; zero where it has no area.
  const Eigen::Vector3d& normal(int t) const { return faces_[index(t)].normal; }
  // Change of the barycentric weight k per millimetre, a vector in the triangle's plane; zero without area.
  const Eigen::Vector3d& gradient(int t, int k) const { return faces_[index(t)].gradient[index(k)]; }
  const PathMesh& path_mesh() const { return path_mesh_; }
  bool on_chart(int t) const { return on_chart_[index(t)] != 0; }

  Eigen::Vector3d place(const SheetPoint& p) const;  // on the inked surface, mm
  Eigen::Vector2d rest(const SheetPoint& p) const;   // sheet coordinates, mm
  Eigen::Vector2d chart(const SheetPoint& p) const;  // chart coordinates, mm; NaN off the chart

  // The point with the given chart coordinates, or, off the chart, the nearest one of the chart's border; of charts that
  // overlap themselves the first triangle. Linear in the chart's triangles.
  struct OnChart {
    SheetPoint point{};
    double off_mm = 0;  // distance from the chart, chart millimetres; 0 on it
  };
  OnChart at_chart(const Eigen::Vector2d& chart) const;
  // The point of the chart's triangles nearest to a place in space, and how far away it is, mm.
  struct Nearest {
    SheetPoint point{};
    double distance_mm = 0;
  };
  Nearest nearest_on_chart(const Eigen::Vector3d& place) const;

  // The direction in the plane of the chart's triangle t that is the chart's u axis, by the rotation nearest to the
  // flattening's map there. Off the chart the sheet's s axis stands in for u.
  Eigen::Vector3d chart_axis(int t) const;

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  struct Face {
    Eigen::Vector3d normal;
    std::array<Eigen::Vector3d, 3> gradient;
  };
  const FormedSheet* sheet_;
  const Flattening* flattening_;
  std::vector<Face> faces_;
  std::vector<char> on_chart_;
  PathMesh path_mesh_;
};

}  // namespace vacuform
