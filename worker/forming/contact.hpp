// What the descending sheet meets: the mold and the platform, found along the way from one place to the next.
#pragma once

#include <optional>

#include "worker/forming/formed_sheet.hpp"
#include "worker/scan/ray_caster.hpp"

namespace vacuform {

class Obstacles {
 public:
  struct Touch {
    double t;               // along the way, in [0, 1]
    Eigen::Vector3d place;  // exactly on the mold's triangle or on the platform
    Contact with;
  };

  explicit Obstacles(const TriangleMesh& mold) : mold_(mold), rays_(mold) {}

  // The first place at which a point that moves straight from `from` to `to` enters the mold or passes the platform.
  std::optional<Touch> first_touch(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;

 private:
  const TriangleMesh& mold_;
  RayCaster rays_;
};

}  // namespace vacuform
