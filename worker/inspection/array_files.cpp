#include "worker/inspection/array_files.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"
#include "worker/electrical/tuning.hpp"
#include "worker/inspection/json_numbers.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::MatrixXcd;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

const CircuitFigures& circuits(const Finished& job) { return *job.figures.electrical; }
const std::string& id(const Finished& job, std::size_t i) {
  return job.placed->elements[index(circuits(job).elements[i])].id;
}
std::vector<const LoopGap*> gaps_of(const Finished& job, std::size_t i) {
  std::vector<const LoopGap*> out;
  for (const LoopGap& gap : job.build->gaps)
    if (gap.coil == circuits(job).elements[i]) out.push_back(&gap);
  return out;
}

void add(std::string& row, double value, int places, char before = ' ') {
  row += before;
  row += decimal(value, places);
}

// Of the capacitors in series besides the one across the port.
int others(const CircuitFigures& of, std::size_t i) { return std::max(1, of.loops[i].gaps - 1); }

// A field may hold commas and quotes.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

Json matrix(const CouplingMatrix& of, const std::vector<int>& which) {
  Json rows = Json::array();
  for (const int a : which) {
    Json& row = rows.emplace_back(Json::array());
    for (const int b : which) row.push_back(std::isfinite(of(a, b)) ? rounded(of(a, b), 5) : Json());
  }
  return rows;
}

// At an angular frequency, 1/s. The loops with their series capacitors, in parallel with the capacitor across each port.
MatrixXcd scattering(const Finished& job, double w) {
  const CircuitFigures& of = circuits(job);
  const CouplingMatrix& k = job.figures.measured->coils.k.with;
  const std::complex<double> j(0, 1);
  const int count = static_cast<int>(of.loops.size());
  MatrixXcd z(count, count);
  const auto ohm = [&](int i) { return of.array.loops[index(i)].coil_ohm + of.array.loops[index(i)].body_ohm; };
  const auto henry = [&](int i) { return of.loops[index(i)].inductance_nh * 1e-9; };
  for (int a = 0; a < count; ++a)
    for (int b = 0; b < count; ++b) {
      const double coupled = a == b ? 1 : k.count() > 0 ? k(of.coils[index(a)], of.coils[index(b)]) : 0;
      z(a, b) = of.array.noise(a, b) * std::sqrt(ohm(a) * ohm(b)) + j * w * coupled * std::sqrt(henry(a) * henry(b));
      if (a == b) z(a, a) += 1.0 / (j * w * of.array.loops[index(a)].series_pf * 1e-12);
    }
  MatrixXcd y = z.partialPivLu().inverse();
  for (int a = 0; a < count; ++a) y(a, a) += j * w * of.array.loops[index(a)].matching_pf * 1e-12;
  const MatrixXcd one = MatrixXcd::Identity(count, count), scaled = job.settings.circuit.port_ohm * y;
  return (one + scaled).partialPivLu().solve(one - scaled);
}

std::vector<int> all_of(const CouplingMatrix& matrix) {
  std::vector<int> out(index(matrix.count()));
  for (int i = 0; i < matrix.count(); ++i) out[index(i)] = i;
  return out;
}

}  // namespace

std::string coils_csv(const Finished& job) {
  const CircuitFigures& of = circuits(job);
  std::string out = "number,loop,gap,kind,wanted_pF,value_pF,detuning_percent,x_mm,y_mm,z_mm\r\n";
  int number = 0;
  for (std::size_t i = 0; i < of.loops.size(); ++i) {
    int gap = 0;
    const LoopCircuit& loop = of.array.loops[i];
    for (const LoopGap* const each : gaps_of(job, i)) {
      const double wanted = each->port ? loop.matching_pf : loop.series_pf * others(of, i);
      const StandardValue value = wanted > 0 ? standard_value(wanted) : StandardValue{};
      out += std::to_string(++number) + ',' + field(id(job, i)) + ',' + std::to_string(++gap) +
             (each->port ? ",port" : ",capacitor");
      add(out, wanted, 2, ',');
      add(out, value.pf, 2, ',');
      if (each->port)
        out += ',';
      else
        add(out, 100 * value.detuning, 2, ',');
      for (const double mm : {each->place.x(), each->place.y(), each->place.z()}) add(out, mm, 1, ',');
      out += "\r\n";
    }
  }
  return out;
}

