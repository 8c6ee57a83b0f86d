#include "worker/coils/element_patch.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/coils/bumpy_patch.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

Result<ElementPatch> element_patch(const InkedSurface& surface, const SurfacePoint& centre,
                                   const Vector3d& axis, double ink_mm, const Context& context) {
  constexpr double margin_mm = 3, widest_step_mm = 1.8;
  // A geodesic radius is larger than the flat one on a dome: by 2 % at 80 mm on a small head.
  const double reach = 1.08 * ink_mm + margin_mm;
  const int directions =
      std::clamp(4 * static_cast<int>(std::ceil(M_PI / 2 * reach / widest_step_mm)), 96, 240);
  const PolarGrid grid(surface, centre, axis, reach, directions);
  if (!grid.folded(ink_mm)) return grid.patch();
  return bumpy_patch(surface, centre, axis, ink_mm, context);
}

PatchMap::PatchMap(const ElementPatch& patch) : patch_(&patch), cell_(2) {
  Eigen::AlignedBox2d box;
  for (const Vector2d& p : patch.patch.uv) box.extend(p);
  if (box.isEmpty()) return;
  corner_ = box.min();
  columns_ = static_cast<int>(box.sizes().x() / cell_) + 1;
  rows_ = static_cast<int>(box.sizes().y() / cell_) + 1;
  cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (std::size_t t = 0; t < patch.patch.triangles.size(); ++t) {
    Eigen::AlignedBox2d of;
    for (const int v : patch.patch.triangles[t]) of.extend(patch.patch.uv[static_cast<std::size_t>(v)]);
    const Vector2d low = (of.min() - corner_) / cell_, high = (of.max() - corner_) / cell_;
    for (int y = static_cast<int>(low.y()); y <= std::min(rows_ - 1, static_cast<int>(high.y())); ++y)
      for (int x = static_cast<int>(low.x()); x <= std::min(columns_ - 1, static_cast<int>(high.x())); ++x)
        cells_[static_cast<std::size_t>(y * columns_ + x)].push_back(static_cast<int>(t));
  }
}

std::optional<PatchMap::Found> PatchMap::find(const Vector2d& flat) const {
  const Vector2d at = (flat - corner_) / cell_;
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() < columns_ && at.y() < rows_)) return {};
  double best = -1e-9;
  std::optional<Found> out;
  const auto& uv = patch_->patch.uv;
  for (const int t :
       cells_[static_cast<std::size_t>(static_cast<int>(at.y()) * columns_ + static_cast<int>(at.x()))]) {
    const Triangle& c = patch_->patch.triangles[static_cast<std::size_t>(t)];
    const Vector2d &a = uv[static_cast<std::size_t>(c[0])], &b = uv[static_cast<std::size_t>(c[1])],
                   &d = uv[static_cast<std::size_t>(c[2])];
    const Vector3d w =
        Vector3d(cross(b - flat, d - flat), cross(d - flat, a - flat), cross(a - flat, b - flat)) /
        cross(b - a, d - a);
    if (!w.allFinite() || w.minCoeff() <= best) continue;
    best = w.minCoeff();
    out = Found{static_cast<std::size_t>(t), w};
  }
  return out;
}

std::optional<Vector3d> PatchMap::place(const Vector2d& flat) const {
  const auto found = find(flat);
  if (!found) return {};
  const Triangle& c = patch_->patch.triangles[found->triangle];
  Vector3d out = Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    out += found->weights[k] * patch_->patch.inked[static_cast<std::size_t>(c[static_cast<std::size_t>(k)])];
  return out;
}

bool PatchMap::on_chart(const Vector2d& flat) const {
  const auto found = find(flat);
  return found && patch_->on_chart[found->triangle] != 0;
}

}  // namespace vacuform
