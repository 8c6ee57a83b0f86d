#include "worker/studies/calibration.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "worker/forming/formed_sheet.hpp"
#include "worker/forming/sheet_map.hpp"
#include "worker/scan/topology.hpp"
#include "worker/portion.hpp"
#include "worker/studies/registration.hpp"

namespace vacuform {

namespace {

using Json = nlohmann::ordered_json;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double huber = 1.5;  // times the noise: beyond, a distance counts linearly
constexpr int coarse_rounds = 6, fine_rounds = 10;
constexpr double least_cells = 40;  // across the window: a coarser grid leads astray
constexpr double still = 0.02;      // of a parameter's step of differences: smaller changes end the search
constexpr std::size_t least_points = 10;

// One parameter: where it is in the settings, how far it may go, and the step of its differences.
struct Parameter {
  std::string group, key;
  double& (*in)(Settings&);
  double low, high, step;
};

std::vector<Parameter> parameters_of(const Prepared& prepared, Settings settings) {
  std::vector<Parameter> out;
  const auto opening = [&](const char* key, double& (*in)(Settings&), double sheet) {
    const double given = in(settings);
    out.push_back({"machine", key, in, 0.9 * given, std::min(1.1 * given, sheet), 6.0});
  };
  out.push_back({"machine", "drape_height_mm",
                 [](Settings& s) -> double& { return s.machine.drape_height_mm; }, 0,
                 std::max(1.0, prepared.mold.top.z() - 1), 4.0});
  const bool circle = settings.machine.window == WindowShape::circle;
  opening(
      "window_width_mm", [](Settings& s) -> double& { return s.machine.window_width_mm; },
      circle ? std::min(settings.sheet.width_mm, settings.sheet.height_mm) : settings.sheet.width_mm);
  if (!circle)
    opening(
        "window_height_mm", [](Settings& s) -> double& { return s.machine.window_height_mm; },
        settings.sheet.height_mm);
  out.push_back({"forming", "edge_stiffness", [](Settings& s) -> double& { return s.forming.edge_stiffness; },
                 0.2, 5, 0.2});
  return out;
}

// Where a forming puts the measured points, and their distances from there.
struct Fit {
  std::vector<Eigen::Vector3d> measured, formed;
  VectorXd distances;  // x, y, z of every point, mm
  std::vector<double> lengths, weights;
  double cost = HUGE_VAL;  // Huber's
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

class Search {
 public:
  Search(const Prepared& prepared, const Settings& settings, const std::vector<MeasuredPoint3>& points,
         const CalibrationOptions& options, const Context& context)
      : prepared_(prepared),
        settings_(settings),
        points_(points),
        options_(options),
        context_(context),
        parameters_(parameters_of(prepared, settings)) {}

  Result<Calibration> run() {
    const auto n = static_cast<Eigen::Index>(parameters_.size());
    VectorXd x(n);
    Settings start = settings_;
    for (Eigen::Index k = 0; k < n; ++k) x[k] = parameter(k).in(start);
    const double asked = settings_.sheet.resolution_mm;

    Calibration out;
    VACUFORM_TRY(given, fit_at(x, asked));
    out.before = statistics_of(given.lengths);
    const double coarse = std::min(2 * asked, settings_.machine.window_width_mm / least_cells);
    const bool worth_it = coarse > 1.5 * asked;
    if (worth_it) VACUFORM_CHECK(descend(x, coarse, coarse_rounds, 0.1, 0.05, 0.5, out));
    VACUFORM_CHECK(descend(x, asked, fine_rounds, worth_it ? 1e-3 : 0.1, worth_it ? 0.5 : 0.05, 1, out));

    out.after = statistics_of(best_.lengths);
    out.motion = best_.motion;
    out.outliers = static_cast<int>(
        std::count_if(best_.weights.begin(), best_.weights.end(), [](double w) { return w < 0.5; }));
    out.settings = settings_at(x);
    out.formings = formings_;
    report(x, out);
    return out;
  }

 private:
  const Parameter& parameter(Eigen::Index k) const { return parameters_[static_cast<std::size_t>(k)]; }

  Settings settings_at(const VectorXd& x) const {
    Settings s = settings_;
    for (Eigen::Index k = 0; k < x.size(); ++k) parameter(k).in(s) = x[k];
    return s;
  }

  // The spacing at which the window holds as many cells as the given one does: a cell more or less would move the
  // sheet by as much as a millimetre of window.
  double even_resolution(const MachineSettings& machine, double resolution_mm) const {
    const auto spacing = [&](double now, double given) {
      return now / 2 / std::ceil(given / 2 / resolution_mm - 1e-9) * (1 + 1e-12);
    };
    const double across = spacing(machine.window_width_mm, settings_.machine.window_width_mm);
    if (machine.window == WindowShape::circle) return across;
    return std::max(across, spacing(machine.window_height_mm, settings_.machine.window_height_mm));
  }

