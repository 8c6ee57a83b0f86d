// Where any point of the flat sheet lies on the formed one.
#pragma once

#include <optional>

#include "worker/forming/formed_sheet.hpp"
#include "worker/surface/plane_locator.hpp"

namespace vacuform {

// The formed place of points of the sheet, by linear interpolation in its triangles. Keeps a reference to the sheet.
class SheetMap {
 public:
  explicit SheetMap(const FormedSheet& sheet) : sheet_(sheet), locator_(sheet.triangles, sheet.rest) {}

  // Nothing off the sheet.
  std::optional<Eigen::Vector3d> operator()(const Eigen::Vector2d& rest) const {
    const auto at = locator_.find(rest);
    if (!at) return std::nullopt;
    return interpolate(sheet_.triangles, *at, sheet_.formed);
  }

 private:
  const FormedSheet& sheet_;
  PlaneLocator locator_;
};

}  // namespace vacuform
