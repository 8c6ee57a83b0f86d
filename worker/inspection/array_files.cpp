#include "worker/inspection/array_files.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "api/base/decimal.hpp"
#include "worker/coils/inductance.hpp"
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

// The capacitor of a gap: across the port, or one of the others, which share what is in series.
struct Soldered {
  const LoopGap* gap;
  double wanted_pf;
  StandardValue standard;  // none where no capacitor is wanted
};
std::vector<Soldered> soldered(const Finished& job, std::size_t i) {
  const LoopCircuit& loop = circuits(job).array.loops[i];
  const int others = std::max(1, circuits(job).loops[i].gaps - 1);
  std::vector<Soldered> out;
  for (const LoopGap* const gap : gaps_of(job, i)) {
    const double wanted = gap->port ? loop.matching_pf : loop.series_pf * others;
    out.push_back({gap, wanted, wanted > 0 ? standard_value(wanted) : StandardValue{}});
  }
  return out;
}

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

// NEC-2 models thin wires, which must not touch.
constexpr double wire_radius_mm = 0.1, wires_apart_mm = 0.6;

// The points of a line that are nearest to another which it crosses, where they come within `reach_mm`.
void add_crossings(const std::vector<Vector3d>& line, const std::vector<Vector3d>& other, double reach_mm,
                   std::set<std::size_t>& out) {
  const std::size_t count = line.size();
  std::vector<double> far(count, std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < count; ++k)
    for (const Vector3d& p : other) far[k] = std::min(far[k], (line[k] - p).norm());
  for (std::size_t k = 0; k < count; ++k)
    if (far[k] < reach_mm && far[k] < far[(k + count - 1) % count] && far[k] <= far[(k + 1) % count])
      out.insert(k);
}

// A loop as a polygon that begins at its port. It has a corner wherever it crosses another: NEC-2 looks at the middles of
// wires, which are then far from each other. Where it crosses over another on the same face it is lifted off the part.
std::vector<Vector3d> wire_of(const Finished& job, std::size_t i) {
  constexpr double longest_mm = 4.5, near_mm = 2.5;
  const CircuitFigures& of = circuits(job);
  const std::vector<Vector3d>& line = of.loops[i].line;
  const auto nearest_to = [&](const Vector3d& place) {
    return static_cast<std::size_t>(std::min_element(line.begin(), line.end(),
                                                     [&](const Vector3d& a, const Vector3d& b) {
                                                       return (a - place).norm() < (b - place).norm();
                                                     }) -
                                    line.begin());
  };
  std::set<std::size_t> corners;
  for (std::size_t k = 0; k < of.loops.size(); ++k)
    if (k != i) add_crossings(line, of.loops[k].line, near_mm, corners);
  std::set<std::size_t> lifted;
  for (const Bridge& bridge : job.build->bridges)
    if (bridge.over() == of.elements[i]) lifted.insert(nearest_to(bridge.crossing.place));
  const auto gaps = gaps_of(job, i);
  const std::size_t port = gaps.empty() ? 0 : nearest_to(gaps.front()->place);
  corners.insert(port);
  corners.insert(lifted.begin(), lifted.end());
  std::vector<std::size_t> order(corners.begin(), corners.end());
  std::rotate(order.begin(), std::find(order.begin(), order.end(), port), order.end());
  std::vector<Vector3d> out;
  for (std::size_t c = 0; c < order.size(); ++c) {
    const std::size_t from = order[c], next = order[(c + 1) % order.size()];
    const std::size_t way = (next + line.size() - from) % line.size();
    double mm = 0;
    for (std::size_t k = 0; k < (way == 0 ? line.size() : way); ++k)
      mm += (line[(from + k + 1) % line.size()] - line[(from + k) % line.size()]).norm();
    const auto parts = static_cast<std::size_t>(std::max(1.0, std::ceil(mm / longest_mm)));
    for (std::size_t k = 0; k < parts; ++k) {
      Vector3d p = line[(from + k * (way == 0 ? line.size() : way) / parts) % line.size()];
      if (k == 0 && lifted.contains(from)) p += wires_apart_mm * (p - of.array.body.centre).normalized();
      out.push_back(p);
    }
  }
  return out;
}