  // What a forming with the parameters says.
  Result<Fit> fit_at(const VectorXd& x, double resolution_mm) {
    Settings s = settings_at(x);
    s.sheet.resolution_mm = even_resolution(s.machine, resolution_mm);
    ++formings_;
    VACUFORM_CHECK(context_.step(Stage::forming, done_));
    const Portion portion(context_, Stage::forming, done_, done_);
    VACUFORM_TRY(
        sheet, form(prepared_.mold, s.sheet, s.machine, s.forming, prepared_.temperature, portion.context()));
    const SheetMap map(sheet);
    Fit fit;
    for (const MeasuredPoint3& point : points_)
      if (const auto there = map(point.rest))
        fit.measured.push_back(point.place), fit.formed.push_back(*there);
    if (fit.measured.size() < least_points)
      return fail(Code::unusable_surface, "fewer than ten measured points lie on the sheet", "--measured",
                  "check sheet.width_mm and sheet.height_mm");
    fit.weights.assign(fit.measured.size(), 1);
    weigh(fit);
    return fit;
  }

  // The motion, the weights by the noise (where that is not known yet, by this fit's own), and the cost.
  void weigh(Fit& fit) const {
    const std::size_t n = fit.measured.size();
    for (int round = 0; round < 10; ++round) {  // the motion and the weights hang on each other
      if (!options_.registered) fit.motion = rigid_motion(fit.measured, fit.formed, fit.weights);
      fit.lengths.clear();
      for (std::size_t i = 0; i < n; ++i)
        fit.lengths.push_back((fit.motion * fit.measured[i] - fit.formed[i]).norm());
      const double beyond = huber * (noise_ > 0 ? noise_ : std::max(1e-6, median(fit.lengths)));
      for (std::size_t i = 0; i < n; ++i)
        fit.weights[i] = fit.lengths[i] <= beyond ? 1 : beyond / fit.lengths[i];
    }
    fit.distances.resize(3 * static_cast<Eigen::Index>(n));
    fit.cost = 0;
    for (std::size_t i = 0; i < n; ++i) {
      fit.distances.segment<3>(3 * static_cast<Eigen::Index>(i)) =
          fit.motion * fit.measured[i] - fit.formed[i];
      // r^2 within, and with w = k / r beyond, 2 k r - k^2.
      fit.cost += fit.weights[i] * (2 - fit.weights[i]) * fit.lengths[i] * fit.lengths[i];
    }
  }

  // Levenberg and Marquardt on one grid; moves x, and leaves best_, jacobian_ there.
  Result<void> descend(VectorXd& x, double resolution_mm, int rounds, double damping, double from, double to,
                       Calibration& out) {
    const Eigen::Index n = x.size();
    noise_ = 0;
    done_ = from;
    VACUFORM_TRY(first, fit_at(x, resolution_mm));
    best_ = std::move(first);
    out.converged = false;
    for (int round = 0; round < rounds && !out.converged; ++round) {
      noise_ = std::max(1e-6, median(best_.lengths));
      weigh(best_);
      done_ = from + (to - from) * round / rounds;
      VACUFORM_CHECK(differentiate(x, resolution_mm));
      ++out.iterations;
      bool better = false;
      for (int attempt = 0; attempt < 5 && !better; ++attempt) {
        const VectorXd y = step(x, damping);
        double furthest = 0;
        for (Eigen::Index k = 0; k < n; ++k)
          furthest = std::max(furthest, std::abs(y[k] - x[k]) / parameter(k).step);
        if (furthest < still) {
          out.converged = true;
          break;
        }
        VACUFORM_TRY(there, fit_at(y, resolution_mm));
        better = there.cost < best_.cost;
        if (better) x = y, best_ = std::move(there);
        damping = better ? damping / 10 : damping * 10;
      }
      // No step helps any more: what is left is the roughness of the grid.
      if (!better) out.converged = true;
    }
    done_ = to;
    return {};
  }

  // Derivatives of the distances by each parameter, towards the inside of its bounds.
  Result<void> differentiate(const VectorXd& x, double resolution_mm) {
    jacobian_.resize(best_.distances.size(), x.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      VectorXd y = x;
      y[k] += x[k] + parameter(k).step <= parameter(k).high ? parameter(k).step : -parameter(k).step;
      VACUFORM_TRY(there, fit_at(y, resolution_mm));
      jacobian_.col(k) = (there.distances - best_.distances) / (y[k] - x[k]);
    }
    return {};
  }

  MatrixXd weighted_normal() const {
    MatrixXd weighted = jacobian_;
    for (std::size_t i = 0; i < best_.weights.size(); ++i)
      weighted.middleRows(3 * static_cast<Eigen::Index>(i), 3) *= best_.weights[i];
    return jacobian_.transpose() * weighted;
  }

