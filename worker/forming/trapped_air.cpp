#include "worker/forming/trapped_air.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "worker/scan/ray_caster.hpp"
#include "worker/surface/adjacency.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;

constexpr double vent_spacing_mm = 25;
constexpr double late_share = 0.2;  // of a pocket's vertices: where its air leaves last

// How far the mold lies straight below free vertices.
class Below {
 public:
  explicit Below(const TriangleMesh& mold) : mold_(mold) {}
  double gap(const Vector3d& p) {
    if (mold_.triangles.empty()) return 0;
    if (!rays_) rays_.emplace(mold_);  // most sheets have no free pocket, and need no tree
    const auto hit = rays_->first_hit(p, {0, 0, -p.z()});
    return hit ? hit->t * p.z() : 0;
  }

 private:
  const TriangleMesh& mold_;
  std::optional<RayCaster> rays_;
};

class MergeTree {
 public:
  MergeTree(const FormedSheet& sheet, const TriangleMesh& mold, const PocketLimits& limits)
      : sheet_(sheet),
        limits_(limits),
        below_(mold),
        fans_(sheet.triangles, sheet.rest.size()),
        time_(sheet.contact_time),
        area_(sheet.rest.size(), 0),
        root_(sheet.rest.size(), out),
        inside_(sheet.rest.size(), 0),
        place_(sheet.formed) {
    for (const Triangle& t : sheet.triangles) {
      const double area =
          (sheet.formed[t[1]] - sheet.formed[t[0]]).cross(sheet.formed[t[2]] - sheet.formed[t[0]]).norm() / 2;
      for (int v : t) area_[v] += area / 3;
    }
  }

