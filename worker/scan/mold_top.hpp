// The top of a mold: where the drawing is centred.
#pragma once

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// The centroid of the section of a closed mesh a little below its highest vertex (2e-4 of its diagonal: 0.05 mm on an
// adult head), at the height of that vertex. So the top of a peak is its vertex, that of a ridge its middle, and that of
// a flat face its centroid, within 0.01 mm, for every triangulation and however the mesh is turned about z. The section
// of a head is about 6 mm across: triangles, noise and tilt move its centroid less than the highest vertex. If the
// section has several pieces, the largest counts; of equally large ones (within a thousandth) the nearest to x = y = 0.
// Scales with the mesh. The mesh has at least one vertex. Linear in the triangles.
Eigen::Vector3d top_of(const TriangleMesh& mesh);

}  // namespace vacuform
