// A second opinion on a formed sheet. Reads only what a job delivers, and shares no code with what made it.
//
//     check_sheet FOLDER
//
// FOLDER has formed.ply, mold.stl and report.json. Prints as JSON the places where the sheet is
// - torn: its mesh has a crack or a hole, or more than a cell of the grid is stretched sixfold or to five times its area;
// - folded: triangles have lost four fifths of their area, or lie upside down;
// - penetrated: the mold stands out of the sheet, or the sheet reaches into the mold, by more than half a millimetre, or a
//   fifth of a coarser grid spacing;
// - off the mold: what the report says touches the mold or the platform is farther from it than that, between three such
//   vertices than half a grid spacing; or the sheet hangs free more than 3 mm, or one and a half grid spacings, from everything;
// - misreported: the thickness is not what conservation of mass gives, or the report's penetration is too small.
// Each with the code of the warning that marks the place, if the report has one: a mark nearer than its own size and two grid
// spacings. Exit 0 if every place is marked, 1 if one is not, 2 with a line on stderr.
#include <algorithm>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "surfaces.hpp"

namespace {

using namespace check;
using Json = nlohmann::ordered_json;

struct Flaw {
  Vector3d place;
  double size;             // how bad: mm, or times
  double area = HUGE_VAL;  // of the sheet, mm2: places of less than a grid cell do not count
};

class Checker {
 public:
  explicit Checker(const std::string& folder)
      : sheet_(read_sheet(folder + "/formed.ply")),
        mold_(read_stl(folder + "/mold.stl")),
        report_(Json::parse(read_all(folder + "/report.json"))) {
    const Json& settings = report_.at("settings");
    grid_ = settings.at("sheet").at("resolution_mm");
    thickness_ = settings.at("sheet").at("thickness_mm");
    wall_mm_ = settings.at("machine").at("drape_height_mm");
    limit_ =
        1.1 * std::max(0.5, 0.2 * grid_);  // a tenth above the program's: both take samples, at other places
  }

  int run() {
    check_mesh();
    check_stretch();
    check_contact();
    summary_["grid_mm"] = grid_, summary_["places"] = std::move(places_);
    summary_["unmarked"] = unmarked_;
    std::cout << summary_.dump(1) << '\n';
    return unmarked_ ? 1 : 0;
  }

 private:
  // Flaws of a kind that are nearer to each other than two grid spacings are one place, named by its worst.
  void add(const std::string& kind, const std::string& what, std::vector<Flaw> flaws,
           const std::set<std::string>& codes) {
    const double cell = 2 * grid_;
    std::map<std::array<int, 3>, std::vector<std::size_t>> cells;
    const auto cell_of = [&](const Vector3d& p) {
      return std::array<int, 3>{static_cast<int>(std::floor(p.x() / cell)),
                                static_cast<int>(std::floor(p.y() / cell)),
                                static_cast<int>(std::floor(p.z() / cell))};
    };
    for (std::size_t i = 0; i < flaws.size(); ++i) cells[cell_of(flaws[i].place)].push_back(i);
    while (!cells.empty()) {
      std::vector<std::array<int, 3>> open{cells.begin()->first};
      std::vector<std::size_t> members = cells.begin()->second;
      cells.erase(cells.begin());
      while (!open.empty()) {
        const auto c = open.back();
        open.pop_back();
        for (int k = 0; k < 27; ++k) {
          const auto found = cells.find({c[0] + k % 3 - 1, c[1] + k / 3 % 3 - 1, c[2] + k / 9 - 1});
          if (found == cells.end()) continue;
          open.push_back(found->first);
          members.insert(members.end(), found->second.begin(), found->second.end());
          cells.erase(found);
        }
      }
      std::string by;
      std::size_t worst = members.front();
      double area = 0;
      for (const std::size_t i : members) {
        area += flaws[i].area;
        if (flaws[i].size > flaws[worst].size) worst = i;
        if (by.empty()) by = marked(flaws[i].place, codes);
      }
      if (area < grid_ * grid_) continue;
      const Vector3d& p = flaws[worst].place;
      places_.push_back({{"kind", kind},
                         {"what", what},
                         {"place_mm", {p.x(), p.y(), p.z()}},
                         {"size", flaws[worst].size},
                         {"samples", members.size()},
                         {"marked_by", by.empty() ? Json(nullptr) : Json(by)}});
      unmarked_ += by.empty();
    }
  }

