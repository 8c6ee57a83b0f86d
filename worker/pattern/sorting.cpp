#include "worker/pattern/sorting.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "worker/numerics/disjoint_sets.hpp"
#include "worker/pattern/area.hpp"
#include "worker/pattern/clipping.hpp"
#include "worker/pattern/coil_grid.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/pattern/drawn_loop.hpp"
#include "worker/pattern/pieces.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;
using Polyline = std::vector<Vector2d>;

constexpr double small_mm = 4,
                 small_share = 0.25;  // radius of a loop that may be a mark; of that of its coil
constexpr double within = 0.9;        // of a piece, for it to lie in a coil
constexpr double most_reach = 1.5, more_reach_mm = 5;   // that a mark reaches, against its coil
constexpr double group_reach = 3, group_reach_mm = 20;  // that a mark in a group of its own coil reaches
constexpr double widest_figure_mm = 150, widest_group_mm = 40;
constexpr double least_gap_mm = 2, letter_mm = 12;  // between the letters of a word; the largest letter
constexpr std::size_t most_coils = 1024, most_sorted = 256;
constexpr std::size_t most_split = 2000;  // curves of a fill that are compared with each other
constexpr double fine_mm = 0.002;

double radius_of(double area_mm2) { return std::sqrt(area_mm2 / M_PI); }

AlignedBox2d box_of_line(const Polyline& line) {
  AlignedBox2d box;
  for (const Vector2d& p : line) box.extend(p);
  return box;
}

// Points along the outlines and lines of a piece, at most about a millimetre apart.
Polyline points_on(const Shape& shape) {
  Polyline out;
  for (const Curve& curve : shape.curves)
    for (const CurvePoint& p : flatten(curve, {.tolerance_mm = 0.05, .turn = 0.5, .longest_mm = 1}))
      out.push_back(p.at);
  return out;
}

struct Loop {
  DrawnLoop loop;
  std::vector<int> pieces;
  Vector2d centre{0, 0};
  double reach_mm = 0;  // from the centre
};

class Sorting {
 public:
  Sorting(const std::vector<PaintedShape>& pieces, const std::vector<FileNode>& nodes)
      : pieces_(pieces), nodes_(nodes), of_piece_(pieces.size(), none) {
    for (const PaintedShape& p : pieces) points_.push_back(points_on(p.shape));
    for (const PaintedShape& p : pieces) boxes_.push_back(box_of_shape(p.shape));
    for (int i = 0; i < count(); ++i) {
      const Shape& s = shape(i);
      filled_.push_back(has_filled(s)), stroked_.push_back(has_stroked(s));
      if (!inked(i) && s.fill && s.fill->a == 1) whites_.push_back(i);
      layered_ |= s.layer && *s.layer != DrawnLayer();
    }
  }

  std::vector<SortedElement> sort() {
    find_loops();
    choose_coils();
    if (coils_.size() <= most_coils) {
      const auto coils_of = coils_of_nodes();
      for (int i = 0; i < count(); ++i)
        if (of_piece_[i] == none) of_piece_[i] = coil_of_mark(i, coils_of);
      find_figures(coils_of_nodes());
    } else {
      coils_.clear();
      std::fill(of_piece_.begin(), of_piece_.end(), none);
    }
    return named();
  }

 private:
  static constexpr int none = -1, many = -2;

  int count() const { return static_cast<int>(pieces_.size()); }
  const Shape& shape(int i) const { return pieces_[i].shape; }
  bool inked(int i) const { return filled_[i] || stroked_[i]; }
  bool is_layer(int node) const { return layered_ && nodes_[node].layer; }

  // Lines with two ends, and the pieces that they are of.
  struct OpenLines {
    std::vector<LoopLine> lines;
    std::vector<int> pieces;
    void add(LoopLine line, int piece) {
      lines.push_back(std::move(line));
      pieces.push_back(piece);
    }
  };

  // Of conductors. Those of different faces are no loop together.
  void find_loops() {
    std::map<DrawnFace, OpenLines> open;
    for (int i = 0; i < count(); ++i) {
      const Shape& s = shape(i);
      const DrawnLayer layer = s.layer.value_or(DrawnLayer());
      if (layer.step != PrintStep::conductor) continue;
      if (filled_[i]) {
        find_in_area(i, open[layer.face]);
      } else if (stroked_[i]) {
        for (const Curve& curve : s.curves) {
          LoopLine line = loop_line(curve, s.stroke->width_mm);
          if (!line.closed)
            open[layer.face].add(std::move(line), i);
          else if (auto loop = closed_loop(line))
            add_loop(std::move(*loop), {i});
        }
      }
    }
    for (const auto& [face, lines] : open) close_gaps(lines);
  }

