// What lies on one face of the flat sheet, where tails are to pass: traces, the parts of loops that no tail may cross, other ink,
// tails that are laid, and the region beside the head.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/conductors/gap_layout.hpp"
#include "worker/conductors/islands.hpp"
#include "worker/conductors/sheet_cells.hpp"
#include "worker/placement/charted_surface.hpp"

namespace vacuform {

class TailGround {
 public:
  // Keeps references. `reach_mm`: how far from the edges of things their distance matters, mm on the part.
  TailGround(const ChartedSurface& charted, const Eigen::AlignedBox2d& box, double reach_mm);

  const SheetCells& cells() const { return cells_; }
  const InkedSurface& surface() const { return charted_.surface(); }

  // A part of a trace, so wide on the part. A `crossable` one may be crossed by the tails of other loops.
  // `beneath`: on the other face.
  enum class Kind { crossable, closed, beneath };
  void add_trace(int loop, Kind kind, const Trace& trace, const Interval& along, double width_mm);
  // The gap of a loop's own port does not bar its own tail.
  void add_port(int loop, const Trace& trace, const Interval& along, double width_mm);
  // Ink on the flat sheet. That of a loop does not bar the beginning of its own tail; -1: of none.
  void add_ink(int loop, const Islands& ink);
  // A line on the flat sheet.
  void add_line(const std::vector<Eigen::Vector2d>& line, double width_mm, Kind kind);
  void remove_lines();  // all that add_line() added

  struct Rooms {
    Room closed, own, crossable,
        beneath;  // beside what nothing crosses, the loop's own ink, the traces of other loops, and tails on the other face
  };
  Rooms rooms_for(int loop) const;

  // By cells beside the chart, mm on the part from it: 0 on the chart, infinite beyond 40 mm.
  const Room& off_chart() const { return off_chart_; }
  // Away from the chart, a unit vector on the flat sheet; zero where none is found.
  Eigen::Vector2d outwards(int cell) const;

 private:
  struct Thing {
    int loop;
    Kind kind;
    bool port = false, ink = false, line = false;
    std::vector<std::pair<int, float>> room;  // by the cells that it is near
  };
  Thing& add(int loop, Kind kind, const std::vector<Eigen::Vector2d>& points, double width_mm);
  void find_off_chart();

  const ChartedSurface& charted_;
  const SheetCells cells_;
  const double reach_mm_;
  Room off_chart_;
  Room scratch_;
  std::vector<Thing> things_;
};

}  // namespace vacuform
