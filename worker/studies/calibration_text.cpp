// The results of a calibration, for programs and for people.
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"
#include "worker/studies/calibration.hpp"

namespace vacuform {

namespace {

using Json = nlohmann::ordered_json;

Json finite(double value, int places) {
  if (!std::isfinite(value)) return nullptr;
  const double scale = std::pow(10.0, places);
  return std::round(value * scale) / scale + 0.0;
}

Json rows_of(const Eigen::MatrixXd& matrix, int places) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) row.push_back(finite(matrix(i, k), places));
    rows.push_back(std::move(row));
  }
  return rows;
}

Json json_of(const FittedParameter& p) {
  return {{"value", finite(p.value, 3)},
          {"standard_error", finite(p.standard_error, 3)},
          {"standard_error_by_points_alone", finite(p.points_error, 3)},
          {"interval_95", {finite(p.low95, 3), finite(p.high95, 3)}},
          {"prior",
           {{"value", finite(p.prior, 3)},
            {"standard_deviation", finite(p.prior_error, 4)},
            {"distribution", p.logarithmic ? "log-normal" : "normal"}}},
          {"at_bound", p.at_bound}};
}

std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.insert(0, width - text.size(), ' ');
  return text;
}

std::string titled(const std::string& title) {
  return title + std::string(title.size() < 28 ? 28 - title.size() : 1, ' ');
}

std::string line_of(const char* title, const DistanceStatistics& s) {
  return titled(title) + "RMS " + decimal(s.rms, 3) + " mm, mean " + decimal(s.mean, 3) + ", 95 % below " +
         decimal(s.p95, 3) + ", largest " + decimal(s.max, 3) + ", of " + std::to_string(s.count) +
         " points\n";
}

}  // namespace

Json profile_json(const Calibration& c, const nlohmann::json& given) {
  Json out;
  for (const char* group : {"machine", "forming"})
    if (given.contains(group)) out[group] = given[group];
  Json fitted = Json::object(), names = Json::array(), unresolved = Json::array();
  for (const FittedParameter& p : c.parameters) {
    const auto dot = p.name.find('.');
    out[p.name.substr(0, dot)][p.name.substr(dot + 1)] = finite(p.value, 3);
    fitted[p.name] = json_of(p);
    names.push_back(p.name);
  }
  for (const Unresolved& u : c.unresolved) {
    Json share = Json::object();
    for (std::size_t k = 0; k < u.share.size(); ++k) share[c.parameters[k].name] = finite(u.share[k], 3);
    unresolved.push_back({{"text", u.text},
                          {"share", std::move(share)},
                          {"points_to_prior_error", finite(u.points_to_prior, 3)}});
  }
  out["calibration"] = {
      {"parameters", std::move(fitted)},
      {"correlation", {{"parameters", std::move(names)}, {"matrix", rows_of(c.correlation, 3)}}},
      {"unresolved", std::move(unresolved)},
      {"trade_offs", c.trade_offs},
      {"noise_mm", finite(c.noise_mm, 4)},
      {"model_error_mm", finite(c.model_error_mm, 4)},
      {"residual_mm", json_of(c.after)},
      {"residual_before_mm", json_of(c.before)},
      {"outliers", c.outliers},
      {"converged", c.converged},
      {"rounds", c.rounds},
      {"formings", c.formings},
      {"measured_to_machine", rows_of(c.motion.matrix(), 6)}};
  return out;
}

std::string text_of(const Calibration& c) {
  std::string out = titled("parameter") + "    value  std. error  points alone     95 % interval     prior\n";
  for (const FittedParameter& p : c.parameters) {
    out += titled(p.name) + padded(decimal(p.value, 2), 9) +
           padded("+- " + decimal(p.standard_error, 2), 12) +
           padded(std::isfinite(p.points_error) ? "+- " + decimal(p.points_error, 2) : "unknown", 14) +
           padded(decimal(p.low95, 2) + " to " + decimal(p.high95, 2), 18) + "     " + decimal(p.prior, 2) +
           (p.logarithmic ? " times or divided by " + decimal(std::exp(p.prior_error), 2)
                          : " +- " + decimal(p.prior_error, 2)) +
           (p.at_bound ? ", at the end of the searched range" : "") + "\n";
  }
  out += "correlation of the errors\n";
  for (std::size_t i = 0; i < c.parameters.size(); ++i) {
    out += titled("  " + c.parameters[i].name);
    for (std::size_t k = 0; k <= i; ++k)
      out += padded(decimal(c.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)), 2), 9);
    out += "\n";
  }
  for (const Unresolved& u : c.unresolved) out += titled("not told apart") + u.text + "\n";
  for (const std::string& text : c.trade_offs) out += titled("correlated") + text + "\n";
  out += line_of("residual before", c.before) + line_of("residual", c.after);
  out += titled("noise of a coordinate") + decimal(c.noise_mm, 3) + " mm, estimated from the residual\n";
  out += titled("error of the simulation") + decimal(c.model_error_mm, 3) +
         " mm, from formings on different grids; included in the standard errors\n";
  if (c.outliers > 0) out += titled("wild points") + std::to_string(c.outliers) + ", which hardly count\n";
  if (!c.converged) out += titled("not converged") + "the minimum lies outside the searched region\n";
  return out;
}

}  // namespace vacuform