  void close_gaps(const OpenLines& open) {
    for (GappedLoop& found : gapped_loops(open.lines)) {
      std::vector<int> of_loop;
      char filled = 0;
      for (const std::size_t line : found.lines) {
        of_loop.push_back(open.pieces[line]);
        filled |= filled_[open.pieces[line]];
      }
      std::sort(of_loop.begin(), of_loop.end());
      of_loop.erase(std::unique(of_loop.begin(), of_loop.end()), of_loop.end());
      found.loop.filled = filled != 0;
      add_loop(std::move(found.loop), std::move(of_loop));
    }
  }

  void find_in_area(int i, OpenLines& open) {
    const Shape& s = shape(i);
    Area area = fill_area(s.curves, s.even_odd, fine_mm);
    if (stroked_[i]) {
      const Area line = stroke_area(s.curves, *s.stroke, fine_mm);
      area.insert(area.end(), line.begin(), line.end());
      area = union_of(area);
    }
    if (auto ring = filled_ring(area)) return add_loop(std::move(*ring), {i});
    if (auto band = filled_band(area)) return open.add(std::move(*band), i);
    // A disc, and a white one on it.
    if (area.size() != 1) return;
    for (auto k = std::upper_bound(whites_.begin(), whites_.end(), i); k != whites_.end(); ++k) {
      if (++whites_tried_ > most_split * most_split) return;
      if (!boxes_[i].contains(boxes_[*k])) continue;
      const Shape& over = shape(*k);
      if (over.layer != s.layer) continue;
      const Area hole = fill_area(over.curves, over.even_odd, fine_mm);
      Area both = area;
      both.insert(both.end(), hole.begin(), hole.end());
      if (auto ring = filled_ring(covered_by(both, FillRule::even_odd)))
        return add_loop(std::move(*ring), {i, *k});
    }
  }

  void add_loop(DrawnLoop loop, std::vector<int> pieces) {
    Loop out{std::move(loop), std::move(pieces)};
    AlignedBox2d box;
    if (out.loop.filled) {
      box = box_of_line(out.loop.line);
    } else {
      for (const int i : out.pieces) box.extend(boxes_[i]);
    }
    out.centre = box.center();
    for (const Vector2d& p : out.loop.line)
      out.reach_mm = std::max(out.reach_mm, (p - out.centre).norm() + out.loop.width_mm / 2);
    loops_.push_back(std::move(out));
  }

  // Of the loops, those that are not marks of others; the largest first, so that each finds the one that it lies in.
  void choose_coils() {
    if (loops_.empty()) return;
    std::stable_sort(loops_.begin(), loops_.end(),
                     [](const Loop& a, const Loop& b) { return a.loop.area_mm2 > b.loop.area_mm2; });
    AlignedBox2d box;
    for (const Loop& loop : loops_) box.extend(box_of_line(loop.loop.line));
    grid_.emplace(box);
    for (Loop& loop : loops_) {
      if (coils_.size() > most_coils) return;
      const int host = host_of(loop);
      const int coil = host != none ? host : static_cast<int>(coils_.size());
      for (const int i : loop.pieces)
        if (of_piece_[i] == none) of_piece_[i] = coil;
      if (host != none) continue;
      share_centre(loop);
      grid_->add(coil, loop.loop, loop.centre);
      coils_.push_back(std::move(loop));
    }
  }

  // Loops in each other about nearly the same centre have the same.
  void share_centre(Loop& loop) const {
    constexpr double nearly = 0.1;  // of the inner loop's radius
    for (const Loop& outer : coils_)
      if ((outer.centre - loop.centre).norm() <= nearly * radius_of(loop.loop.area_mm2)) {
        loop.centre = outer.centre;
        return;
      }
  }

