// Scans of every format, read and made into a mold. Forming is no part of it: a mold that is made is a mold like any.
#include <cmath>
#include <cstdint>
#include <vector>

#include "api/redaction/redaction.hpp"
#include "tests/fuzz/targets.hpp"
#include "worker/scan/mold.hpp"
#include "worker/scan/scan_file.hpp"

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

void check_colours(const Result<ScanFile>& scan) {
  if (!scan) return require(scan.error().code != Code::internal, "a bad scan is no fault of Vacuform's");
  if (!scan->colours) return;
  const ScanColours& colours = *scan->colours;
  const std::size_t triangles = scan->mesh.triangles.size();
  require(colours.material.size() == triangles, "every triangle has a material");
  require(colours.uv.empty() || colours.uv.size() == triangles, "every triangle has its place in the image");
  require(colours.vertex.empty() || colours.vertex.size() == scan->mesh.vertices.size(),
          "every vertex has its colour");
  for (const int m : colours.material)
    require(m >= 0 && static_cast<std::size_t>(m) < colours.materials.size(), "materials are valid");
  for (const ScanMaterial& material : colours.materials)
    require(material.image < static_cast<int>(colours.images.size()) &&
                (material.image < 0 || !colours.uv.empty()),
            "images are valid and lie on triangles");
  for (const auto& corners : colours.uv)
    for (const auto& uv : corners) require(uv.allFinite(), "texture coordinates are finite");
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
  const Context context;
  check_colours(read_scan(bytes, file_name, ScanProgress(context), ScanParts::with_colours));
}

}  // namespace

void read_stl(Bytes bytes) { read(bytes, "fuzz.stl"); }
void read_obj(Bytes bytes) { read(bytes, "fuzz.obj"); }
void read_ply(Bytes bytes) { read(bytes, "fuzz.ply"); }
void read_off(Bytes bytes) { read(bytes, "fuzz.off"); }
void read_glb(Bytes bytes) { read(bytes, "fuzz.glb"); }

// As the reader meets it without the service before it, and then as the service stores it.
void read_zip(Bytes bytes) {
  read(bytes, "fuzz.zip");
  std::vector<std::uint8_t> stored(bytes.begin(), bytes.end());
  if (!vacuform::redact(stored, "fuzz.zip")) return;
  std::vector<std::uint8_t> again = stored;
  require(vacuform::redact(again, "fuzz.zip").has_value() && again == stored,
          "an archive that is written again stays as it is");
  read(stored, "fuzz.zip");
}

}  // namespace vacuform::fuzz
