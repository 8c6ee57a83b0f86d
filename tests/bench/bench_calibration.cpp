// Does calibrate() say how well it knows? Simulated parts whose machine is known, and how often its 95 % intervals hold
// the truth.
//
//   bench_calibration [--json] [--parts N] [--first N] [--scan FILE] [--grid MM] [--part-grid MM] [--noise MM] [--seed N]
//
// Without options: 20 parts of neonate-40w, whose machines are drawn from calibrate()'s own prior. Each is formed on a
// grid of 2 mm, finer than the 4 mm that calibrate() is given, so that the grid's error counts; measured at some 230
// points on the head with 0.15 mm of noise in each coordinate, in a frame of the measuring machine. Exits with 1 when
// fewer intervals hold the truth than correct ones would in 19 of 20 samples (a binomial bound).
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "worker/forming/sheet_map.hpp"
#include "worker/studies/calibration.hpp"
#include "worker/studies/inked_places.hpp"

namespace {

using namespace vacuform;

struct Options {
  bool json = false;
  int parts = 20, first = 0;
  std::string scan = std::string(VACUFORM_SHARED_DATA) + "/scans/neonate-40w.stl";
  double grid_mm = 4, part_grid_mm = 2, noise_mm = 0.15, points = 230;
  unsigned seed = 1;
};

// A normal number by the sum of twelve: the same with every standard library.
double normal(std::mt19937& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += static_cast<double>(random()) / 4294967296.0;
  return sum;
}

Settings nominal() {
  Settings s;
  s.machine.drape_height_mm = 14;
  s.machine.window_width_mm = s.machine.window_height_mm = 268;
  return s;
}

// Drawn from the prior, within what is searched.
Settings drawn(std::mt19937& random) {
  Settings s = nominal();
  do s.machine.drape_height_mm = 14 + 10 * normal(random);
  while (s.machine.drape_height_mm < 0 || s.machine.drape_height_mm > 40);
  s.machine.window_width_mm += 5 * normal(random);
  s.machine.window_height_mm += 5 * normal(random);
  s.forming.edge_stiffness = std::exp(0.3 * normal(random));
  return s;
}

// About `count` points of an even grid on what lies on the mold.
std::vector<Eigen::Vector2d> points_on_mold(const FormedSheet& sheet, double count) {
  double area = 0;
  std::vector<int> touching;
  for (std::size_t k = 0; k < sheet.triangles.size(); ++k) {
    const Triangle& t = sheet.triangles[k];
    if (sheet.contact[t[0]] != Contact::mold || sheet.contact[t[1]] != Contact::mold ||
        sheet.contact[t[2]] != Contact::mold)
      continue;
    touching.push_back(static_cast<int>(k));
    const Eigen::Vector2d a = sheet.rest[t[1]] - sheet.rest[t[0]], b = sheet.rest[t[2]] - sheet.rest[t[0]];
    area += (a.x() * b.y() - a.y() * b.x()) / 2;
  }
  const PlaneLocator locator(sheet.triangles, sheet.rest, touching);
  const double step = std::sqrt(area / count);
  std::vector<Eigen::Vector2d> out;
  for (double s = -140.3; s < 140; s += step)
    for (double t = -140.7; t < 140; t += step)
      if (locator.find({s, t})) out.push_back({s, t});
  return out;
}

std::vector<MeasuredPoint3> measured(const FormedSheet& sheet, const Options& o, std::mt19937& random) {
  const auto rest = points_on_mold(sheet, o.points);
  const Eigen::VectorXd places = inked_places(sheet, InkedFace::outer, rest);
  const Eigen::Isometry3d frame =
      Eigen::Translation3d(310, -120, 45) * Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, -2, 3).normalized());
  std::vector<MeasuredPoint3> out;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    Eigen::Vector3d place = places.segment<3>(3 * static_cast<Eigen::Index>(i));
    for (int k = 0; k < 3; ++k) place[k] += o.noise_mm * normal(random);
    out.push_back({rest[i], frame * place});
  }
  return out;
}

double truth_of(const std::string& name, const Settings& s) {
  if (name == "machine.drape_height_mm") return s.machine.drape_height_mm;
  if (name == "machine.window_width_mm") return s.machine.window_width_mm;
  if (name == "machine.window_height_mm") return s.machine.window_height_mm;
  return s.forming.edge_stiffness;
}

