#include <algorithm>
#include <utility>

#include "worker/inspection/array_files.hpp"
#include "worker/inspection/array_wires.hpp"
#include "worker/inspection/conductors_stl.hpp"
#include "worker/inspection/findings_preview.hpp"
#include "worker/inspection/formed_glb.hpp"
#include "worker/inspection/inspection.hpp"
#include "worker/inspection/layers_dxf.hpp"
#include "worker/inspection/mesh_files.hpp"
#include "worker/inspection/mold_marks.hpp"
#include "worker/inspection/picture_png.hpp"
#include "worker/inspection/previews.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/surface/stl.hpp"

namespace vacuform {

bool in_black(const Print& print) {
  return std::all_of(print.layers.begin(), print.layers.end(),
                     [](const Layer& layer) { return layer.source->black() && !layer.step; });
}

bool makes(const Finished& job, const ArtifactKind& kind) {
  if (kind.name == "preview-segments.png") return in_segments(job);
  if (kind.name == "preview-lengths.png") return !job.lengths.pieces.empty();
  if (kind.name == "preview-temperature.png") return job.heat.source != HeatSource::uniform;
  for (const Layer& layer : job.print.layers)
    if (kind.name.starts_with(layer.name + ".")) return true;
  if (kind.name == "layers.dxf") return job.build != nullptr;
  for (const char* name : {"array.json", "array.nec", "array.ts"})
    if (kind.name == name) return job.figures.electrical.has_value();
  for (const char* name : {"coils.csv", "array-marie.msh", "array-marie.json", "array.stl"})
    if (kind.name == name) return job.figures.electrical && !job.build->gaps.empty();
  for (const char* name :
       {"preview-original.png", "preview-position.png", "preview-colour.png", "preview-align.png"})
    if (kind.name == name) return job.figures.errors.has_value();
  return kind.always;
}

Result<std::vector<Artifact>> artifacts(const Finished& job, const Context& context) {
  VACUFORM_CHECK(context.step(Stage::inspection, 0));
  std::vector<Artifact> files;
  for (const Layer& layer : job.print.layers) {
    files.push_back({layer.name + ".png", layer.files.png});
    files.push_back({layer.name + ".svg", {layer.files.svg.begin(), layer.files.svg.end()}});
    files.push_back({layer.name + ".pdf", layer.files.pdf});
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
  const auto add = [&](const char* name, std::string (*make)(const Finished&)) {
    if (!makes(job, *artifact_kind(name))) return;
    const std::string text = make(job);
    files.push_back({name, {text.begin(), text.end()}});
  };
  add("layers.dxf", layers_dxf);
  add("coils.csv", coils_csv);
  add("array.json", array_json);
  add("array.nec", array_nec);
  add("array.ts", array_touchstone);
  add("array-marie.msh", marie_mesh);
  add("array-marie.json", marie_circuit);
  add("array.stl", conductors_stl);
  // In the order of the table, whatever the order of the layers.
  std::sort(files.begin(), files.end(), [](const Artifact& a, const Artifact& b) {
    return artifact_kind(a.name) < artifact_kind(b.name);
  });
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
