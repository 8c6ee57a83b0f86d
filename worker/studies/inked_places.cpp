#include "worker/studies/inked_places.hpp"

#include <Eigen/LU>
#include <limits>

#include "worker/forming/inked_face.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

namespace {

using Gradient = Eigen::Matrix<double, 3, 2>;

// The derivatives of the places by sheet coordinates at each vertex: the mean over the triangles around it, weighted by
// their area.
std::vector<Gradient> gradients(const FormedSheet& sheet, const std::vector<Eigen::Vector3d>& places) {
  std::vector<Gradient> out(places.size(), Gradient::Zero());
  std::vector<double> area(places.size(), 0);
  for (const Triangle& t : sheet.triangles) {
    Eigen::Matrix2d flat;
    flat << sheet.rest[t[1]] - sheet.rest[t[0]], sheet.rest[t[2]] - sheet.rest[t[0]];
    const double twice = flat.determinant();
    if (!(twice > 0)) continue;
    Gradient edges;
    edges << places[t[1]] - places[t[0]], places[t[2]] - places[t[0]];
    const Gradient of = twice * edges * flat.inverse();
    for (const int v : t) out[v] += of, area[v] += twice;
  }
  for (std::size_t v = 0; v < out.size(); ++v)
    if (area[v] > 0) out[v] /= area[v];
  return out;
}

}  // namespace

Eigen::VectorXd inked_places(const FormedSheet& sheet, InkedFace face,
                             const std::vector<Eigen::Vector2d>& rest) {
  const std::vector<Eigen::Vector3d> places = inked_positions(sheet, face);
  const std::vector<Gradient> gradient = gradients(sheet, places);
  const PlaneLocator locator(sheet.triangles, sheet.rest);
  Eigen::VectorXd out = Eigen::VectorXd::Constant(3 * static_cast<Eigen::Index>(rest.size()),
                                                  std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const auto at = locator.find(rest[i]);
    if (!at) continue;
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const int v = sheet.triangles[at->triangle][k];
      place += at->weights[k] * (places[v] + 0.5 * gradient[v] * (rest[i] - sheet.rest[v]));
    }
    out.segment<3>(3 * static_cast<Eigen::Index>(i)) = place;
  }
  return out;
}

}  // namespace vacuform
