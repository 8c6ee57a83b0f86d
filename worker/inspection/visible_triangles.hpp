// Which triangle of a mesh each sample of a picture sees. Internal to worker/inspection.
//
// Scan conversion with a depth buffer, in homogeneous coordinates and in doubles: M. Olano and T. Greer, "Triangle scan
// conversion using 2D homogeneous coordinates", 1997. Triangles that share an edge leave no gap, and a triangle may
// reach behind the eye.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// A pinhole camera. The samples lie at the middles of the quarters of the pixels.
struct Camera {
  Eigen::Vector3d eye{0, 0, 0};
  Eigen::Vector3d right{1, 0, 0}, up{0, 1, 0}, back{0, 0, 1};  // unit, at right angles
  double pixel = 1;                                            // its size at distance 1
  double middle_x = 0, middle_y = 0;                           // where it looks, in pixels from the top left

  // The direction through a place in the picture, in pixels from the top left; so long that it leads 1 away from the
  // eye's plane.
  Eigen::Vector3d aim(double x, double y) const {
    return (x - middle_x) * pixel * right + (middle_y - y) * pixel * up - back;
  }
};

class VisibleTriangles {
 public:
  // Keeps a reference to the mesh. One pass over its vertices and triangles.
  VisibleTriangles(const TriangleMesh& mesh, const Camera& camera, int width);

  // The nearest triangle along the camera's aim. Of equally near ones the first.
  struct Sample {
    double nearness = 0;  // 1 / (length of the way to it, in lengths of aim)
    float u = 0, v = 0;   // barycentric: (1 - u - v) a + u b + v c
    int triangle = -1;    // -1: none
  };
  // The samples of the pixels' rows [top, bottom): 2 * (bottom - top) rows of 2 * width. May be called by several
  // threads at once.
  void see(int top, int bottom, std::vector<Sample>& samples) const;

 private:
  struct Rows {
    int first, last;  // of samples, counted from the picture's top
  };
  const TriangleMesh& mesh_;
  Camera camera_;
  int columns_;                           // of samples
  std::vector<Eigen::Vector3d> corners_;  // the vertices, from the eye
  std::vector<Eigen::Vector3d> seen_;     // the same: column and row in samples, and depth
  std::vector<Rows> rows_;                // that a triangle may cover
};

}  // namespace vacuform