std::string array_json(const Finished& job) {
  const CircuitFigures& of = circuits(job);
  const CoilTable& table = job.figures.measured->coils;
  Json loops = Json::array();
  for (std::size_t i = 0; i < of.loops.size(); ++i) {
    const LoopCircuit& loop = of.array.loops[i];
    Json capacitors = Json::array(), line = Json::array(), gaps = Json::array();
    for (const LoopCircuit::Capacitors& c : loop.capacitors)
      capacitors.push_back({{"mhz", rounded(c.mhz, 2)},
                            {"total_pf", rounded(c.total_pf, 2)},
                            {"gap_pf", rounded(c.gap_pf, 2)},
                            {"standard_pf", rounded(c.standard_pf, 2)},
                            {"detuning", rounded(c.detuning, 4)}});
    for (const Vector3d& p : of.loops[i].line) line.push_back(array(p, 3));
    for (const LoopGap* const gap : gaps_of(job, i))
      gaps.push_back({{"port", gap->port}, {"drawn", gap->drawn}, {"place_mm", array(gap->place, 1)}});
    loops.push_back({{"id", id(job, i)},
                     {"inductance_nh", rounded(of.loops[i].inductance_nh, 2)},
                     {"coil_ohm", rounded(loop.coil_ohm)},
                     {"body_ohm", rounded(loop.body_ohm)},
                     {"most_body_ohm", rounded(loop.most_body_ohm)},
                     {"unloaded_q", rounded(loop.unloaded, 1)},
                     {"loaded_q", rounded(loop.loaded, 1)},
                     {"noise_db", rounded(loop.noise_db, 2)},
                     {"matching_pf", rounded(loop.matching_pf, 2)},
                     {"series_pf", rounded(loop.series_pf, 2)},
                     {"capacitors", std::move(capacitors)},
                     {"gaps", std::move(gaps)},
                     {"line_mm", std::move(line)}});
  }
  return Json{{"frequency_mhz", rounded(job.settings.circuit.frequency_mhz, 3)},
              {"body",
               {{"centre_mm", array(of.array.body.centre, 1)},
                {"radius_mm", rounded(of.array.body.radius_mm, 2)},
                {"rms_mm", rounded(of.array.body.rms_mm, 2)},
                {"above_mm", rounded(of.above_mm, 2)}}},
              {"loops", std::move(loops)},
              {"k", table.k.with.count() > 0 ? matrix(table.k.with, of.coils) : Json()},
              {"noise", matrix(of.array.noise, all_of(of.array.noise))}}
             .dump(1) +
         "\n";
}

std::string array_nec(const Finished& job) {
  const CircuitFigures& of = circuits(job);
  constexpr std::size_t segments = 48;
  std::string out = "CM Vacuform " + job.label + "\nCM tag i: the i-th loop of array.json; segment 1 holds its port\nCE\n", loads;
  for (std::size_t i = 0; i < of.loops.size(); ++i) {
    const std::vector<Vector3d>& line = of.loops[i].line;
    std::vector<Vector3d> points;
    // From the port on, if there is one.
    const auto gaps = gaps_of(job, i);
    std::size_t first = 0;
    if (!gaps.empty())
      for (std::size_t k = 0; k < line.size(); ++k)
        if ((line[k] - gaps.front()->place).norm() < (line[first] - gaps.front()->place).norm()) first = k;
    for (std::size_t k = 0; k < segments; ++k) points.push_back(line[(first + k * line.size() / segments) % line.size()]);
    // A strip is as inductive as a wire of a quarter of its width as radius.
    const double radius = job.placed->elements[index(of.elements[i])].loop->width_mm * job.settings.pattern.scale / 4;
    const std::string tag = std::to_string(i + 1);
    for (std::size_t k = 0; k < segments; ++k) {
      out += "GW " + tag + " 1";
      for (const Vector3d& p : {points[k], points[(k + 1) % segments]})
        for (const double mm : {p.x(), p.y(), p.z()}) add(out, mm / 1000, 7);
      add(out, radius / 1000, 7);
      out += "\n";
    }
    const LoopCircuit& loop = of.array.loops[i];
    // All series capacitors and losses in the segment across the port.
    const std::string middle = std::to_string(segments / 2);
    loads += "LD 0 " + tag + ' ' + middle + ' ' + middle;
    add(loads, loop.coil_ohm + loop.body_ohm, 5);
    loads += " 0";
    add(loads, loop.series_pf, 4);
    loads += "E-12\n";
  }
  return out + "GE 0\n" + loads + "FR 0 1 0 0 " + decimal(job.settings.circuit.frequency_mhz, 4) +
         " 0\nEX 0 1 1 0 1 0\nXQ\nEN\n";
}

std::string array_touchstone(const Finished& job) {
  const CircuitFigures& of = circuits(job);
  const std::size_t count = of.loops.size();
  constexpr int steps = 50;
  constexpr double about = 0.025;
  std::string out = "! Vacuform " + job.label + "\n! ports: ";
  for (std::size_t i = 0; i < of.loops.size(); ++i) out += (i == 0 ? "" : ", ") + id(job, i);
  out += "\n[Version] 2.0\n# MHz S RI R " + decimal(job.settings.circuit.port_ohm, 3) + "\n[Number of Ports] " +
         std::to_string(count) + "\n" + (count == 2 ? "[Two-Port Data Order] 12_21\n" : "") +
         "[Number of Frequencies] " + std::to_string(steps + 1) + "\n[Network Data]\n";
  for (int step = 0; step <= steps; ++step) {
    const double mhz = job.settings.circuit.frequency_mhz * (1 + about * (2.0 * step / steps - 1));
    const MatrixXcd s = scattering(job, angular_frequency(mhz));
    out += decimal(mhz, 6);
    for (Eigen::Index a = 0; a < s.rows(); ++a) {
      for (Eigen::Index b = 0; b < s.cols(); ++b)
        for (const double part : {s(a, b).real(), s(a, b).imag()}) add(out, part, 7);
      out += "\n";
    }
  }
  return out + "[End]\n";
}

}  // namespace vacuform