  // The coil that a loop is a mark of.
  int host_of(const Loop& loop) const {
    std::map<int, std::size_t> on_trace, in;
    for (const Vector2d& p : loop.loop.line) {
      for (const int coil : grid_->touched(p))
        if (coil != none) ++on_trace[coil];
      if (const int coil = grid_->inside(p); coil != none) ++in[coil];
    }
    const auto all = static_cast<double>(loop.loop.line.size());
    for (const auto& [coil, points] : on_trace)
      if (static_cast<double>(points) >= within * all) return coil;
    const double radius = radius_of(loop.loop.area_mm2);
    if (radius >= small_mm) return none;
    int best = none;
    std::size_t most = 0;
    for (const auto* found : {&on_trace, &in}) {
      for (const auto& [coil, points] : *found)
        if (points > most && radius < small_share * radius_of(coils_[coil].loop.area_mm2))
          best = coil, most = points;
      if (best != none) return best;
    }
    return none;
  }

  // Of each node, the only coil that it holds, none or many.
  std::vector<int> coils_of_nodes() const {
    std::vector<int> out(nodes_.size(), none);
    for (std::size_t c = 0; c < coils_.size(); ++c)
      for (const int i : coils_[c].pieces)
        for (int n = pieces_[i].node; n >= 0 && out[n] != many; n = nodes_[n].parent)
          if (out[n] == none)
            out[n] = static_cast<int>(c);
          else if (out[n] != static_cast<int>(c))
            out[n] = many;
    return out;
  }

  int coil_of_mark(int i, const std::vector<int>& coils_of) const {
    if (!grid_) return none;
    const Polyline& points = points_[i];
    std::map<int, std::size_t> on_trace, in;
    for (const Vector2d& p : points) {
      for (const int coil : grid_->touched(p))
        if (coil != none) ++on_trace[coil];
      if (const int coil = grid_->inside(p); coil != none) ++in[coil];
    }
    if (joins_two(i)) return none;
    const auto near = [&](int coil, double factor, double more_mm) {
      double reach = 0;
      for (const Vector2d& p : points) reach = std::max(reach, (p - coils_[coil].centre).norm());
      return reach <= factor * coils_[coil].reach_mm + more_mm;
    };
    for (int n = pieces_[i].node; n >= 0 && coils_of[n] != many; n = nodes_[n].parent)
      if (coils_of[n] != none && !is_layer(n)) {
        if (near(coils_of[n], group_reach, group_reach_mm)) return coils_of[n];
        break;
      }
    const auto most_of = [](const std::map<int, std::size_t>& found) {
      return *std::max_element(found.begin(), found.end(),
                               [](const auto& a, const auto& b) { return a.second < b.second; });
    };
    if (!on_trace.empty())
      if (const int coil = most_of(on_trace).first; near(coil, most_reach, more_reach_mm)) return coil;
    if (!in.empty())
      if (const auto [coil, found] = most_of(in);
          static_cast<double>(found) >= 0.5 * static_cast<double>(points.size()))
        return coil;
    return none;
  }

  // Whether an open line ends on two coils.
  bool joins_two(int i) const {
    if (!stroked_[i]) return false;
    for (const Curve& curve : shape(i).curves) {
      if (curve.closed || curve.points.empty()) continue;
      const auto from = grid_->touched(curve.points.front()), to = grid_->touched(curve.points.back());
      if (from[0] == none || to[0] == none) continue;
      const bool shared = std::any_of(from.begin(), from.end(), [&](int coil) {
        return coil != none && (coil == to[0] || coil == to[1]);
      });
      if (!shared) return true;
    }
    return false;
  }

  // What is left, in figures.
  void find_figures(const std::vector<int>& coils_of) {
    DisjointSets sets(pieces_.size());
    std::vector<int> left;
    for (int i = 0; i < count(); ++i)
      if (of_piece_[i] == none && inked(i) && !(grid_ && joins_two(i))) left.push_back(i);
    // Groups without a coil, the largest that is small enough.
    std::vector<AlignedBox2d> of_node(nodes_.size());
    for (const int i : left)
      for (int n = pieces_[i].node; n >= 0; n = nodes_[n].parent) of_node[n].extend(boxes_[i]);
    std::map<int, int> first_of_node;
    for (const int i : left) {
      int top = none;
      for (int n = pieces_[i].node;
           n >= 0 && coils_of[n] == none && of_node[n].sizes().maxCoeff() <= widest_group_mm;
           n = nodes_[n].parent)
        if (!is_layer(n) && (!nodes_[n].id.empty() || !nodes_[n].shape)) top = n;
      if (top == none) continue;
      const auto [at, first] = first_of_node.emplace(top, i);
      if (!first) sets.join(at->second, i);
    }
    join_near(left, sets);
    std::map<int, std::vector<int>> figures;
    for (const int i : left) figures[sets.root(i)].push_back(i);
    for (const auto& [root, pieces] : figures) {
      AlignedBox2d box;
      for (const int i : pieces) box.extend(boxes_[i]);
      if (!fits(box)) continue;
      for (const int i : pieces) of_piece_[i] = static_cast<int>(coils_.size() + figures_.size());
      figures_.push_back({box.center(), pieces});
    }
    take_whites();
    if (coils_.size() + figures_.size() <= most_sorted) return;
    for (int& element : of_piece_)
      if (element >= static_cast<int>(coils_.size())) element = none;
    figures_.clear();
  }

