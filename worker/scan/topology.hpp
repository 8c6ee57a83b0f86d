// What triangles share: edges, borders, pieces; and the measures of a closed surface. Everything is sorted,
// never hashed, so that results do not depend on the machine. O(n log n) in the triangles.
#pragma once

#include <vector>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// One triangle's use of an edge. `forward`: the triangle runs from low to high.
struct EdgeUse {
  int low, high;
  int triangle;
  bool forward;
};
// All 3 n uses, sorted by (low, high, triangle): the uses of one edge follow each other.
std::vector<EdgeUse> edge_uses(const TriangleMesh& mesh);

// Every edge is shared by exactly two triangles that run along it in opposite directions, no triangle names a
// vertex twice, and there is at least one triangle.
bool is_watertight(const TriangleMesh& mesh);

// The borders of the openings as simple loops of vertices, in the direction in which the missing faces would
// run along them (so that [a, b, c] is the triangle that closes a loop of three). Only edges used exactly
// once count.
std::vector<std::vector<int>> border_loops(const TriangleMesh& mesh);

// The piece of each triangle, numbered from 0 in order of first appearance; pieces share no vertex. Returns
// their number.
int connected_pieces(const TriangleMesh& mesh, std::vector<int>& piece_of_triangle);

// Removes vertices that no triangle names; keeps the order of the others.
void drop_unused_vertices(TriangleMesh& mesh);

// The triangles of the pieces to keep (one entry a piece), with their vertices.
TriangleMesh take_pieces(const TriangleMesh& mesh, const std::vector<int>& piece_of_triangle,
                         const std::vector<char>& keep);

struct Box {
  Eigen::Vector3d low, high;
  Eigen::Vector3d size() const { return high - low; }
  Eigen::Vector3d centre() const { return (low + high) / 2; }
};
Box bounds(const TriangleMesh& mesh);  // of the vertices; of a mesh without any: zeros

double signed_volume(const TriangleMesh& mesh);  // positive: oriented outwards; mesh closed

}  // namespace vacuform
