// The curve of the inks from measured patches.
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"
#include "worker/studies/ink_chart.hpp"

namespace vacuform {

namespace {

constexpr std::size_t least_coverages = 3;
constexpr double least_full = 0.05, most_ink = 4;  // as print.ink_curve takes them

struct InkSample {
  double area_ratio, shown;
};

double cost_of(const std::vector<InkSample>& samples, double ink) {
  double sum = 0;
  for (const InkSample& s : samples) {
    const double d = s.shown - std::min(1.0, ink / s.area_ratio);
    sum += d * d;
  }
  return sum;
}

// The ink that explains the samples of one coverage best. Between two area ratios in a row the same samples are
// saturated, so that the cost is a parabola there.
double best_ink(std::vector<InkSample> samples) {
  std::sort(samples.begin(), samples.end(), [](const InkSample& a, const InkSample& b) {
    return a.area_ratio != b.area_ratio ? a.area_ratio < b.area_ratio : a.shown < b.shown;
  });
  double best = 0, least = INFINITY;
  for (std::size_t first = 0; first < samples.size(); ++first) {
    double sum = 0, weight = 0;
    for (std::size_t i = first; i < samples.size(); ++i) {
      sum += samples[i].shown / samples[i].area_ratio;
      weight += 1 / (samples[i].area_ratio * samples[i].area_ratio);
    }
    const double low = first == 0 ? 0 : samples[first - 1].area_ratio, high = samples[first].area_ratio;
    const double ink = std::clamp(sum / weight, low, high), cost = cost_of(samples, ink);
    if (cost < least) least = cost, best = ink;
  }
  return std::min(best, most_ink);
}

// Pools neighbours that fall until none does (pool adjacent violators).
std::vector<double> rising(const std::vector<std::vector<InkSample>>& of_coverage) {
  struct Block {
    std::vector<InkSample> samples;
    double ink;
    std::size_t count;
  };
  std::vector<Block> blocks;
  for (const auto& samples : of_coverage) {
    blocks.push_back({samples, best_ink(samples), 1});
    while (blocks.size() > 1 && blocks.back().ink < blocks[blocks.size() - 2].ink) {
      Block last = std::move(blocks.back());
      blocks.pop_back();
      Block& into = blocks.back();
      into.samples.insert(into.samples.end(), last.samples.begin(), last.samples.end());
      into.count += last.count;
      into.ink = best_ink(into.samples);
    }
  }
  std::vector<double> out;
  for (const Block& block : blocks) out.insert(out.end(), block.count, block.ink);
  return out;
}

double to_thousandths(double value) { return std::round(value * 1000) / 1000; }

double shown_by(const InkCurve& curve, const InkPatch& patch) {
  const double ink =
      static_cast<double>(curve.ink(static_cast<std::size_t>(patch.ink), static_cast<float>(patch.coverage)));
  return std::min(1.0, ink / patch.area_ratio);
}

struct InkResidual {
  double sum = 0;
  int count = 0;
  void add(double d) { sum += d * d, ++count; }
  double rms() const { return count > 0 ? std::sqrt(sum / count) : 0; }
};

}  // namespace

Result<InkFit> fit_ink_curve(const std::vector<InkPatch>& patches, const std::vector<MeasuredInk>& measured,
                             const std::string& file_name) {
  const auto refuse = [&](std::string what, std::string fix) {
    return fail(Code::corrupt_file, std::move(what), file_name, std::move(fix));
  };
  std::array<std::map<double, std::vector<InkSample>>, 3> samples;
  for (const MeasuredInk& m : measured) {
    const InkPatch& patch = patches[m.patch];
    if (patch.coverage > 0)
      samples[patch.ink][to_thousandths(patch.coverage)].push_back(
          {patch.area_ratio, std::min(m.shown, 1.0)});
  }
  std::array<InkCurveRows, 3> lines;  // printed and ink
  std::vector<double> printed{0};
  InkFit fit;
  for (std::size_t k = 0; k < 3; ++k) {
    lines[k] = {{0, 0, 0, 0}, {1, 1, 0, 0}};
    if (samples[k].empty()) continue;
    const std::string name = ink_names[k];
    if (samples[k].size() < least_coverages || samples[k].rbegin()->first != 1)
      return refuse(std::string("only ") + std::to_string(samples[k].size()) + " coverages of " + name +
                        " are measured, or not the full one",
                    std::string("measure at least three coverages of ") + name +
                        ", with the full one (such as " + name[0] + "5a)");
    std::vector<std::vector<InkSample>> of_coverage;
    lines[k].resize(1);
    for (const auto& [coverage, of_it] : samples[k]) {
      of_coverage.push_back(of_it);
      lines[k].push_back({coverage, 0, 0, 0});
      printed.push_back(coverage);
    }
    const std::vector<double> ink = rising(of_coverage);
    for (std::size_t i = 0; i < ink.size(); ++i) lines[k][i + 1][1] = to_thousandths(ink[i]);
    if (ink.back() < least_full)
      return refuse(std::string("full ") + name + " hardly darkens the patches",
                    "check that the rows are those of this chart, and that it was printed in colour");
  }
  if (printed.size() == 1)
    return refuse("no patch is measured",
                  "fill in measured.csv, which vacuform chart wrote beside chart.json");
  std::sort(printed.begin(), printed.end());
  printed.erase(std::unique(printed.begin(), printed.end()), printed.end());
  for (const double at : printed) {
    std::array<double, 4> row{at, 0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      std::size_t i = 1;
      while (i + 1 < lines[k].size() && lines[k][i][0] < at) ++i;
      const auto &a = lines[k][i - 1], &b = lines[k][i];
      row[k + 1] = to_thousandths(a[1] + (b[1] - a[1]) * (at - a[0]) / (b[0] - a[0]));
    }
    fit.curve.push_back(row);
  }

  const InkCurve curve(fit.curve), linear;
  std::array<InkResidual, 3> with, without;
  std::map<int, std::pair<InkResidual, double>> steps;
  for (const MeasuredInk& m : measured) {
    const InkPatch& patch = patches[m.patch];
    const auto ink = static_cast<std::size_t>(patch.ink);
    const double difference = std::min(m.shown, 1.0) - shown_by(curve, patch);
    with[ink].add(difference);
    without[ink].add(std::min(m.shown, 1.0) - shown_by(linear, patch));
    auto& step = steps[patch.step];
    step.first.add(difference);
    step.second += patch.area_ratio;
    if (std::abs(difference) > fit.worst) fit.worst = std::abs(difference), fit.worst_patch = patch.id;
  }
  for (std::size_t k = 0; k < 3; ++k)
    fit.count[k] = with[k].count, fit.rms[k] = with[k].rms(), fit.rms_linear[k] = without[k].rms();
  for (const auto& [number, step] : steps)
    fit.by_step.push_back({step.second / step.first.count, step.first.rms()});
  return fit;
}

nlohmann::ordered_json fit_json(const InkFit& fit) {
  nlohmann::ordered_json inks = nlohmann::ordered_json::object(), steps = nlohmann::ordered_json::array();
  for (std::size_t k = 0; k < 3; ++k)
    inks[ink_names[k]] = {{"patches", fit.count[k]},
                          {"rms", to_thousandths(fit.rms[k])},
                          {"rms_linear", to_thousandths(fit.rms_linear[k])}};
  for (const auto& [ratio, rms] : fit.by_step)
    steps.push_back({{"area_ratio", to_thousandths(ratio)}, {"rms", to_thousandths(rms)}});
  return {{"print", {{"ink_curve", fit.curve}}},
          {"calibration",
           {{"inks", std::move(inks)},
            {"steps", std::move(steps)},
            {"worst", {{"patch", fit.worst_patch}, {"coverage", to_thousandths(fit.worst)}}}}}};
}

std::string text_of(const InkFit& fit) {
  std::string rows;
  for (const auto& row : fit.curve) {
    rows += rows.empty() ? "[" : ",";
    for (std::size_t k = 0; k < row.size(); ++k)
      rows.append(k == 0 ? "[" : ",").append(short_decimal(row[k]));
    rows += "]";
  }
  std::string out;
  for (std::size_t k = 0; k < 3; ++k)
    out += std::string(ink_names[k]) +
           (fit.count[k] == 0 ? std::string(": not measured, stays linear\n")
                              : std::string(": ") + std::to_string(fit.count[k]) + " patches, residual " +
                                    decimal(100 * fit.rms[k], 1) + " % coverage RMS (linear curve: " +
                                    decimal(100 * fit.rms_linear[k], 1) + " %)\n");
  for (const auto& [ratio, rms] : fit.by_step)
    out +=
        std::string("stretched ") + decimal(ratio, 2) + " times: residual " + decimal(100 * rms, 1) + " %\n";
  out += std::string("largest difference: ") + decimal(100 * fit.worst, 1) + " %, patch " + fit.worst_patch +
         "\n";
  return out + "--set 'print.ink_curve=" + rows + "]'\n";
}

}  // namespace vacuform