  std::vector<Pocket> run() {
    std::vector<int> order;
    for (int v = 0; v < static_cast<int>(root_.size()); ++v) {
      if (sheet_.contact[v] == Contact::platform || sheet_.contact[v] == Contact::clamp) {
        root_[v] = drained;
        continue;
      }
      if (std::isnan(time_[v])) time_[v] = std::numeric_limits<double>::infinity();
      order.push_back(v);
    }
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return time_[a] > time_[b]; });
    for (int v : order) enter(v);
    std::stable_sort(pockets_.begin(), pockets_.end(),
                     [](const Pocket& a, const Pocket& b) { return a.area_mm2 > b.area_mm2; });
    return std::move(pockets_);
  }

 private:
  static constexpr int out = -1, drained = -2;  // not entered yet; joined to what the vacuum drains

  // A branch is named by its first vertex, the latest; all its members are in regions_[name].
  struct Region {
    std::vector<int> vertices;
    std::vector<std::vector<int>> basins;
  };

  int find(int v) {
    while (root_[v] >= 0 && root_[v] != v) {
      if (root_[root_[v]] >= 0) root_[v] = root_[root_[v]];
      v = root_[v];
    }
    return root_[v] == v ? v : root_[v];
  }

  void enter(int v) {
    std::vector<int> around;  // the branches that meet here
    bool drains = false;
    for (const int w : fans_.around(v)) {
      if (root_[w] == out) continue;
      const int r = find(w);
      if (r == drained)
        drains = true;
      else if (std::find(around.begin(), around.end(), r) == around.end())
        around.push_back(r);
    }
    if (drains) {
      for (int r : around) close(r, v);
      root_[v] = drained;
      return;
    }
    root_[v] = v;
    if (around.empty()) {
      regions_[v].vertices = {v};
      return;
    }
    // The branch that began latest continues; the others end in it.
    const auto later = [&](int a, int b) { return time_[a] != time_[b] ? time_[a] > time_[b] : a < b; };
    const int elder = *std::min_element(around.begin(), around.end(), later);
    Region& into = regions_[elder];
    for (int r : around) {
      if (r == elder) continue;
      Region& from = regions_[r];
      if (!std::isinf(time_[v]) && measure(from.vertices)) into.basins.push_back(from.vertices);
      if (from.vertices.size() > into.vertices.size()) std::swap(from.vertices, into.vertices);
      into.vertices.insert(into.vertices.end(), from.vertices.begin(), from.vertices.end());
      into.basins.insert(into.basins.end(), from.basins.begin(), from.basins.end());
      from = {};
      root_[r] = elder;
    }
    root_[v] = elder;
    into.vertices.push_back(v);
  }

  // The branch meets the drained part at `saddle`: there and then it was shut in, unless the saddle stays open.
  void close(int r, int saddle) {
    Region& region = regions_[r];
    if (auto pocket = std::isinf(time_[saddle]) ? std::nullopt : measure(region.vertices)) {
      pocket->closed = time_[saddle];
      pocket->basins = std::move(region.basins);
      for (auto& basin : pocket->basins) put_latest_first(basin);
      pockets_.push_back(std::move(*pocket));
    }
    region = {};
    root_[r] = drained;
  }

  // As a pocket, unless it is below the limits.
  std::optional<Pocket> measure(const std::vector<int>& vertices) {
    Pocket pocket;
    for (int v : vertices) pocket.area_mm2 += area_[v];
    if (vertices.size() < limits_.vertices || pocket.area_mm2 < limits_.area_mm2) return {};
    pocket.depth_mm = depth(vertices);
    if (pocket.depth_mm < limits_.depth_mm) return {};
    pocket.vertices = vertices;
    put_latest_first(pocket.vertices);
    return pocket;
  }

  void put_latest_first(std::vector<int>& vertices) {
    std::vector<std::pair<double, int>> keyed;
    for (int v : vertices)
      keyed.emplace_back(std::isinf(time_[v]) ? below_.gap(sheet_.formed[v]) : -HUGE_VAL, v);
    std::sort(keyed.begin(), keyed.end(), [&](const auto& a, const auto& b) {
      if (time_[a.second] != time_[b.second]) return time_[a.second] > time_[b.second];
      return a.first != b.first ? a.first > b.first : a.second < b.second;
    });
    for (std::size_t i = 0; i < vertices.size(); ++i) vertices[i] = keyed[i].second;
  }

  // How deep the vertices lie, in the end, below a film without pressure that spans what held their border: it hangs
  // like a harmonic function. Where they never touch, the mold below them counts.
  double depth(const std::vector<int>& vertices) {
    for (int v : vertices) inside_[v] = 1;
    const Vector3d up = area_vector(vertices).normalized();
    constexpr int sweeps = 200;
    constexpr double over_relaxation = 1.8, settled_mm = 1e-3;
    double moved = HUGE_VAL;
    for (int k = 0; k < sweeps && moved > settled_mm; ++k) {
      moved = 0;
      for (int v : vertices) {
        Vector3d sum = Vector3d::Zero();
        int count = 0;
        for (const int w : fans_.around(v)) sum += place_[w], ++count;
        const Vector3d step = over_relaxation * (sum / count - place_[v]);
        place_[v] += step;
        moved = std::max(moved, step.norm());
      }
    }
    double deepest = 0;
    for (int v : vertices) {
      double below = (place_[v] - sheet_.formed[v]).dot(up);
      if (std::isinf(time_[v])) below += below_.gap(sheet_.formed[v]);
      deepest = std::max(deepest, below);
      inside_[v] = 0;
      place_[v] = sheet_.formed[v];
    }
    return deepest;
  }

  // Twice the sum of the area vectors of the triangles with a corner in `vertices`, which are marked as inside_.
  Vector3d area_vector(const std::vector<int>& vertices) const {
    Vector3d sum = Vector3d::Zero();
    for (int v : vertices) {
      const auto around = fans_.around(v);
      for (std::size_t k = 0; k < around.size(); k += 2) {
        const int a = around[k], b = around[k + 1];
        if ((inside_[a] && a < v) || (inside_[b] && b < v)) continue;  // counted there
        sum += (sheet_.formed[a] - sheet_.formed[v]).cross(sheet_.formed[b] - sheet_.formed[v]);
      }
    }
    return sum;
  }

  const FormedSheet& sheet_;
  PocketLimits limits_;
  Below below_;
  VertexFans fans_;
  std::vector<double> time_, area_;
  std::vector<int> root_;
  std::vector<char> inside_;     // scratch of depth()
  std::vector<Vector3d> place_;  // in the same order: the film
  std::map<int, Region> regions_;
  std::vector<Pocket> pockets_;
};

}  // namespace

std::vector<Pocket> trapped_air(const FormedSheet& sheet, const TriangleMesh& mold,
                                const PocketLimits& limits) {
  return MergeTree(sheet, mold, limits).run();
}

std::vector<Vent> vents_for(const std::vector<Pocket>& pockets, const FormedSheet& sheet,
                            const TriangleMesh& mold, double sheet_thickness_mm) {
  Below below(mold);
  std::vector<Vent> all;
  const double diameter = std::max(1.0, sheet_thickness_mm / 2);
  for (const Pocket& pocket : pockets) {
    const std::size_t first = all.size();
    const auto drill = [&](const std::vector<int>& latest_first) {
      auto late = static_cast<std::size_t>(std::ceil(late_share * static_cast<double>(latest_first.size())));
      while (late < latest_first.size() &&
             sheet.contact_time[latest_first[late]] == sheet.contact_time[latest_first[late - 1]])
        ++late;
      for (std::size_t i = 0; i < late; ++i) {
        const int v = latest_first[i];
        Vector3d place = sheet.formed[v];
        if (sheet.contact[v] == Contact::free) place.z() -= below.gap(place);
        const auto near = [&](const Vent& vent) { return (vent.place - place).norm() < vent_spacing_mm; };
        if (std::none_of(all.begin() + static_cast<std::ptrdiff_t>(first), all.end(), near))
          all.push_back({place, diameter});
      }
    };
    drill(pocket.vertices);
    for (const auto& basin : pocket.basins) drill(basin);
  }
  return all;
}

}  // namespace vacuform
