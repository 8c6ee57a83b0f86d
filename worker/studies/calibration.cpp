#include "worker/studies/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "api/base/decimal.hpp"
#include "worker/forming/formed_sheet.hpp"
#include "worker/numerics/dense.hpp"
#include "worker/stage/sub_progress.hpp"
#include "worker/studies/bayesian_fit.hpp"
#include "worker/studies/inked_places.hpp"

namespace vacuform {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int most_rounds = 4;      // on each of the two grids
constexpr double inside = 0.75;     // half widths: nearer to the centre, a minimum is well inside
constexpr double least_cells = 40;  // across the window: a coarser grid misleads
constexpr double finest_mm = 0.5;   // of any grid
constexpr double least_known = 0.01, hardly_known = 4;  // information of the points over that of the prior
constexpr double strong = 0.8;                          // a correlation that is named
constexpr double large_share = 0.3;

// One parameter: its setting, its limits, the half width of its design and the error of its prior. The last four are of
// the logarithm if the parameter is logarithmic.
struct Parameter {
  std::string name;
  double& (*in)(Settings&);
  bool logarithmic;
  double low, high, half_width, prior_error;

  double coordinate(double value) const { return logarithmic ? std::log(value) : value; }
  double value(double t) const { return logarithmic ? std::exp(t) : t; }
};

std::vector<Parameter> parameters_of(const Prepared& prepared, Settings settings) {
  std::vector<Parameter> out;
  const auto opening = [&](const char* name, double& (*in)(Settings&), double sheet) {
    const double given = in(settings);
    out.push_back({name, in, false, 0.9 * given, std::min(1.1 * given, sheet), 10, 5});
  };
  out.push_back({"machine.drape_height_mm", [](Settings& s) -> double& { return s.machine.drape_height_mm; },
                 false, 0, std::max(1.0, prepared.mold.top.z() - 1), 5, 10});
  const bool circle = settings.machine.window == WindowShape::circle;
  opening(
      "machine.window_width_mm", [](Settings& s) -> double& { return s.machine.window_width_mm; },
      circle ? std::min(settings.sheet.width_mm, settings.sheet.height_mm) : settings.sheet.width_mm);
  if (!circle)
    opening(
        "machine.window_height_mm", [](Settings& s) -> double& { return s.machine.window_height_mm; },
        settings.sheet.height_mm);
  out.push_back({"forming.edge_stiffness", [](Settings& s) -> double& { return s.forming.edge_stiffness; },
                 true, std::log(0.2), std::log(5), 0.2, 0.3});
  return out;
}

class Search {
 public:
  Search(const Prepared& prepared, const Settings& settings, const std::vector<MeasuredPoint3>& points,
         const CalibrationOptions& options, const Context& context)
      : prepared_(prepared),
        settings_(settings),
        context_(context),
        parameters_(parameters_of(prepared, settings)) {
    problem_.registered = options.registered;
    for (const MeasuredPoint3& point : points)
      rest_.push_back(point.rest), problem_.measured.push_back(point.place);
    const auto n = static_cast<Index>(parameters_.size());
    for (VectorXd* v : {&problem_.low, &problem_.high, &problem_.half_width, &problem_.prior_mean,
                        &problem_.prior_sd, &problem_.centre})
      v->resize(n);
    Settings given = settings;
    for (Index k = 0; k < n; ++k) {
      const Parameter& p = parameter(k);
      problem_.low[k] = p.low, problem_.high[k] = p.high;
      problem_.prior_mean[k] = std::clamp(p.coordinate(p.in(given)), p.low, p.high);
      const auto other = options.prior_errors.find(p.name);
      problem_.prior_sd[k] = other == options.prior_errors.end() ? p.prior_error : other->second;
    }
  }

  Result<void> check_priors(const CalibrationOptions& options) const {
    for (const auto& [name, error] : options.prior_errors) {
      const bool known = std::any_of(parameters_.begin(), parameters_.end(),
                                     [&, &wanted = name](const Parameter& p) { return p.name == wanted; });
      std::string names;
      for (const Parameter& p : parameters_) names += (names.empty() ? "" : ", ") + p.name;
      if (!known) return fail(Code::bad_settings, "no such parameter to fit", name, "give one of " + names);
      if (!(error > 0) || !std::isfinite(error))
        return fail(Code::bad_settings, "the standard deviation of a prior must be positive", name,
                    "give a number above 0");
    }
    return {};
  }

