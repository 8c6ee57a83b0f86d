// The outer skin: which of a scan's connected pieces the sheet will meet, turned so that their normals point
// outwards.
#pragma once

#include <optional>

#include "api/settings.hpp"
#include "worker/scan/scan_progress.hpp"
#include "worker/stage/warning.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

struct OuterSkin {
  TriangleMesh mesh;
  int components = 0;          // in the mesh given
  int components_dropped = 0;  // loose debris (below 5 % of the skin's size), enclosed pieces, other bodies
  bool turned_inside_out = false;
  bool soup = false;  // the pieces are scraps of a surface; none was dropped, and they must be wrapped
  // "several-bodies": further large bodies that are no heads were kept; proposes to take one.
  std::optional<Warning> warning = {};
};

// Takes a welded mesh. The main piece is the one with the largest diagonal. A piece is enclosed if nearly every ray
// from nearly every of its points hits the main piece. A small closed body that lies partly in the main piece is kept:
// models are often made of bodies that cross. Neighbours over an edge that exactly two triangles share get the same
// orientation; then each such patch is turned outwards by the sign of its volume (an open patch counts as closed
// towards the middle of its border).
//
// `choice` says which of the bodies (bodies.hpp) is taken: the main piece is then that body, and pieces nearer to another
// body are dropped. BodyChoice::all keeps all of them. BodyChoice::automatic keeps what is there unless two or more can
// be heads.
//
// O(n log n). Errors: cancelled; too_large (more pieces than job_limits allow); unusable_scan with proposals of scan.body
// (several heads, or no body of that number).
Result<OuterSkin> outer_skin(const TriangleMesh& mesh, BodyChoice choice, const ScanProgress& progress);

}  // namespace vacuform
