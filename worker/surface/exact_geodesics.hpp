// Exact shortest paths over the triangles of a surface, by windows that are unfolded from the source outwards: J. Chen
// and Y. Han, "Shortest paths on a polyhedron", 1990. Windows are handled in the order of their distances and filtered
// as in S.-Q. Xin and G.-J. Wang, "Improving Chen and Han's algorithm on the discrete geodesic problem", 2009.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "worker/surface/path_mesh.hpp"
#include "worker/surface/sheet_point.hpp"

namespace vacuform {

// A point of an edge: a + f (b - a), f in [0, 1]; a vertex where a = b.
struct PathPoint {
  int a, b;
  double f;
};

// The paths from one source at a time. One thread each; the mesh, which must outlive it, may serve several. Some
// milliseconds for a source and 5,000 triangles within reach. Deterministic.
class Geodesics {
 public:
  explicit Geodesics(const PathMesh& mesh);
  ~Geodesics();

  // Where the next paths begin, and how long they are at most.
  void begin_at(const SheetPoint& source, double reach_mm);
  // The same if to() is asked for `target` only. Skips what is too far from both for a path of that length, which takes
  // a fraction of the time.
  void begin_at(const SheetPoint& source, const SheetPoint& target, double reach_mm);

  struct Path {
    double length;          // mm, exact but for rounding
    Eigen::Vector3d start;  // unit vector in which it leaves the source; 0 where it has no length
  };
  // Nothing if the target is farther than the reach.
  std::optional<Path> to(const SheetPoint& target) const;
  // The points where the path to a vertex meets edges and vertices, from the first one after the source to the vertex
  // itself. For a source on a vertex this includes edges that start there. Nothing if to() gives nothing.
  std::vector<PathPoint> trace(int vertex) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vacuform
