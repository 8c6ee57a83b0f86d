// Lines that join elements: the patch of an element places each end, and all of the line moves with its ends. Internal
// to worker/printing.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "worker/pattern/curve.hpp"
#include "worker/printing/patch_map.hpp"

namespace vacuform {

// Distance of a point from an area; 0 inside.
double distance(const Eigen::Vector2d& p, const Area& area);

// Keeps references to the maps.
class TiedLine {
 public:
  // `start` and `end` are the maps of the elements that the ends of `line` touch; null for a free end.
  TiedLine(std::vector<CurvePoint> line, double width_mm, const PatchMap& chart, const PatchMap* start,
           const PatchMap* end);

  // For a point on the line or beside it. Nothing off the chart.
  std::optional<Eigen::Vector2d> rest_at(const Eigen::Vector2d& uv) const;

 private:
  struct Tie {
    const PatchMap* map = nullptr;
    double reach = 0;              // along the line, mm: the patch ends there
    Eigen::Vector2d beyond{0, 0};  // by how much the patch moves the line from the chart there and beyond
  };
  struct Nearest {
    double square = 0, along = 0;
  };
  double along(const Eigen::Vector2d& uv) const;  // of the nearest point of the line
  // Pieces [first, last) below `node` of the tree of boxes.
  void build(std::size_t node, std::size_t first, std::size_t last);
  void look(std::size_t node, std::size_t first, std::size_t last, const Eigen::Vector2d& uv,
            Nearest& best) const;
  double bound(const Eigen::Vector2d& uv) const;
  Tie tie(const PatchMap* map, bool from_end) const;
  // By how much the tie moves a point that lies `x` along the line from it and that the chart places at `by_chart`.
  Eigen::Vector2d moved(const Tie& tie, double x, const Eigen::Vector2d& uv,
                        const Eigen::Vector2d& by_chart) const;

  const std::vector<CurvePoint> line_;
  std::vector<Eigen::AlignedBox2d>
      boxes_;            // around halves of the line, halves of these...: 2 n + 1, 2 n + 2 below n
  const double beside_;  // how far ink lies beside the line
  const PatchMap& chart_;
  std::array<Tie, 2> ties_;
};

}  // namespace vacuform