// The fewest of n that hold the truth in all but 5 % of samples, when each does with a probability of 0.95.
int least_held(int n) {
  double below = 0, chance = std::pow(0.05, n);
  for (int k = 0; k <= n; ++k) {
    below += chance;
    if (below > 0.05) return k;
    chance *= 0.95 / 0.05 * (n - k) / (k + 1);
  }
  return n;
}

int fail_with(const std::string& text) {
  std::fprintf(stderr, "%s\n", text.c_str());
  return 2;
}

int run(const Options& o) {
  std::ifstream in(o.scan, std::ios::binary);
  const std::vector<std::uint8_t> bytes((std::istreambuf_iterator<char>(in)), {});
  Settings given = nominal();
  given.sheet.resolution_mm = o.grid_mm;
  const auto prepared = prepare({bytes, o.scan}, given, {}, Context{});
  if (!prepared) return fail_with(prepared.error().text());

  auto rows = nlohmann::ordered_json::array();
  int held = 0, intervals = 0;
  std::vector<double> squares;  // of the error in standard errors, a parameter
  for (int part = o.first; part < o.first + o.parts; ++part) {
    std::mt19937 random(o.seed * 1000 + static_cast<unsigned>(part));
    const auto start = std::chrono::steady_clock::now();
    Settings truth = drawn(random);
    truth.sheet.resolution_mm = o.part_grid_mm;
    const auto sheet =
        form(prepared->mold, truth.sheet, truth.machine, truth.forming, prepared->temperature, Context{});
    if (!sheet) return fail_with(sheet.error().text());
    const auto points = measured(*sheet, o, random);
    const auto found = calibrate(*prepared, given, points, {}, Context{});
    if (!found) return fail_with(found.error().text());
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    nlohmann::ordered_json row = {{"part", part}, {"points", points.size()}, {"parameters", nullptr}};
    if (!o.json)
      std::printf(
          "part %2d, %zu points, noise %.3f, error of the simulation %.3f, residual %.3f mm RMS, %d rounds, "
          "%d formings, %.0f s%s\n",
          part, points.size(), found->noise_mm, found->model_error_mm, found->after.rms, found->rounds,
          found->formings, seconds, found->converged ? "" : ", not converged");
    squares.resize(found->parameters.size());
    for (std::size_t k = 0; k < found->parameters.size(); ++k) {
      const FittedParameter& p = found->parameters[k];
      const double real = truth_of(p.name, truth), off = (p.value - real) / p.standard_error;
      const bool holds = p.low95 <= real && real <= p.high95;
      held += holds, ++intervals, squares[k] += off * off;
      row["parameters"][p.name] = {{"truth", real},
                                   {"value", p.value},
                                   {"standard_error", p.standard_error},
                                   {"points_error", p.points_error},
                                   {"interval_95", {p.low95, p.high95}},
                                   {"holds", holds}};
      if (!o.json)
        std::printf("  %-26s truth %8.3f  found %8.3f +- %6.3f (points alone %7.3f)  %8.3f to %8.3f%s\n",
                    p.name.c_str(), real, p.value, p.standard_error, p.points_error, p.low95, p.high95,
                    holds ? "" : "  MISSED");
    }
    row["noise_mm"] = found->noise_mm, row["converged"] = found->converged, row["seconds"] = seconds;
    rows.push_back(std::move(row));
    std::fflush(stdout);
  }
  const int least = least_held(intervals);
  if (o.json) {
    std::printf("%s\n", nlohmann::ordered_json(
                            {{"held", held}, {"intervals", intervals}, {"least", least}, {"parts", rows}})
                            .dump(2)
                            .c_str());
  } else {
    std::printf(
        "%d of %d intervals of 95 %% hold the truth (at least %d wanted); error over standard error, RMS:",
        held, intervals, least);
    for (const double sum : squares) std::printf(" %.2f", std::sqrt(sum / o.parts));
    std::printf("\n");
  }
  return held >= least ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--json") {
      o.json = true;
      continue;
    }
    if (++i == argc) return fail_with("no value for " + name);
    if (name == "--parts")
      o.parts = std::atoi(argv[i]);
    else if (name == "--first")
      o.first = std::atoi(argv[i]);
    else if (name == "--scan")
      o.scan = argv[i];
    else if (name == "--grid")
      o.grid_mm = std::atof(argv[i]);
    else if (name == "--part-grid")
      o.part_grid_mm = std::atof(argv[i]);
    else if (name == "--noise")
      o.noise_mm = std::atof(argv[i]);
    else if (name == "--seed")
      o.seed = static_cast<unsigned>(std::atoi(argv[i]));
    else
      return fail_with("unknown option " + name);
  }
  return run(o);
}