  // Parameters in units of their steps, so that the damping treats millimetres and ratios alike; those that a bound
  // holds back stay there.
  VectorXd step(const VectorXd& x, double damping) const {
    const Eigen::Index n = x.size();
    VectorXd weighted = best_.distances, scale(n);
    for (std::size_t i = 0; i < best_.weights.size(); ++i)
      weighted.segment<3>(3 * static_cast<Eigen::Index>(i)) *= best_.weights[i];
    for (Eigen::Index k = 0; k < n; ++k) scale[k] = parameter(k).step;
    MatrixXd A = scale.asDiagonal() * weighted_normal() * scale.asDiagonal();
    VectorXd b = -(scale.asDiagonal() * (jacobian_.transpose() * weighted));
    const double mean = A.trace() / static_cast<double>(n);
    A.diagonal() += damping * (A.diagonal() + VectorXd::Constant(n, 1e-3 * mean));
    VectorXd y = x;
    std::vector<char> fixed(static_cast<std::size_t>(n), 0);
    for (Eigen::Index round = 0; round < n; ++round) {
      const VectorXd move = scale.asDiagonal() * A.ldlt().solve(b);
      bool stopped = false;
      for (Eigen::Index k = 0; k < n; ++k) {
        if (fixed[static_cast<std::size_t>(k)]) continue;
        y[k] = std::clamp(x[k] + move[k], parameter(k).low, parameter(k).high);
        if (y[k] != x[k] || move[k] == 0) continue;
        fixed[static_cast<std::size_t>(k)] = 1;  // it pushes against its bound: solved again without it
        A.row(k).setZero(), A.col(k).setZero(), A(k, k) = 1, b[k] = 0;
        stopped = true;
      }
      if (!stopped) break;
    }
    return y;
  }

  void report(const VectorXd& x, Calibration& out) const {
    const double freedom = static_cast<double>(best_.distances.size()) - static_cast<double>(x.size()) -
                           (options_.registered ? 0 : 6);
    double sum = 0;
    for (std::size_t i = 0; i < best_.weights.size(); ++i)
      sum += best_.weights[i] * best_.lengths[i] * best_.lengths[i];
    const double variance = sum / std::max(1.0, freedom);
    const MatrixXd covariance =
        weighted_normal().ldlt().solve(MatrixXd::Identity(x.size(), x.size())) * variance;
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const Parameter& p = parameter(k);
      const double error = covariance(k, k) > 0 ? std::sqrt(covariance(k, k)) : HUGE_VAL;
      const bool at_bound = x[k] <= p.low || x[k] >= p.high;
      out.parameters.push_back({p.group, p.key, x[k], error, at_bound});
    }
  }

  const Prepared& prepared_;
  const Settings& settings_;
  const std::vector<MeasuredPoint3>& points_;
  const CalibrationOptions options_;
  const Context& context_;
  std::vector<Parameter> parameters_;
  double noise_ = 0, done_ = 0;
  int formings_ = 0;
  Fit best_;
  MatrixXd jacobian_;
};

Json finite(double value, int places) {
  if (!std::isfinite(value)) return nullptr;
  const double scale = std::pow(10.0, places);
  return std::round(value * scale) / scale + 0.0;
}

}  // namespace

Result<Calibration> calibrate(const Prepared& prepared, const Settings& settings,
                              const std::vector<MeasuredPoint3>& points, const CalibrationOptions& options,
                              const Context& context) {
  return Search(prepared, settings, points, options, context).run();
}

Json profile_json(const Calibration& c, const nlohmann::json& given) {
  Json out;
  for (const char* group : {"machine", "forming"})
    if (given.contains(group)) out[group] = given[group];
  Json fitted = Json::object();
  for (const FittedParameter& p : c.parameters) {
    out[p.group][p.key] = finite(p.value, 3);
    fitted[p.group + "." + p.key] = {{"value", finite(p.value, 3)},
                                     {"standard_error", finite(p.standard_error, 3)},
                                     {"at_bound", p.at_bound}};
  }
  Json motion = Json::array();
  for (int row = 0; row < 4; ++row) {
    Json line = Json::array();
    for (int column = 0; column < 4; ++column) line.push_back(finite(c.motion.matrix()(row, column), 6));
    motion.push_back(std::move(line));
  }
  out["calibration"] = {{"parameters", std::move(fitted)},
                        {"residual_mm", json_of(c.after)},
                        {"residual_before_mm", json_of(c.before)},
                        {"outliers", c.outliers},
                        {"converged", c.converged},
                        {"iterations", c.iterations},
                        {"formings", c.formings},
                        {"measured_to_machine", std::move(motion)}};
  return out;
}

}  // namespace vacuform
