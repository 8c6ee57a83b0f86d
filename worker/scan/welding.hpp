// Welding: vertices at the same place become one, and triangles that this leaves without area are dropped.
#pragma once

#include "worker/scan/topology.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// The box that holds the middle 96 % of the vertices along each axis; of a mesh without any: zeros.
Box middle_box(const TriangleMesh& mesh);

// The diagonal of the box that holds the middle 96 % of the vertices along each axis: the size of the scan without
// stray points.
double robust_size(const TriangleMesh& mesh);

// Joins every vertex to the first one within `tolerance` of it (in each coordinate), in the order of the file. With a
// tolerance of at most 1e-17 of the largest coordinate, joins only equal ones. Drops triangles that name a vertex
// twice, all but the first of triangles with the same three corners (in either direction), and unused vertices.
void weld(TriangleMesh& mesh, double tolerance);

}  // namespace vacuform
