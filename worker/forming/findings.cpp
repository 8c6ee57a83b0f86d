#include "worker/forming/findings.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <numeric>

#include "worker/decimal.hpp"

namespace vacuform {

namespace {

struct Piece {
  double area = 0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // centre of the area
  bool alone = true;                                // no vertex of it touches what it should not
};

// Connected pieces of the chosen triangles; triangles hang together by a corner that `joins` allows.
std::vector<Piece> pieces(const FormedSheet& sheet, const std::vector<double>& area,
                          const std::function<bool(std::size_t)>& chosen,
                          const std::function<bool(int)>& joins, const std::function<bool(int)>& spoils) {
  std::vector<int> root(sheet.rest.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  const auto first_joining = [&](const Triangle& t) { return std::find_if(t.begin(), t.end(), joins); };
  for (std::size_t k = 0; k < sheet.triangles.size(); ++k) {
    if (!chosen(k)) continue;
    const auto first = first_joining(sheet.triangles[k]);
    for (auto v = first; v != sheet.triangles[k].end(); ++v)
      if (joins(*v)) root[find(*v)] = find(*first);
  }
  std::vector<Piece> by_root(root.size());
  for (std::size_t k = 0; k < sheet.triangles.size(); ++k) {
    if (!chosen(k)) continue;
    const Triangle& t = sheet.triangles[k];
    Piece& piece = by_root[find(*first_joining(t))];
    piece.area += area[k];
    piece.place += area[k] / 3 * (sheet.formed[t[0]] + sheet.formed[t[1]] + sheet.formed[t[2]]);
    piece.alone = piece.alone && std::none_of(t.begin(), t.end(), spoils);
  }
  std::erase_if(by_root, [](const Piece& p) { return p.area == 0; });
  for (Piece& p : by_root) p.place /= p.area;
  return by_root;
}

std::string at(const Eigen::Vector3d& p) {
  return "x = " + decimal(p.x(), 0) + " mm, y = " + decimal(p.y(), 0) + " mm, z = " + decimal(p.z(), 0) +
         " mm";
}

// Where the worst of the pieces is, how large, and of how many.
std::string worst_of(const std::vector<Piece>& all) {
  const Piece& worst = *std::max_element(all.begin(), all.end(),
                                         [](const Piece& a, const Piece& b) { return a.area < b.area; });
  return "over " + decimal(worst.area, 0) + " mm2 at " + at(worst.place) +
         (all.size() == 1 ? "" : ", the largest of " + std::to_string(all.size()) + " places");
}

}  // namespace

std::vector<Warning> forming_findings(const FormedSheet& sheet, double sheet_thickness_mm,
                                      const FindingLimits& limits) {
  std::vector<double> area;
  for (const Triangle& t : sheet.triangles)
    area.push_back(
        0.5 *
        (sheet.formed[t[1]] - sheet.formed[t[0]]).cross(sheet.formed[t[2]] - sheet.formed[t[0]]).norm());
  std::vector<Warning> warnings;

  const auto is_free = [&](int v) { return sheet.contact[v] == Contact::free; };
  auto pockets = pieces(
      sheet, area,
      [&](std::size_t k) {
        return std::any_of(sheet.triangles[k].begin(), sheet.triangles[k].end(), is_free);
      },
      is_free,
      [&](int v) { return sheet.contact[v] == Contact::platform || sheet.contact[v] == Contact::clamp; });
  std::erase_if(pockets, [&](const Piece& p) { return !p.alone || p.area < limits.pocket_mm2; });
  if (!pockets.empty())
    warnings.push_back({"not-reached", "The sheet bridges a hollow of the mold without reaching it, " +
                                           worst_of(pockets) +
                                           "; a vent there or a higher machine.vacuum_kpa helps"});

  auto webs = pieces(
      sheet, area, [&](std::size_t k) { return sheet.element_slack[k] != 0; }, [](int) { return true; },
      [](int) { return false; });
  std::erase_if(webs, [&](const Piece& p) { return p.area < limits.web_mm2; });
  if (!webs.empty())
    warnings.push_back({"webbing", "The sheet is compressed sideways and tends to fold, " + worst_of(webs) +
                                       "; a wider window or a lower mold helps"});

  const auto thinnest = std::min_element(sheet.element_thickness.begin(), sheet.element_thickness.end());
  if (thinnest != sheet.element_thickness.end() && *thinnest < limits.thickness_ratio * sheet_thickness_mm) {
    const Triangle& t = sheet.triangles[static_cast<std::size_t>(thinnest - sheet.element_thickness.begin())];
    const Eigen::Vector3d place = (sheet.formed[t[0]] + sheet.formed[t[1]] + sheet.formed[t[2]]) / 3;
    warnings.push_back({"thin", "The sheet thins to " + decimal(*thinnest, 2) + " mm, " +
                                    decimal(100 * *thinnest / sheet_thickness_mm, 0) +
                                    " % of its thickness, at " + at(place) +
                                    "; a thicker sheet or a lower mold helps"});
  }
  return warnings;
}

}  // namespace vacuform
