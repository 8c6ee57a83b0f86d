// formed.glb: the formed sheet as glTF 2.0 binary. Internal to worker/inspection.
#pragma once

#include "worker/inspection/inspection.hpp"
#include "worker/inspection/sheet_picture.hpp"

namespace vacuform {

// One mesh under a node that takes millimetres with z up (formed.ply) to metres with y up (glTF). Vertices and
// triangles are those of formed.ply. Beside POSITION, NORMAL and TEXCOORD_0 a vertex has, as floats,
//   _SHEET (s, t; mm), _PATTERN (u, v; mm; 0 off the chart), _CONTACT (as Contact), _CHART (1 on the chart, otherwise 0)
//   and the values of the heat maps (heat_maps.hpp), -1 where there is no value: glTF has no NaN.
// Two materials, by KHR_materials_variants: "pre-distorted", which is the default, and "printed as drawn"; their
// textures are those of sheet_textures.hpp, inside the file. `print`: of the job. Deterministic. Errors: cancelled.
Result<std::vector<std::uint8_t>> formed_glb(const Finished& job, const SheetPicture& print,
                                             const Context& context);

}  // namespace vacuform