  // What is white and lies on a figure belongs to it.
  void take_whites() {
    std::size_t compared = 0;
    for (int i = 0; i < count(); ++i) {
      if (of_piece_[i] != none || inked(i)) continue;
      for (int under = i - 1; under >= 0 && ++compared < most_split * most_split; --under) {
        const int figure = of_piece_[under] - static_cast<int>(coils_.size());
        if (figure < 0 || !boxes_[under].contains(boxes_[i])) continue;
        of_piece_[i] = of_piece_[under];
        break;
      }
    }
  }

  static bool fits(const AlignedBox2d& box) { return box.sizes().maxCoeff() <= widest_figure_mm; }

  // Joins pieces whose boxes nearly touch, and small ones that are nearer than half of the smaller, as letters are.
  void join_near(std::vector<int> left, DisjointSets& sets) const {
    std::sort(left.begin(), left.end(), [&](int a, int b) {
      return std::pair(boxes_[a].min().x(), a) < std::pair(boxes_[b].min().x(), b);
    });
    std::size_t compared = 0;
    for (std::size_t k = 0; k < left.size(); ++k)
      for (std::size_t m = k + 1; m < left.size() && ++compared < most_split * most_split; ++m) {
        const AlignedBox2d &a = boxes_[left[k]], &b = boxes_[left[m]];
        if (b.min().x() > a.max().x() + std::max(least_gap_mm, letter_mm / 2)) break;
        const double size_a = a.sizes().maxCoeff(), size_b = b.sizes().maxCoeff();
        const bool letters = std::max(size_a, size_b) <= letter_mm;
        const double gap = std::max(least_gap_mm, letters ? 0.5 * std::min(size_a, size_b) : 0);
        if (a.exteriorDistance(b) <= gap) sets.join(left[k], left[m]);
      }
  }

  std::vector<SortedElement> named() {
    std::vector<SortedElement> out;
    for (Loop& coil : coils_) out.push_back({{}, coil.centre, std::move(coil.loop), {}, coil.pieces.front()});
    for (const Figure& figure : figures_) out.push_back({{}, figure.centre, {}, {}, figure.pieces.front()});
    for (int i = 0; i < count(); ++i)
      if (of_piece_[i] != none) out[of_piece_[i]].pieces.push_back(i);
    std::vector<int> only = elements_of_nodes();
    std::vector<std::string> ids;
    for (std::size_t e = 0; e < out.size(); ++e) ids.push_back(id_in_file(static_cast<int>(e), out[e], only));
    for (std::size_t e = 0; e < out.size(); ++e) out[e].id = std::move(ids[e]);
    for (std::size_t c = 0; c < coils_.size(); ++c) out[c].place = place_in_file(static_cast<int>(c), only);
    std::sort(out.begin(), out.end(),
              [](const SortedElement& a, const SortedElement& b) { return a.leading < b.leading; });
    make_unique(out);
    return out;
  }

  // Of each node, the only element that it holds, none or many.
  std::vector<int> elements_of_nodes() const {
    std::vector<int> out(nodes_.size(), none);
    for (int i = 0; i < count(); ++i) {
      if (of_piece_[i] == none) continue;
      for (int n = pieces_[i].node; n >= 0 && out[n] != many; n = nodes_[n].parent)
        if (out[n] == none)
          out[n] = of_piece_[i];
        else if (out[n] != of_piece_[i])
          out[n] = many;
    }
    return out;
  }