  std::string marked(const Vector3d& p, const std::set<std::string>& codes) const {
    for (const Json& warning : report_.at("warnings")) {
      const std::string code = warning.at("code");
      if (!codes.contains(code) || !warning.contains("marks")) continue;
      for (const Json& mark : warning["marks"]) {
        const Json& at = mark.at("place_mm");
        if ((Vector3d(at[0], at[1], at[2]) - p).norm() <= mark.at("size_mm").get<double>() + 2 * grid_)
          return code;
      }
    }
    return {};
  }

  // The flat sheet is covered once and without a gap, and what hung together still does.
  void check_mesh() {
    std::vector<Flaw> flaws;
    if (sheet_.cracked) flaws.push_back({sheet_.crack, 1});
    Vector2d low = sheet_.rest.front(), high = low;
    for (const auto& p : sheet_.rest) low = low.cwiseMin(p), high = high.cwiseMax(p);
    std::map<std::pair<int, int>, int> uses;
    double covered = 0;
    for (std::size_t t = 0; t < sheet_.triangles.size(); ++t) {
      covered += rest_area(t);
      if (rest_area(t) <= 0) flaws.push_back({sheet_.corner(t, 0), 1});
      for (int k = 0; k < 3; ++k) {
        const int a = sheet_.triangles[t][k], b = sheet_.triangles[t][(k + 1) % 3];
        ++uses[std::minmax(a, b)];
      }
    }
    const auto on_rim = [&](int v) {
      const Vector2d& p = sheet_.rest[static_cast<std::size_t>(v)];
      return std::min((p - low).minCoeff(), (high - p).minCoeff()) < 1e-3;
    };
    for (const auto& [edge, count] : uses)
      if (count != 2 && !(count == 1 && on_rim(edge.first) && on_rim(edge.second)))
        flaws.push_back({sheet_.points[static_cast<std::size_t>(edge.first)], 1});
    if (std::abs(covered / (high - low).prod() - 1) > 1e-3) flaws.push_back({sheet_.points.front(), 1});
    add("torn", "the mesh of the sheet has a crack or a hole", std::move(flaws), {});
  }

  double rest_area(std::size_t t) const {
    const auto& [a, b, c] = sheet_.triangles[t];
    const Vector2d u = sheet_.rest[static_cast<std::size_t>(b)] - sheet_.rest[static_cast<std::size_t>(a)],
                   v = sheet_.rest[static_cast<std::size_t>(c)] - sheet_.rest[static_cast<std::size_t>(a)];
    return (u.x() * v.y() - u.y() * v.x()) / 2;
  }

  double largest_stretch(std::size_t t) const {
    const auto& [a, b, c] = sheet_.triangles[t];
    Eigen::Matrix2d flat;
    flat << sheet_.rest[static_cast<std::size_t>(b)] - sheet_.rest[static_cast<std::size_t>(a)],
        sheet_.rest[static_cast<std::size_t>(c)] - sheet_.rest[static_cast<std::size_t>(a)];
    Eigen::Matrix<double, 3, 2> formed;
    formed << sheet_.corner(t, 1) - sheet_.corner(t, 0), sheet_.corner(t, 2) - sheet_.corner(t, 0);
    const Eigen::Matrix<double, 3, 2> gradient = formed * flat.inverse();
    const Eigen::Matrix2d squared = gradient.transpose() * gradient;
    return std::sqrt(squared.trace() / 2 + std::hypot((squared(0, 0) - squared(1, 1)) / 2, squared(0, 1)));
  }

  void check_stretch() {
    std::vector<Flaw> drawn, run_away, lost, over, thick;
    std::vector<double> before(sheet_.points.size(), 0), after = before;
    double most = 0;
    for (std::size_t t = 0; t < sheet_.triangles.size(); ++t) {
      const Vector3d cross = sheet_.cross(t),
                     middle = (sheet_.corner(t, 0) + sheet_.corner(t, 1) + sheet_.corner(t, 2)) / 3;
      const double area = cross.norm() / 2, flat = rest_area(t);
      if (!(flat > 0)) continue;
      const double stretch = largest_stretch(t), grown = area / flat;
      most = std::max(most, stretch);
      if (stretch > 20) run_away.push_back({middle, stretch, area});
      if (stretch > 6 || grown > 5) drawn.push_back({middle, std::max(stretch, grown), area});
      if (grown < 0.2) lost.push_back({middle, 1 / std::max(grown, 1e-9)});
      if (cross.z() < -0.3 * cross.norm() && area > 0.02 * grid_ * grid_) over.push_back({middle, area});
      for (const int v : sheet_.triangles[t])
        before[static_cast<std::size_t>(v)] += flat, after[static_cast<std::size_t>(v)] += area;
    }
    for (std::size_t v = 0; v < before.size(); ++v) {
      const double due = thickness_ * before[v] / after[v];
      if (std::abs(sheet_.thickness[v] / due - 1) > 0.02)
        thick.push_back({sheet_.points[v], sheet_.thickness[v] / due});
    }
    summary_["largest_stretch"] = most;
    add("torn", "the sheet is stretched more than plastic bears", std::move(drawn),
        {"thin", "unstable-stretch"});
    add("torn", "the sheet is stretched more than twentyfold", std::move(run_away), {"unstable-stretch"});
    add("folded", "the sheet has lost four fifths of its area", std::move(lost), {"webbing"});
    add("folded", "the sheet lies upside down", std::move(over), {"webbing", "undercut"});
    add("misreported", "the thickness does not conserve mass", std::move(thick), {});
  }

