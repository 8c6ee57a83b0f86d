#include "worker/forming/inked_face.hpp"

#include <Eigen/Geometry>

namespace vacuform {

std::vector<Eigen::Vector3d> inked_positions(const FormedSheet& sheet, InkedFace face) {
  std::vector<Eigen::Vector3d> inked = sheet.formed;
  if (face == InkedFace::inner) return inked;
  std::vector<Eigen::Vector3d> normal(inked.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : sheet.triangles) {
    const Eigen::Vector3d n =
        (sheet.formed[t[1]] - sheet.formed[t[0]]).cross(sheet.formed[t[2]] - sheet.formed[t[0]]);
    for (int v : t) normal[v] += n;
  }
  for (std::size_t i = 0; i < inked.size(); ++i)
    if (const double length = normal[i].norm(); length > 0)
      inked[i] += sheet.thickness[i] / length * normal[i];
  return inked;
}

InkedSurface inked_surface(const FormedSheet& sheet, InkedFace face) {
  return {sheet.triangles, inked_positions(sheet, face), sheet.rest};
}

}  // namespace vacuform