// At an angular frequency, 1/s. The loops with their series capacitors, in parallel with the capacitor across each port.
MatrixXcd scattering(const Finished& job, double w) {
  const CircuitFigures& of = circuits(job);
  const CouplingMatrix& k = job.figures.measured->coils.k.with;
  const std::complex<double> j(0, 1);
  const int count = static_cast<int>(of.loops.size());
  MatrixXcd z(count, count);
  const auto ohm = [&](int i) {
    return of.array.loops[index(i)].coil_ohm + of.array.loops[index(i)].body_ohm;
  };
  const auto henry = [&](int i) { return of.loops[index(i)].inductance_nh * 1e-9; };
  for (int a = 0; a < count; ++a)
    for (int b = 0; b < count; ++b) {
      const double coupled = a == b ? 1 : k.count() > 0 ? k(of.coils[index(a)], of.coils[index(b)]) : 0;
      z(a, b) = of.array.noise(a, b) * std::sqrt(ohm(a) * ohm(b)) +
                j * w * coupled * std::sqrt(henry(a) * henry(b));
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

Json electrical_json(const Finished& job) {
  const CircuitFigures& of = circuits(job);
  Json loops = Json::array();
  for (std::size_t i = 0; i < of.loops.size(); ++i) {
    const LoopCircuit& loop = of.array.loops[i];
    Json capacitors = Json::array(), gaps = Json::array();
    for (const LoopCircuit::Capacitors& c : loop.capacitors)
      capacitors.push_back({{"mhz", rounded(c.mhz, 2)},
                            {"total_pf", rounded(c.total_pf, 2)},
                            {"gap_pf", rounded(c.gap_pf, 2)},
                            {"standard_pf", rounded(c.standard_pf, 2)},
                            {"detuning", rounded(c.detuning, 4)}});
    for (const Soldered& each : soldered(job, i))
      gaps.push_back({{"number", each.gap->number},
                      {"port", each.gap->port},
                      {"drawn", each.gap->drawn},
                      {"wanted_pf", rounded(each.wanted_pf, 2)},
                      {"standard_pf", rounded(each.standard.pf, 2)},
                      {"place_mm", array(each.gap->place, 1)}});
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
                     {"gaps", std::move(gaps)}});
  }
  return {{"frequency_mhz", rounded(job.settings.circuit.frequency_mhz, 3)},
          {"body",
           {{"centre_mm", array(of.array.body.centre, 1)},
            {"radius_mm", rounded(of.array.body.radius_mm, 2)},
            {"rms_mm", rounded(of.array.body.rms_mm, 2)},
            {"above_mm", rounded(of.above_mm, 2)}}},
          {"loops", std::move(loops)}};
}

std::string coils_csv(const Finished& job) {
  std::string out = "number,loop,gap,kind,wanted_pF,value_pF,detuning_percent,x_mm,y_mm,z_mm\r\n";
  for (std::size_t i = 0; i < circuits(job).loops.size(); ++i) {
    int gap = 0;
    for (const Soldered& each : soldered(job, i)) {
      const bool port = each.gap->port;
      out += std::to_string(each.gap->number) + ',' + field(id(job, i)) + ',' + std::to_string(++gap) +
             (port ? ",port" : ",capacitor");
      add(out, each.wanted_pf, 2, ',');
      add(out, each.standard.pf, 2, ',');
      if (port)
        out += ',';
      else
        add(out, 100 * each.standard.detuning, 2, ',');
      for (const double mm : {each.gap->place.x(), each.gap->place.y(), each.gap->place.z()})
        add(out, mm, 1, ',');
      out += "\r\n";
    }
  }
  return out;
}

std::string array_json(const Finished& job) {
  const CircuitFigures& of = circuits(job);
  const CoilTable& table = job.figures.measured->coils;
  Json out = electrical_json(job);
  for (std::size_t i = 0; i < of.loops.size(); ++i) {
    Json line = Json::array();
    for (const Vector3d& p : of.loops[i].line) line.push_back(array(p, 3));
    out["loops"][i]["line_mm"] = std::move(line);
  }
  out["k"] = table.k.with.count() > 0 ? matrix(table.k.with, of.coils) : Json();
  out["noise"] = matrix(of.array.noise, all_of(of.array.noise));
  return out.dump(1) + "\n";
}

std::string array_nec(const Finished& job) {
  const CircuitFigures& of = circuits(job);
  std::string out = "CM Vacuform " + job.label +
                    "\nCM tag i: the i-th loop of array.json; segment 1 holds its port\nCE\n",
              loads;
  for (std::size_t i = 0; i < of.loops.size(); ++i) {
    const std::vector<Vector3d> points = wire_of(job, i);
    const std::string tag = std::to_string(i + 1);
    for (std::size_t k = 0; k < points.size(); ++k) {
      out += "GW " + tag + " 1";
      for (const Vector3d& p : {points[k], points[(k + 1) % points.size()]})
        for (const double mm : {p.x(), p.y(), p.z()}) add(out, mm / 1000, 7);
      add(out, wire_radius_mm / 1000, 7);
      out += "\n";
    }
    // A wire has more inductance than the strip: less of it along all segments.
    const LoopCircuit& loop = of.array.loops[i];
    const double excess = self_inductance_nh(points, 4 * wire_radius_mm) - of.loops[i].inductance_nh;
    loads += "LD 0 " + tag + " 0 0 0";
    add(loads, -excess / static_cast<double>(points.size()), 6);
    loads += "E-09 0\n";
    const std::string far = std::to_string(points.size() / 2);  // from the port
    loads += "LD 0 " + tag + ' ' + far + ' ' + far;
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
  out += "\n[Version] 2.0\n# MHz S RI R " + decimal(job.settings.circuit.port_ohm, 3) +
         "\n[Number of Ports] " + std::to_string(count) + "\n" +
         (count == 2 ? "[Two-Port Data Order] 12_21\n" : "") + "[Number of Frequencies] " +
         std::to_string(steps + 1) + "\n[Network Data]\n";
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