  void check_contact() {
    const double spacing = std::clamp(grid_ / 4, 0.4, 1.0), reach = 100;
    const Finder to_sheet(sheet_), to_mold(mold_);
    std::vector<Flaw> through, away, bridged, floating;
    double deepest = 0, farthest = 0;
    for (std::size_t t = 0; t < mold_.triangles.size(); ++t)
      sample(mold_, t, spacing, [&](const Vector3d& p) {
        if (p.z() < 0.1 || to_sheet.crossings_above(p - Vector3d(0, 0, 0.02)) > 0) return;
        const double depth = to_sheet.distance(p, reach);
        deepest = std::max(deepest, depth);
        if (depth > limit_) through.push_back({p, depth});
      });
    for (std::size_t t = 0; t < sheet_.triangles.size(); ++t) {
      int touching = 0, held = 0;
      for (const int v : sheet_.triangles[t]) {
        touching += sheet_.contact[static_cast<std::size_t>(v)] == on_mold;
        held += sheet_.contact[static_cast<std::size_t>(v)] == in_clamp;
      }
      if (held == 3) continue;
      const bool any_free = std::ranges::any_of(sheet_.triangles[t], [&](int v) {
        return sheet_.contact[static_cast<std::size_t>(v)] == free_sheet;
      });
      sample(sheet_, t, spacing, [&](const Vector3d& p) {
        const bool low = p.z() < 0.1;
        if (low && touching < 3) return;
        const double distance = to_mold.distance(p, reach);
        if (to_mold.crossings_above(p) > 0) {
          deepest = std::max(deepest, low ? 0 : distance);
          if (!low && distance > limit_) through.push_back({p, distance});
          return;
        }
        if (touching == 3 && distance > std::max(0.5, 0.5 * grid_)) bridged.push_back({p, distance});
        const double gap = std::min(distance, p.z() < wall_mm_ ? 0 : p.z());
        if (any_free) farthest = std::max(farthest, gap);
        if (any_free && gap > std::max(3.0, 1.5 * grid_)) floating.push_back({p, gap});
      });
    }
    for (std::size_t v = 0; v < sheet_.points.size(); ++v) {
      const Vector3d& p = sheet_.points[v];
      const double gap = sheet_.contact[v] == on_mold       ? to_mold.distance(p, reach)
                         : sheet_.contact[v] == on_platform ? std::abs(p.z())
                                                            : 0;
      if (gap > limit_) away.push_back({p, gap});
    }
    const double reported = report_.at("forming").at("penetration_mm").at("max");
    summary_["penetration_mm"] = deepest, summary_["free_mm"] = farthest;
    if (deepest > 1.1 * reported + 0.3)
      add("misreported", "the mold stands out further than the report says", {{Vector3d::Zero(), deepest}},
          {});
    add("penetrated", "the mold and the sheet cross", std::move(through), {"pierced"});
    add("off the mold", "the sheet does not touch what the report says it touches", std::move(away), {});
    add("off the mold", "the sheet bridges a hollow between vertices that touch", std::move(bridged),
        {"not-reached", "trapped-air"});
    add("off the mold", "the sheet hangs free", std::move(floating),
        {"not-reached", "trapped-air", "undercut", "webbing"});
  }

  Sheet sheet_;
  Surface mold_;
  Json report_, summary_, places_ = Json::array();
  double grid_ = 0, thickness_ = 0, wall_mm_ = 0, limit_ = 0;
  int unmarked_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: check_sheet FOLDER\n";
    return 2;
  }
  try {
    return Checker(argv[1]).run();
  } catch (const std::exception& e) {
    std::cerr << "check_sheet: " << e.what() << '\n';
    return 2;
  }
}