  // The innermost group that holds what an element consists of (of a coil, its loop) and no other element, or else the
  // first shape itself.
  std::string id_in_file(int e, const SortedElement& element, const std::vector<int>& only) const {
    const std::vector<int>& whole = element.loop ? coils_[e].pieces : element.pieces;
    std::map<int, std::size_t> held;
    for (const int i : whole)
      for (int n = pieces_[i].node; n >= 0 && only[n] == e; n = nodes_[n].parent) ++held[n];
    std::string of_part;
    for (int n = pieces_[whole.front()].node; n >= 0 && only[n] == e; n = nodes_[n].parent) {
      const FileNode& node = nodes_[n];
      if (node.id.empty()) continue;
      if (!node.shape && held[n] == whole.size()) return node.id;
      if (of_part.empty()) of_part = node.id;
    }
    return of_part;
  }

  std::optional<CoilPlace> place_in_file(int coil, const std::vector<int>& only) const {
    for (int n = pieces_[coils_[coil].pieces.front()].node; n >= 0 && only[n] == coil; n = nodes_[n].parent)
      if (nodes_[n].place) return nodes_[n].place;
    return std::nullopt;
  }

  static void make_unique(std::vector<SortedElement>& elements) {
    std::set<std::string> used, given;
    for (const SortedElement& e : elements) given.insert(e.id);
    std::map<std::string, int> copies;
    int coils = 0, marks = 0;
    for (SortedElement& e : elements) {
      int& number = e.loop ? coils : marks;
      ++number;
      if (e.id.empty()) {
        const std::string kind = e.loop ? "coil-" : "mark-";
        for (int n = number; e.id.empty() || given.contains(e.id) || used.contains(e.id); ++n)
          e.id = kind + std::to_string(n);
      }
      std::string unique = e.id;
      for (int& n = copies[e.id]; !used.insert(unique).second;) {
        n = std::max(2, n + 1);
        unique = std::string(e.id).append("-").append(std::to_string(n));
      }
      e.id = unique;
    }
  }

  struct Figure {
    Vector2d centre;
    std::vector<int> pieces;
  };

  const std::vector<PaintedShape>& pieces_;
  const std::vector<FileNode>& nodes_;
  std::vector<Polyline> points_;
  std::vector<AlignedBox2d> boxes_;
  std::vector<char> filled_, stroked_;  // with ink
  std::vector<int> whites_;             // that cover what is below
  std::vector<Loop> loops_, coils_;
  std::vector<Figure> figures_;
  std::vector<int> of_piece_;  // coils, then figures
  std::optional<CoilGrid> grid_;
  std::size_t whites_tried_ = 0;
  bool layered_ = false;  // Drawing::layered()
};

}  // namespace

std::vector<SortedElement> sort_into_elements(const std::vector<PaintedShape>& pieces,
                                              const std::vector<FileNode>& nodes) {
  return Sorting(pieces, nodes).sort();
}

std::vector<Element> with_shapes(std::vector<SortedElement> sorted, std::vector<PaintedShape> pieces) {
  std::vector<std::size_t> element_of(pieces.size(), sorted.size());
  for (std::size_t e = 0; e < sorted.size(); ++e)
    for (const int i : sorted[e].pieces) element_of[index(i)] = e;
  std::vector<Element> out;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (element_of[i] == sorted.size()) {
      if (out.empty() || !out.back().id.empty()) out.emplace_back();
      out.back().shapes.push_back(std::move(pieces[i].shape));
      continue;
    }
    SortedElement& element = sorted[element_of[i]];
    if (element.leading != static_cast<int>(i)) continue;
    out.push_back({element.id, element.centre, {}, std::move(element.loop), element.place});
    for (const int k : element.pieces) out.back().shapes.push_back(std::move(pieces[index(k)].shape));
  }
  return out;
}

Element one_element(std::string id, std::vector<Shape> shapes) {
  std::vector<PaintedShape> pieces;
  AlignedBox2d box;
  for (const Shape& shape : shapes) {
    box.extend(box_of_shape(shape));
    for (Shape& piece : pieces_of(shape)) pieces.push_back({std::move(piece)});
  }
  Element out{std::move(id), box.center(), std::move(shapes)};
  for (SortedElement& found : sort_into_elements(pieces, {}))
    if (found.loop && (!out.loop || found.loop->area_mm2 > out.loop->area_mm2)) {
      out.centre = found.centre;
      out.loop = std::move(found.loop);
    }
  return out;
}

}  // namespace vacuform