  Result<Calibration> run() {
    Calibration out;
    const double asked = settings_.sheet.resolution_mm;
    VACUFORM_TRY(before, distances(settings_));
    out.before = statistics_of(before.lengths);
    const double coarse = std::min(2 * asked, settings_.machine.window_width_mm / least_cells);
    VectorXd t = problem_.prior_mean;
    if (coarse > 1.2 * asked) VACUFORM_CHECK(search(t, coarse, 1.5, 0.05, 0.25, out));
    VACUFORM_CHECK(search(t, asked, 1, 0.25, 0.95, out));

    out.settings = settings_at(t);
    VACUFORM_TRY(after, distances(out.settings));
    out.after = statistics_of(after.lengths);
    out.outliers = static_cast<int>(
        std::count_if(fit_.weights.begin(), fit_.weights.end(), [](double w) { return w < 0.5; }));
    out.formings = formings_;
    out.noise_mm = fit_.noise_mm, out.motion = fit_.motion;
    report(out);
    return out;
  }

 private:
  const Parameter& parameter(Index k) const { return parameters_[k]; }

  Settings settings_at(const VectorXd& t) const {
    Settings s = settings_;
    for (Index k = 0; k < t.size(); ++k) parameter(k).in(s) = parameter(k).value(t[k]);
    return s;
  }

  Result<VectorXd> places(const Settings& s) {
    ++formings_;
    VACUFORM_CHECK(context_.step(Stage::forming, done_));
    const SubProgress portion(context_, {Stage::forming, done_, done_});
    FormingSettings forming = s.forming;
    forming.quality = FormingQuality::standard;  // the grids are chosen here
    VACUFORM_TRY(sheet,
                 form(prepared_.mold, s.sheet, s.machine, forming, prepared_.temperature, portion.context()));
    VectorXd found = inked_places(sheet, s.pattern.inked_face, rest_);
    if (!found.allFinite())
      return fail(Code::unusable_surface, "a measured point lies off the sheet", "--measured",
                  "check sheet.width_mm and sheet.height_mm");
    return found;
  }

  Result<Laid> distances(const Settings& s) {
    VACUFORM_TRY(formed, places(s));
    return lay_points(problem_, formed);
  }

  // The spacing at which the window holds as many cells as it does at the design's centre. One cell more or less would
  // move the sheet by as much as a millimetre of window does.
  double even_spacing(const MachineSettings& now, const MachineSettings& centre, double spacing_mm) const {
    const auto even = [&](double is, double was) {
      return is / 2 / std::ceil(was / 2 / spacing_mm - 1e-9) * (1 + 1e-12);
    };
    const double across = even(now.window_width_mm, centre.window_width_mm);
    if (now.window == WindowShape::circle) return across;
    return std::max(across, even(now.window_height_mm, centre.window_height_mm));
  }

  // Fits designs around the best values until the minimum lies well inside one. Moves t; leaves fit_ and the last
  // problem_.
  Result<void> search(VectorXd& t, double spacing_mm, double width, double from, double to,
                      Calibration& out) {
    out.converged = false;
    for (int round = 0; round < most_rounds && !out.converged; ++round, ++out.rounds) {
      for (Index k = 0; k < t.size(); ++k) {
        const Parameter& p = parameter(k);
        problem_.half_width[k] = std::min(width * p.half_width, (p.high - p.low) / 2);
        problem_.centre[k] =
            std::clamp(t[k], p.low + problem_.half_width[k], p.high - problem_.half_width[k]);
      }
      auto design = central_composite(static_cast<int>(t.size()));
      const Settings centre = settings_at(problem_.centre);
      MatrixXd outputs(static_cast<Index>(design.size()), 3 * static_cast<Index>(rest_.size()));
      for (std::size_t i = 0; i < design.size(); ++i) {
        done_ = from + (to - from) * (round + static_cast<double>(i) / static_cast<double>(design.size())) /
                           most_rounds;
        Settings s = settings_at(problem_.centre + problem_.half_width.cwiseProduct(design[i].u));
        const double coarsest = std::max(1.3 * spacing_mm, centre.machine.window_width_mm / least_cells);
        s.sheet.resolution_mm =
            even_spacing(s.machine, centre.machine,
                         std::clamp(design[i].spacing * spacing_mm, std::min(finest_mm, coarsest), coarsest));
        design[i].spacing = s.sheet.resolution_mm / spacing_mm;
        VACUFORM_TRY(formed, places(s));
        outputs.row(static_cast<Index>(i)) = formed.transpose();
      }
      const ResponseSurface surface(design, outputs);
      fit_ = bayesian_fit(problem_, surface);
      t = fit_.t;
      out.model_error_mm = std::sqrt(surface.errors().squaredNorm() / static_cast<double>(outputs.cols()));
      out.converged = fit_.converged;
      for (Index k = 0; k < t.size(); ++k) {
        const double off = std::abs(t[k] - problem_.centre[k]) / problem_.half_width[k];
        const bool at_end = problem_.centre[k] - problem_.half_width[k] <= parameter(k).low + 1e-9
                                ? t[k] < problem_.centre[k]
                                : problem_.centre[k] + problem_.half_width[k] >= parameter(k).high - 1e-9 &&
                                      t[k] > problem_.centre[k];
        if (off > inside && !at_end) out.converged = false;
      }
    }
    done_ = to;
    return {};
  }

