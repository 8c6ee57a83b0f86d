#include <algorithm>
#include <utility>

#include "worker/inspection/findings_preview.hpp"
#include "worker/inspection/formed_glb.hpp"
#include "worker/inspection/inspection.hpp"
#include "worker/inspection/mesh_files.hpp"
#include "worker/inspection/mold_marks.hpp"
#include "worker/inspection/picture_png.hpp"
#include "worker/inspection/previews.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/surface/stl.hpp"

namespace vacuform {

bool makes(const Finished& job, const ArtifactKind& kind) {
  if (kind.name == "preview-segments.png") return in_segments(job);
  if (kind.name == "preview-temperature.png") return job.heat.source != HeatSource::uniform;
  if (kind.name.starts_with("colours.")) return job.print.colours.has_value();
  for (const char* name :
       {"preview-original.png", "preview-position.png", "preview-colour.png", "preview-align.png"})
    if (kind.name == name) return job.figures.errors.has_value();
  return kind.always;
}

Result<std::vector<Artifact>> artifacts(const Finished& job, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::inspection, 0));
  std::vector<Artifact> files;
  files.push_back({"print.png", job.print.png});
  files.push_back({"print.svg", {job.print.svg.begin(), job.print.svg.end()}});
  files.push_back({"print.pdf", job.print.pdf});
  if (const auto& colours = job.print.colours) {
    files.push_back({"colours.png", colours->png});
    files.push_back({"colours.svg", {colours->svg.begin(), colours->svg.end()}});
    files.push_back({"colours.pdf", colours->pdf});
  }
  const SheetPicture print(job);
  Result<std::vector<Artifact>> pictures;
  Result<std::vector<std::uint8_t>> glb;
  std::vector<std::uint8_t> ply, obj, uv_map, stl;
  // The previews take longest, and report the progress.
  together([&] { pictures = previews(job, print, context); },
           [&] { glb = formed_glb(job, print, context.silent()); }, [&] { ply = formed_ply(job); },
           [&] { obj = formed_obj(job); }, [&] { uv_map = uv_map_obj(job); },
           [&] { stl = stl_bytes(marked_mold(job.mold.mesh)); });
  if (!pictures) return tl::make_unexpected(pictures.error());
  if (!glb) return tl::make_unexpected(glb.error());
  for (auto& picture : *pictures) files.push_back(std::move(picture));
  files.push_back({"formed.ply", std::move(ply)});
  files.push_back({"formed.obj", std::move(obj)});
  files.push_back({"formed.mtl", formed_mtl()});
  files.push_back({"formed.glb", *std::move(glb)});
  files.push_back({"uv-map.obj", std::move(uv_map)});
  files.push_back({"mold.stl", std::move(stl)});
  VACUFORM_CHECK(context.step(Stage::inspection, 1));
  return files;
}

Result<std::vector<Artifact>> inspection_artifacts(const Mold& mold, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::inspection, 0));
  VACUFORM_TRY(picture, findings_preview(mold, context));
  std::vector<Artifact> files;
  files.push_back({"preview-findings.png", png_of(picture)});
  files.push_back({"mold.stl", stl_bytes(marked_mold(mold.mesh))});
  VACUFORM_CHECK(context.step(Stage::inspection, 1));
  return files;
}

}  // namespace vacuform
