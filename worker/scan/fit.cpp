// Whether a mold fits the sheet and the machine.
//
// Room: the mold is centred in the window. Around it the window leaves at least 5 mm and two sheet thicknesses, so that
// the sheet can turn down between mold and frame, and at least an eleventh of the draw: film across a gap g that goes
// down a wall of height H becomes g + H long, and below a twelfth of its thickness it tears. Draw: at most 1.5 times
// the window's shorter side. No sheet in that window holds enough plastic for more.
//
// Warnings: the same film over a place of height z at a distance d from the window thins to d / (d + z) of its
// thickness. The draw ratio, draw over the window's shorter side, is that of Throne, Technology of Thermoforming
// (1996); male molds deeper than their own width tend to web.
#include <algorithm>
#include <cmath>

#include "api/base/decimal.hpp"
#include "worker/scan/crumbs.hpp"
#include "worker/scan/cutting.hpp"
#include "worker/scan/mold.hpp"
#include "worker/scan/placing.hpp"
#include "worker/scan/scan_size.hpp"
#include "worker/scan/topology.hpp"

namespace vacuform {
namespace {

constexpr double most_draw = 1.5;         // over the window's shorter side
constexpr double least_gap = 1.0 / 11.0;  // over the draw
constexpr double deep_in_window = 0.5;    // draw over the window's shorter side
constexpr double deep_on_mold = 1;        // draw over the mold's shorter side
constexpr double least_clamp_mm = 5;      // of sheet in the clamp, on each side

// Rounded so that the proposed value is enough.
std::string mm_up(double value) { return in_mm(std::ceil(value * 10 - 1e-6) / 10); }
std::string mm_down(double value) { return in_mm(std::floor(value * 10 + 1e-6) / 10); }

Eigen::Vector2d window_of(const MachineSettings& machine) {
  const bool circle = machine.window == WindowShape::circle;
  return {machine.window_width_mm, circle ? machine.window_width_mm : machine.window_height_mm};
}

enum class Propose { no, yes };
// What does not fit; with proposals, each of which was tried, if they are asked for.
std::optional<Error> misfit(const Mold& mold, const SheetSettings& sheet, const MachineSettings& machine,
                            Propose propose);

bool fits(const Mold& mold, const SheetSettings& sheet, const MachineSettings& machine) {
  return !misfit(mold, sheet, machine, Propose::no);
}

// A proposal that leads to these settings, completed by a larger window if the mold then still does not fit.
std::vector<Proposal> completed(Proposal proposal, const Mold& mold, const SheetSettings& sheet,
                                const MachineSettings& machine) {
  const auto rest = misfit(mold, sheet, machine, Propose::yes);
  if (!rest) return {proposal};
  if (rest->proposals.empty()) return {};
  for (const ProposedSetting& more : rest->proposals.front().set) {
    std::erase_if(proposal.set, [&](const ProposedSetting& given) { return given.name == more.name; });
    proposal.set.push_back(more);
  }
  return {proposal};
}

// A window of at least this size, and a sheet with the same border in the clamp as now; nothing if no machine is that
// large, or if the mold still does not fit.
std::vector<Proposal> window_proposals(const Eigen::Vector2d& least, const Mold& mold, SheetSettings sheet,
                                       MachineSettings machine) {
  constexpr double largest_mm = 2000;
  const bool circle = machine.window == WindowShape::circle;
  Proposal larger;
  const auto set = [&](const char* name, double& setting, double value) {
    setting = std::ceil(value);
    larger.set.emplace_back(name, setting);
    return setting <= largest_mm;
  };
  bool possible = true;
  if (least.x() > machine.window_width_mm) {
    const double more = std::ceil(least.x()) - machine.window_width_mm;
    possible = set("machine.window_width_mm", machine.window_width_mm, least.x()) &&
               set("sheet.width_mm", sheet.width_mm, sheet.width_mm + more);
    if (circle) possible = possible && set("sheet.height_mm", sheet.height_mm, sheet.height_mm + more);
  }
  if (!circle && least.y() > machine.window_height_mm) {
    const double more = std::ceil(least.y()) - machine.window_height_mm;
    possible = possible && set("machine.window_height_mm", machine.window_height_mm, least.y()) &&
               set("sheet.height_mm", sheet.height_mm, sheet.height_mm + more);
  }
  if (!possible || !fits(mold, sheet, machine)) return {};
  return {larger};
}

// How far inside of the window a point lies.
double inside_window(const Eigen::Vector3d& p, const MachineSettings& machine) {
  const Eigen::Vector2d half = window_of(machine) / 2;
  if (machine.window == WindowShape::circle) return half.x() - p.head<2>().norm();
  return (half - p.head<2>().cwiseAbs()).minCoeff();
}

void find_close_window(const Mold& mold, const MachineSettings& machine, double thin_limit,
                       std::vector<Warning>& warnings) {
  double least = 1;
  const Eigen::Vector3d* where = nullptr;
  for (const auto& p : mold.mesh.vertices) {
    const double gap = inside_window(p, machine), draw = p.z() - machine.drape_height_mm;
    if (draw <= 0 || gap / (gap + draw) >= least) continue;
    least = gap / (gap + draw);
    where = &p;
  }
  if (!where || least >= thin_limit) return;
  const double gap = inside_window(*where, machine), draw = where->z() - machine.drape_height_mm;
  const double wanted = thin_limit / (1 - thin_limit) * draw;
  warnings.push_back({"window-close",
                      "The window is close to the mold: at x = " + in_mm(where->x()) +
                          ", y = " + in_mm(where->y()) + " the " + in_mm(gap) +
                          " of sheet between them have " + in_mm(draw) + " to go down and thin to about " +
                          in_percent(least) + " of their thickness",
                      {{{where->x(), where->y(), where->z()}, gap}},
                      Warning::Figure{gap, "mm", wanted},
                      "Leave " + in_mm(wanted) + " between mold and window (machine.window_width_mm)."});
}

void find_deep_draw(const Mold& mold, const MachineSettings& machine, std::vector<Warning>& warnings) {
  const double draw = mold.top.z() - machine.drape_height_mm;
  const double in_window = draw / window_of(machine).minCoeff();
  const double on_mold = draw / bounds(mold.mesh).size().head<2>().minCoeff();
  if (in_window <= deep_in_window && on_mold <= deep_on_mold) return;
  warnings.push_back(
      {"deep-draw",
       "The draw of " + in_mm(draw) + " is " + in_percent(in_window) + " of the window's shorter side and " +
           in_percent(on_mold) + " of the mold's; above " + in_percent(deep_in_window) + " or " +
           in_percent(deep_on_mold) + " the sheet thins much and tends to web",
       {{{mold.top.x(), mold.top.y(), mold.top.z()}, draw}},
       Warning::Figure{100 * in_window, "%", 100 * deep_in_window},
       in_window > deep_in_window ? "Trim the mold higher (scan.trim_mm), or use a larger window." : ""});
}

void find_narrow_clamp(const SheetSettings& sheet, const MachineSettings& machine,
                       std::vector<Warning>& warnings) {
  const Eigen::Vector2d edge = Eigen::Vector2d(sheet.width_mm, sheet.height_mm) / 2;
  const Eigen::Vector2d clamp = edge - window_of(machine) / 2;
  if (clamp.minCoeff() >= least_clamp_mm) return;
  const bool x = clamp.x() <= clamp.y();
  warnings.push_back({"clamp-narrow",
                      "Only " + in_mm(clamp.minCoeff()) + " of the sheet lie in the clamp on " +
                          (x ? "the left and the right" : "the front and the back") + ", and it may slip",
                      {{{x ? edge.x() : 0, x ? 0 : edge.y(), machine.drape_height_mm}, clamp.minCoeff()}},
                      Warning::Figure{clamp.minCoeff(), "mm", least_clamp_mm}});
}

// The mold as it is if the scan is trimmed higher; nothing if it cannot be cut there.
std::optional<Mold> trimmed(const Mold& mold, double higher_mm, const MachineSettings& machine) {
  auto cut = cut_above(mold.mesh, machine.plug_height_mm + higher_mm);
  if (!cut || cut->triangles.empty()) return std::nullopt;
  drop_crumbs(*cut);
  if (!is_watertight(*cut)) return std::nullopt;
  const Eigen::Vector2d middle = enclosing_circle(*cut).centre;
  for (auto& p : cut->vertices) p -= Eigen::Vector3d(middle.x(), middle.y(), higher_mm);
  Mold higher;
  higher.mesh = std::move(*cut);
  higher.findings.trim_mm = mold.findings.trim_mm + higher_mm;
  return higher;
}

// To trim the scan, or to use a window, for which the draw is not too deep.
std::vector<Proposal> draw_proposals(const Mold& mold, double draw, const Eigen::Vector2d& needed,
                                     const SheetSettings& sheet, const MachineSettings& machine) {
  std::vector<Proposal> proposals;
  const double trim = std::ceil(mold.findings.trim_mm + draw - most_draw * window_of(machine).minCoeff());
  if (const auto higher = trimmed(mold, trim - mold.findings.trim_mm, machine))
    proposals = completed({{{"scan.trim_mm", trim}}, ""}, *higher, sheet, machine);
  for (Proposal& window : window_proposals(needed.cwiseMax(draw / most_draw), mold, sheet, machine))
    proposals.push_back(std::move(window));
  return proposals;
}

Error error_with(Error error, const std::string& advice, std::vector<Proposal> proposals,
                 const std::string& otherwise = {}) {
  error.fix = advice_with(advice, proposals, otherwise);
  error.proposals = std::move(proposals);
  return error;
}

std::optional<Error> misfit(const Mold& mold, const SheetSettings& sheet, const MachineSettings& machine,
                            Propose propose) {
  const bool circle = machine.window == WindowShape::circle;
  const double width = window_of(machine).x(), height = window_of(machine).y();
  const auto tried = [&](const auto& make) {
    return propose == Propose::yes ? make() : std::vector<Proposal>();
  };
  if (width > sheet.width_mm || height > sheet.height_mm)
    return error_with(
        {Code::does_not_fit,
         "the window of " + in_mm(width) + " x " + in_mm(height) + " is larger than the sheet of " +
             in_mm(sheet.width_mm) + " x " + in_mm(sheet.height_mm),
         "machine.window_width_mm", ""},
        "give a smaller window or a larger sheet", tried([&] {
          constexpr double clamp_mm = 20;  // on both sides together, as of the default sheet
          SheetSettings larger = sheet;
          Proposal proposal;
          const auto enlarge = [&](const char* name, double& side, double window) {
            if (window <= side) return;
            side = std::min(2000.0, std::ceil(window + clamp_mm));
            proposal.set.emplace_back(name, side);
          };
          enlarge("sheet.width_mm", larger.width_mm, width);
          enlarge("sheet.height_mm", larger.height_mm, height);
          return completed(std::move(proposal), mold, larger, machine);
        }));
  const Box box = bounds(mold.mesh);
  const double draw = box.high.z() - machine.drape_height_mm;
  const double room = std::max(5 + 2 * sheet.thickness_mm, least_gap * draw);
  // A frame that stops level with the top is allowed: the sheet then lies on the rim of a mold with a pit. So is an
  // excess by rounding.
  if (machine.drape_height_mm > box.high.z() + 0.01)
    return error_with(
        {Code::does_not_fit,
         "the frame stops " + in_mm(machine.drape_height_mm) + " above the platform, " +
             in_mm(machine.drape_height_mm - box.high.z()) +
             " above the mold's top, and the sheet never meets the mold",
         "machine.drape_height_mm", ""},
        "give at most " + mm_down(box.high.z()), tried([&] {
          MachineSettings lower = machine;
          lower.drape_height_mm = std::floor(box.high.z());
          return completed({{{"machine.drape_height_mm", lower.drape_height_mm}}, ""}, mold, sheet, lower);
        }));
  double radius = 0;
  for (const auto& p : mold.mesh.vertices) radius = std::max(radius, p.head<2>().norm());
  // The window is centred on the circle around the mold, which need not be the middle of the mold's width.
  const Eigen::Vector2d reach = box.high.head<2>().cwiseMax(-box.low.head<2>());
  const Eigen::Vector2d needed = circle ? Eigen::Vector2d(Eigen::Vector2d::Constant(2 * (radius + room)))
                                        : Eigen::Vector2d(2 * (reach.array() + room));
  const double shorter = std::min(width, height);
  if (draw > most_draw * shorter)
    return error_with({Code::does_not_fit,
                       "the draw of the mold is " + in_mm(draw) + ", " + in_mm(draw - most_draw * shorter) +
                           " more than a sheet in a window of " + in_mm(shorter) + " allows",
                       "scan.trim_mm", ""},
                      "trim the mold at least that much higher, or give a larger window and sheet",
                      tried([&] { return draw_proposals(mold, draw, needed, sheet, machine); }));
  const std::string otherwise = "trim the mold higher (scan.trim_mm), or scan a smaller part";
  const auto larger_window = [&] {
    return tried([&] { return window_proposals(needed, mold, sheet, machine); });
  };
  if (circle) {
    if (const double over = radius + room - width / 2; over > 0)
      return error_with(
          {Code::does_not_fit,
           "the mold reaches " + in_mm(radius) + " from the middle and with " + in_mm(room) + " of room is " +
               in_mm(over) + " too wide for the round window of " + in_mm(width),
           "machine.window_width_mm", ""},
          "give a window and a sheet of at least " + mm_up(needed.x()), larger_window(), otherwise);
    return std::nullopt;
  }
  const double over_x = needed.x() - width, over_y = needed.y() - height;
  if (over_x <= 0 && over_y <= 0) return std::nullopt;
  const int k = over_x >= over_y ? 0 : 1;
  const bool aside = 2 * reach[k] - box.size()[k] > 0.1;
  return error_with({Code::does_not_fit,
                     "the mold is " + in_mm(box.size()[k]) + (k == 0 ? " wide" : " deep") +
                         (aside ? ", reaches " + in_mm(reach[k]) + " from the middle" : "") + " and with " +
                         in_mm(room) + " of room on each side is " + in_mm(std::max(over_x, over_y)) +
                         " too large for the window of " + in_mm(k == 0 ? width : height),
                     k == 0 ? "machine.window_width_mm" : "machine.window_height_mm", ""},
                    "give a window and a sheet of at least " + mm_up(needed[k]), larger_window(), otherwise);
}

// Other units than the guessed one that would make the mold fit: a small scan may have been taken for a large one.
std::vector<Proposal> unit_proposals(const Mold& mold, const SheetSettings& sheet,
                                     const MachineSettings& machine) {
  std::vector<Proposal> fitting;
  for (const Warning& warning : mold.warnings) {
    if (warning.code != "units-guessed") continue;
    for (const Proposal& proposal : warning.proposals)
      for (const Unit unit : {Unit::mm, Unit::cm, Unit::m, Unit::in, Unit::um, Unit::ft}) {
        if (proposal.set.size() != 1 || proposal.set.front().word != name(unit)) continue;
        Mold scaled;
        scaled.mesh = mold.mesh;
        for (auto& p : scaled.mesh.vertices) p *= millimetres(unit) / millimetres(mold.findings.unit);
        if (fits(scaled, sheet, machine)) fitting.push_back(proposal);
      }
  }
  return fitting;
}

}  // namespace

Result<void> check_fit(const Mold& mold, const SheetSettings& sheet, const MachineSettings& machine) {
  auto error = misfit(mold, sheet, machine, Propose::yes);
  if (!error) return {};
  const std::vector<Proposal> units = unit_proposals(mold, sheet, machine);
  if (!units.empty()) error->fix = advice_with("check the unit, which was guessed", units, error->fix);
  error->proposals.insert(error->proposals.begin(), units.begin(), units.end());
  return tl::make_unexpected(std::move(*error));
}

std::vector<Warning> fit_findings(const Mold& mold, const SheetSettings& sheet,
                                  const MachineSettings& machine, double thin_limit) {
  std::vector<Warning> warnings;
  find_close_window(mold, machine, thin_limit, warnings);
  find_deep_draw(mold, machine, warnings);
  find_narrow_clamp(sheet, machine, warnings);
  return warnings;
}

}  // namespace vacuform
