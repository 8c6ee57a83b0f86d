#include "worker/scan/mold.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "api/base/decimal.hpp"
#include "worker/scan/closing.hpp"
#include "worker/scan/crumbs.hpp"
#include "worker/scan/cutting.hpp"
#include "worker/scan/mold_top.hpp"
#include "worker/scan/outliers.hpp"
#include "worker/scan/placing.hpp"
#include "worker/scan/poses.hpp"
#include "worker/scan/rebuilding.hpp"
#include "worker/scan/scan_file.hpp"
#include "worker/scan/scan_size.hpp"
#include "worker/scan/shells.hpp"
#include "worker/scan/smoothing.hpp"
#include "worker/scan/topology.hpp"
#include "worker/scan/trimming.hpp"
#include "worker/scan/undercuts.hpp"
#include "worker/scan/upright.hpp"
#include "worker/scan/welding.hpp"
#include "worker/scan/wrapping.hpp"

namespace vacuform {
namespace {

constexpr double weld_share = 1e-6;  // of the scan's size: float rounding moves a point less than this

void turn(TriangleMesh& mesh, const Eigen::Matrix3d& rotation, double scale) {
  for (auto& p : mesh.vertices) p = scale * (rotation * p);
  if (rotation.determinant() < 0)
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

// Moves the mesh onto z = 0, around x = y = 0: a turn far from there rounds more. Returns the point that becomes the
// origin.
Eigen::Vector3d stand_on_floor(TriangleMesh& mesh) {
  const Box box = bounds(mesh);
  const Eigen::Vector3d foot(box.centre().x(), box.centre().y(), box.low.z());
  for (auto& p : mesh.vertices) p -= foot;
  return foot;
}

// The closed mesh grown by the clearance. If long thin triangles make that too expensive, with wider facets. Heads and
// masks take 13 to 23 million tests.
Result<TriangleMesh> offset(const TriangleMesh& mesh, double clearance_mm, const ScanProgress& progress) {
  const double alpha = std::max(2.0, 0.01 * bounds(mesh).size().norm());
  const std::int64_t tests = 25'000'000 + 400 * static_cast<std::int64_t>(mesh.triangles.size());
  WrapBudget budget{tests};
  auto grown = wrap(mesh, alpha, clearance_mm, progress, budget);
  if (grown || grown.error().code == Code::cancelled) return grown;
  budget.tests = tests;
  return wrap(mesh, 2.5 * alpha, clearance_mm, progress, budget);
}

// The upright scan as a closed mesh; the part below z = 0 is to be cut off.
Result<TriangleMesh> close(const OuterSkin& skin, double clearance_mm, Mold& mold,
                           const ScanProgress& progress) {
  auto closing = skin.soup ? Closing{} : close_skin(skin.mesh);
  if (!closing.sound) {
    VACUFORM_TRY(rebuilt, rebuild(skin.mesh, progress));
    closing = {};
    closing.mesh = std::move(rebuilt);
    mold.findings.rebuilt = true;
  }
  mold.findings.holes_closed = closing.holes_closed;
  mold.findings.holes_capped = closing.holes_capped;
  constexpr double large_hole_mm = 20;
  if (closing.largest_filled_mm > large_hole_mm)
    mold.warnings.push_back(
        {"large-hole",
         "A hole " + in_mm(closing.largest_filled_mm) + " across was filled; the mold is a guess there",
         {},
         Warning::Figure{closing.largest_filled_mm, "mm", large_hole_mm}});
  if (clearance_mm == 0) return std::move(closing.mesh);
  return offset(closing.mesh, clearance_mm, progress);
}

// Not inlined: GCC 12 leaves out the rounding of x and y where it vectorizes it.
[[gnu::noinline]] double as_float(double x) { return static_cast<float>(x); }

struct Placed {
  TriangleMesh mesh;
  int crumbs = 0;
  Eigen::Vector3d origin;  // where the middle of the cut mesh was, at the height of the cut
};

// Cuts at the height and puts the rest on the platform, turned by `turn` about the vertical axis, with the centre of
// the smallest circle around it at x = y = 0. Rounds to what mold.stl can hold, so that the mesh and the file are one
// surface. If the result is not watertight, tries a little higher.
std::optional<Placed> cut_and_place(const TriangleMesh& mesh, double height, const Eigen::Matrix3d& turn) {
  for (const double raise : {0.0, 0.01, 0.02, 0.05, 0.1, 0.2}) {
    auto cut = cut_above(mesh, height + raise);
    if (!cut || cut->triangles.empty()) continue;
    Placed placed;
    placed.crumbs = drop_crumbs(*cut);
    const Eigen::Vector2d middle = enclosing_circle(*cut).centre;
    const Eigen::Vector3d origin(middle.x(), middle.y(), height + raise);
    placed.origin = origin;
    for (auto& p : cut->vertices) {
      const Eigen::Vector3d turned = turn * (p - origin);
      p = {as_float(turned.x()), as_float(turned.y()), as_float(turned.z())};
    }
    weld(*cut, 0);
    if (!is_watertight(*cut)) continue;
    placed.mesh = std::move(*cut);
    return placed;
  }
  return std::nullopt;
}

Warning outliers_warning(const std::vector<Eigen::Vector3d>& places) {
  const std::size_t shown = std::min<std::size_t>(places.size(), 3);
  Warning warning{"outliers",
                  places.size() == 1
                      ? "A vertex lies far from the rest of the scan and was left out with its triangles"
                      : std::to_string(places.size()) +
                            " vertices lie far from the rest of the scan and were left out with their "
                            "triangles"};
  for (std::size_t i = 0; i < shown; ++i) {
    warning.place += i == 0 ? "(" : ", (";
    for (int k = 0; k < 3; ++k) warning.place += (k == 0 ? "" : ", ") + short_decimal(places[i][k]);
    warning.place += ")";
  }
  warning.place += std::string(shown < places.size() ? " and others" : "") + " in the file's coordinates";
  warning.figure = Warning::Figure{static_cast<double>(places.size()), "vertices", 0.0};
  return warning;
}

// Warns of a tilt, with the settings that straighten the scan if a mold can be made that way.
Result<Warning> tilt_warning(const Tilt& tilt, const TriangleMesh& closed, const ScanSettings& settings,
                             UpAxis up, const Eigen::Matrix3d& from_file, const ScanProgress& progress) {
  ScanSettings straight = settings;
  straight.roll_deg = tilt.roll_deg;
  straight.pitch_deg = tilt.pitch_deg;
  VACUFORM_TRY(kept,
               share_kept(closed, std::make_shared<RayCaster>(closed), straight, up, from_file, progress));
  constexpr std::array<const char*, 3> tilted{"The opening on which the scan should stand is tilted",
                                              "The flat side on which the scan should stand is tilted",
                                              "The median plane of the scan is tilted to one side"};
  Warning warning{"tilted", std::string(tilted[static_cast<std::size_t>(tilt.of)]) + " by " +
                                decimal(tilt.angle_deg, 0) + " degrees"};
  warning.figure = Warning::Figure{tilt.angle_deg, "degrees", tilt.limit_deg()};
  constexpr double least_kept_straight = 0.1;
  if (kept >= least_kept_straight) {
    warning.fix = "Leave it if only the cut is oblique. If the head is tilted, straighten it.";
    warning.proposals = {
        {{{"scan.up", name(up)}, {"scan.roll_deg", tilt.roll_deg}, {"scan.pitch_deg", tilt.pitch_deg}},
         "keeps " + decimal(100 * kept, 0) + " % of its height"}};
  }
  return warning;
}

}  // namespace

Result<Mold> make_mold(std::span<const std::uint8_t> bytes, const std::string& file_name,
                       const ScanSettings& settings, const Context& context) {
  ScanProgress progress(context);
  Mold mold;
  auto& findings = mold.findings;
  const auto warn = [&](std::string code, std::string text) {
    mold.warnings.push_back({std::move(code), std::move(text)});
  };
  VACUFORM_CHECK(progress.reach(0));

  // The outer skin, in the file's unit and axes.
  VACUFORM_TRY(scan, read_scan(bytes, file_name, progress));
  findings.format = scan.format;
  findings.triangles_read = static_cast<std::int64_t>(scan.mesh.triangles.size());
  findings.space = scan.space;
  for (const std::string& note : scan.notes) warn("file-unusual", note);
  // The format or the file may say where up and front are.
  const bool told = scan.y_up || scan.space != PatientSpace::unknown;
  const PatientAxes patient = axes_of(scan.space);
  const UpAxis told_up = scan.y_up ? UpAxis::plus_y : UpAxis::plus_z;
  VACUFORM_CHECK(progress.reach(0.1));
  weld(scan.mesh, weld_share * robust_size(scan.mesh));
  const auto outliers = drop_outliers(scan.mesh);
  findings.outliers_dropped = static_cast<int>(outliers.size());
  if (!outliers.empty()) mold.warnings.push_back(outliers_warning(outliers));
  VACUFORM_CHECK(progress.reach(0.15));
  VACUFORM_TRY(skin, outer_skin(scan.mesh, settings.body, progress));
  scan.mesh = {};
  findings.components = skin.components;
  findings.components_dropped = skin.components_dropped;
  findings.turned_inside_out = skin.turned_inside_out;
  if (skin.warning) mold.warnings.push_back(std::move(*skin.warning));
  if (skin.mesh.triangles.empty() || !(bounds(skin.mesh).size().maxCoeff() > 0))
    return fail(Code::unusable_scan, "all triangles of the scan are without area", file_name,
                "export the scan again");
  VACUFORM_CHECK(progress.reach(0.3));

  // Upright, in millimetres, standing on z = 0. The up axis comes first, because scan.size_mm is the longest side of
  // the upright scan. That side does not depend on how the scan is turned about the vertical axis.
  findings.mirrored = settings.mirror == Mirror::yes;
  findings.up = settings.up;
  const bool straight = settings.roll_deg == 0 && settings.pitch_deg == 0;
  std::optional<Tilt> tilt;
  if (settings.up == UpAxis::automatic || straight) {
    VACUFORM_TRY(guess, guess_up(skin.mesh, progress));
    if (settings.up == UpAxis::automatic) {
      findings.up = told ? told_up : guess.best().axis;
      findings.up_guessed = !told;
      if (told ? guess.conclusive() && guess.best().axis != told_up : !guess.conclusive())
        mold.warnings.push_back(up_warning(guess, findings.up, told));
    }
    if (straight) tilt = find_tilt(guess, turn_before_front(settings, findings.up));
  }
  if (skin.turned_inside_out && !skin.soup && settings.mirror == Mirror::automatic)
    warn("inside-out",
         "The triangles of the scan face inwards: either only their order is reversed, as is assumed, or the "
         "scan is a mirror image, with left and right swapped");
  TriangleMesh stood{skin.mesh.vertices, {}};
  turn(stood, upright_turn(findings.up, 0, 0, 0), 1);
  VACUFORM_TRY(size,
               choose_size(settings, file_name, bounds(skin.mesh).size().maxCoeff(), longest_side(stood)));
  stood = {};
  const double scale = size.mm_per_unit;
  findings.unit = size.unit;
  findings.unit_guessed = size.unit_guessed;
  findings.size_given = size.size_given;
  for (Warning& warning : size.warnings) mold.warnings.push_back(std::move(warning));
  ScanSettings settled = settings;  // with the front that is used
  if (settings.front == FrontSide::automatic) {
    const auto front =
        told ? side_of(settings, findings.up, scan.y_up ? Eigen::Vector3d::UnitZ() : patient.front)
             : std::nullopt;
    findings.front_from_format = front.has_value();
    findings.front_assumed = !front;
    settled.front = front.value_or(FrontSide::plus_y);
  }
  findings.front = settled.front;
  if (scan.space != PatientSpace::unknown)
    findings.left_from_file = side_of(settings, findings.up, patient.left);
  if (auto warning = contradicted_space(scan.space, settled, findings.up))
    mold.warnings.push_back(std::move(*warning));
  const Eigen::Matrix3d upright = scan_turn(settled, findings.up);
  turn(skin.mesh, Eigen::Matrix3d::Identity(), scale);
  turn(skin.mesh, upright, 1);
  const Eigen::Vector3d foot = stand_on_floor(skin.mesh);
  findings.size_mm = bounds(skin.mesh).size();
  VACUFORM_CHECK(progress.reach(0.35));

  // The next steps work along the principal axes, and the result is turned back at the end: neither the rays nor a new
  // skin then depend on how the head is turned.
  const Eigen::Matrix3d principal = principal_turn(skin.mesh);
  turn(skin.mesh, principal, 1);
  VACUFORM_TRY(closed, close(skin, settings.clearance_mm, mold, progress));
  skin = {};
  VACUFORM_CHECK(progress.reach(0.6));
  VACUFORM_TRY(smooth, without_noise(closed, enclosing_circle(closed).radius, progress));
  if (tilt) {
    VACUFORM_TRY(warning, tilt_warning(*tilt, smooth ? *smooth : closed, settled, findings.up,
                                       principal * upright, progress));
    mold.warnings.push_back(std::move(warning));
  }
  std::optional<Result<TriangleMesh>> new_skin;  // of `closed`: the same for all heights, and much work
  const auto rebuilt_of = [&](const TriangleMesh& mesh) -> Result<TriangleMesh> {
    if (&mesh != &closed) return rebuild(mesh, progress);
    if (!new_skin) new_skin = rebuild(mesh, progress);
    return *new_skin;
  };
  // Cuts as below, so that what is proposed passes.
  const CanCut can_cut = [&](const TriangleMesh& mesh, double height) {
    if (cut_and_place(mesh, height, principal.transpose())) return true;
    if (findings.rebuilt) return false;
    const auto rebuilt = rebuilt_of(mesh);
    return rebuilt && cut_and_place(*rebuilt, height, principal.transpose());
  };
  VACUFORM_TRY(trim, choose_trim(closed, smooth, settled, findings, principal * upright, file_name, can_cut,
                                 progress));
  findings.trim_mm = trim.height_mm;
  findings.trim_chosen = !settings.trim_mm;
  VACUFORM_CHECK(progress.reach(0.9));
  auto placed = cut_and_place(closed, trim.height_mm, principal.transpose());
  if (!placed && !findings.rebuilt) {  // the surface crosses itself at the cut
    VACUFORM_TRY(rebuilt, rebuilt_of(closed));
    placed = cut_and_place(rebuilt, trim.height_mm, principal.transpose());
    findings.rebuilt = placed.has_value();  // otherwise other heights are tried with it below
  }
  if (!placed) {
    std::vector<Proposal> proposals;
    const double top = bounds(closed).high.z();
    for (double height = std::ceil(trim.height_mm + 1); height < 0.9 * top && proposals.empty();
         height += std::ceil(0.1 * top))
      if (can_cut(closed, height)) proposals.push_back({{{"scan.trim_mm", height}}, ""});
    return fail(Code::unusable_scan, "no watertight mold can be made of the scan", file_name,
                proposals.empty() ? "" : "give another scan.trim_mm", std::move(proposals),
                "repair it in a mesh editor (close its holes, remove inner parts)");
  }
  if (findings.rebuilt)
    mold.warnings.push_back(
        {"rebuilt",
         "The scan's surface could not be closed as it is and was replaced by a new one, up to 0.2 mm "
         "outside of it",
         {},
         Warning::Figure{0.2, "mm"}});

  mold.mesh = std::move(placed->mesh);
  mold.top = top_of(mold.mesh);
  const Eigen::Matrix3d axes = scale * upright;
  mold.placing = {axes.col(0), axes.col(1), axes.col(2), -foot - principal.transpose() * placed->origin};
  findings.crumbs_dropped = placed->crumbs;
  const auto in_mold = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return principal.transpose() * (p - Eigen::Vector3d(placed->origin.x(), placed->origin.y(), 0));
  };
  if (trim.warning) {
    for (auto& mark : trim.warning->marks)
      Eigen::Map<Eigen::Vector3d>(mark.place_mm.data()) =
          in_mold(Eigen::Vector3d(mark.place_mm[0], mark.place_mm[1], mark.place_mm[2]));
    mold.warnings.push_back(std::move(*trim.warning));
  }
  for (Undercut& undercut : trim.undercuts) undercut.place = in_mold(undercut.place);
  mold.undercuts = std::move(trim.undercuts);
  if (!mold.undercuts.empty()) mold.warnings.push_back(undercut_warning(mold.undercuts));
  VACUFORM_CHECK(progress.reach(1));
  return mold;
}

}  // namespace vacuform
