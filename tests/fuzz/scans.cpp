// Scans of every format, read and made into a mold. Forming is no part of it: a mold that is made is a mold like any.
#include <cmath>

#include "tests/fuzz/targets.hpp"
#include "worker/scan/mold.hpp"

namespace vacuform::fuzz {
namespace {

void check(const Mold& mold) {
  require(!mold.mesh.triangles.empty(), "a mold has triangles");
  for (const Eigen::Vector3d& p : mold.mesh.vertices)
    require(p.allFinite() && p.z() >= 0, "a mold is finite and on the platform");
  for (const Triangle& t : mold.mesh.triangles)
    for (const int corner : t)
      require(corner >= 0 && static_cast<std::size_t>(corner) < mold.mesh.vertices.size(),
              "indices are valid");
}

// The scan's own unit is mostly refused, so it is scaled. The length of the file chooses what else is asked, so that
// skins and given trims are reached too.
void read(Bytes bytes, const char* file_name) {
  ScanSettings settings;
  if (bytes.size() % 8 != 0) settings.size_mm = 150;
  if (bytes.size() % 8 == 1) settings.clearance_mm = 3;
  if (bytes.size() % 8 >= 2) settings.trim_mm = 20;
  const auto mold = make_mold(bytes, file_name, settings, Context());
  if (mold)
    check(*mold);
  else
    require(mold.error().code != Code::internal, "a bad scan is no fault of Vacuform's");
}

}  // namespace

void read_stl(Bytes bytes) { read(bytes, "fuzz.stl"); }
void read_obj(Bytes bytes) { read(bytes, "fuzz.obj"); }
void read_ply(Bytes bytes) { read(bytes, "fuzz.ply"); }
void read_off(Bytes bytes) { read(bytes, "fuzz.off"); }
void read_glb(Bytes bytes) { read(bytes, "fuzz.glb"); }

}  // namespace vacuform::fuzz