  void report(Calibration& out) const {
    const Index n = fit_.t.size();
    const auto scale = problem_.prior_sd.asDiagonal();
    const SymmetricEigen eigen = symmetric_eigen(scale * fit_.information * scale);
    const VectorXd known = eigen.values.cwiseMax(0);
    for (Index k = 0; k < n; ++k) {
      const Parameter& p = parameter(k);
      const double unit = p.logarithmic ? p.value(fit_.t[k]) : 1, error = std::sqrt(fit_.covariance(k, k));
      const double reach = interval_95(fit_.freedom[k]) * error;
      double alone = 0;
      for (Index e = 0; e < n; ++e) {
        const double share = std::pow(eigen.vectors(k, e), 2);
        alone += known[e] > 0 ? share / known[e] : share > 1e-12 ? HUGE_VAL : 0;
      }
      FittedParameter f;
      f.name = p.name, f.logarithmic = p.logarithmic;
      f.value = p.value(fit_.t[k]), f.standard_error = unit * error;
      f.points_error = alone * least_known > 1 ? HUGE_VAL : unit * problem_.prior_sd[k] * std::sqrt(alone);
      f.low95 = p.value(std::max(p.low, fit_.t[k] - reach)), f.high95 = p.value(fit_.t[k] + reach);
      f.prior = p.value(problem_.prior_mean[k]), f.prior_error = problem_.prior_sd[k];
      f.at_bound = fit_.t[k] <= p.low || fit_.t[k] >= p.high;
      out.parameters.push_back(std::move(f));
    }
    const VectorXd errors = fit_.covariance.diagonal().cwiseSqrt();
    out.correlation =
        errors.cwiseInverse().asDiagonal() * fit_.covariance * errors.cwiseInverse().asDiagonal();
    for (Index e = 0; e < n && known[e] < hardly_known; ++e)
      out.unresolved.push_back(unresolved(eigen.vectors.col(e), known[e]));
    for (Index i = 0; i < n; ++i)
      for (Index k = i + 1; k < n; ++k)
        if (const double c = out.correlation(i, k); std::abs(c) > strong)
          out.trade_offs.push_back(parameter(i).name + " and " + parameter(k).name +
                                   " trade off (correlation " + decimal(c, 2) +
                                   "): the points determine their combination better than either");
  }

  Unresolved unresolved(const VectorXd& direction, double known) const {
    Unresolved out;
    out.points_to_prior = known > 0 ? 1 / std::sqrt(known) : HUGE_VAL;
    std::vector<std::string> names;
    for (Index k = 0; k < direction.size(); ++k) {
      out.share.push_back(direction[k]);
      if (std::abs(direction[k]) >= large_share) names.push_back(parameter(k).name);
    }
    std::string list;
    for (std::size_t i = 0; i < names.size(); ++i)
      list += (i == 0 ? "" : i + 1 < names.size() ? ", " : " and ") + names[i];
    const std::string held = known < 1 ? "the prior determines it" : "the prior helps to determine it";
    out.text = names.size() == 1 ? "the points hardly determine " + list + ": " + held
                                 : list + " trade off: the points determine only their combination, and " +
                                       (known < 1 ? "the prior determines the rest"
                                                  : "the prior helps to determine the rest");
    return out;
  }

  const Prepared& prepared_;
  const Settings& settings_;
  const Context& context_;
  std::vector<Parameter> parameters_;
  std::vector<Eigen::Vector2d> rest_;
  FitProblem problem_;
  BayesianFit fit_;
  double done_ = 0;
  int formings_ = 0;
};

}  // namespace

Result<Calibration> calibrate(const Prepared& prepared, const Settings& settings,
                              const std::vector<MeasuredPoint3>& points, const CalibrationOptions& options,
                              const Context& context) {
  Search search(prepared, settings, points, options, context);
  VACUFORM_CHECK(search.check_priors(options));
  return search.run();
}

}  // namespace vacuform
