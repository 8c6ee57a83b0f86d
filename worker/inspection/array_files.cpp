#include "worker/inspection/array_files.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"
#include "worker/electrical/tuning.hpp"
#include "worker/inspection/array_wires.hpp"
#include "worker/inspection/json_numbers.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::MatrixXcd;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

// The capacitor of a gap: across the port, or one of the others, which share what is in series.
struct Soldered {
  const LoopGap* gap;
  double wanted_pf;
  StandardValue standard;  // none where no capacitor is wanted
};
std::vector<Soldered> soldered(const Finished& job, std::size_t i) {
  const LoopCircuit& loop = job.figures.electrical->array.loops[i];
  const int others = std::max(1, job.figures.electrical->loops[i].gaps - 1);
  std::vector<Soldered> out;
  for (const LoopGap* const gap : loop_gaps(job, i)) {
    const double wanted = gap->port ? loop.matching_pf : loop.series_pf * others;
    if (gap->plate)
      out.push_back(
          {gap, wanted, {gap->plate->pf, gap->plate->pf > 0 ? std::sqrt(wanted / gap->plate->pf) - 1 : 0}});
    else
      out.push_back({gap, wanted, wanted > 0 ? standard_value(wanted) : StandardValue{}});
  }
  return out;
}

// On the part. The field at the edges is in `pf` and not in `between_pf`.
Json plate_json(const Plate& plate, const Settings& settings) {
  return {{"pf", rounded(plate.pf, 2)},
          {"between_pf", rounded(plate.between_pf, 2)},
          {"tolerance", settings.sheet.thickness_tolerance},
          {"width_mm", rounded(settings.coils.plate_width_mm, 2)},
          {"thickness_mm", rounded(plate.thickness_mm, 3)}};
}

// A field may hold commas and quotes.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

const Tail* tail_of(const Finished& job, int element) {
  const auto at = std::find_if(job.build->tails.begin(), job.build->tails.end(),
                               [&](const Tail& tail) { return tail.coil == element; });
  return at == job.build->tails.end() ? nullptr : &*at;
}

Json matrix(const CouplingMatrix& of, const std::vector<int>& which) {
  Json rows = Json::array();
  for (const int a : which) {
    Json& row = rows.emplace_back(Json::array());
    for (const int b : which) row.push_back(std::isfinite(of(a, b)) ? rounded(of(a, b), 5) : Json());
  }
  return rows;
}

double coupling(const Finished& job, std::size_t a, std::size_t b) {
  const CouplingMatrix& k = job.figures.measured->coils.k.with;
  const std::vector<int>& coils = job.figures.electrical->coils;
  return a == b ? 1 : k.count() > 0 ? k(coils[a], coils[b]) : 0;
}

// The current that one in loop a drives in loop b, as its share, if nothing but the losses of b stands against it.
double current(const Finished& job, std::size_t a, std::size_t b) {
  const CircuitFigures& of = *job.figures.electrical;
  return coupled_current(
      coupling(job, a, b), std::sqrt(of.loops[a].inductance_nh * of.loops[b].inductance_nh),
      job.settings.circuit.frequency_mhz, of.array.loops[b].coil_ohm + of.array.loops[b].body_ohm, 0);
}

// What preamplifiers leave of a current.
double left_by_preamplifiers(const Finished& job) {
  return std::pow(10, -job.settings.circuit.preamp_db / 20);
}

Json strongest_current(const Finished& job) {
  const std::size_t count = job.figures.electrical->loops.size();
  std::size_t from = 0, to = 0;
  double most = 0;
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < count; ++b)
      if (a != b && current(job, a, b) > most) most = current(job, a, b), from = a, to = b;
  if (!(most > 0)) return Json();
  return {{"from", loop_id(job, from)},
          {"to", loop_id(job, to)},
          {"share", rounded(most, 4)},
          {"with_preamplifiers", rounded(most * left_by_preamplifiers(job), 4)}};
}

// At an angular frequency, 1/s. The loops with their series capacitors, in parallel with the capacitor across each port.
MatrixXcd scattering(const Finished& job, double w) {
  const CircuitFigures& of = *job.figures.electrical;
  const std::complex<double> j(0, 1);
  const int count = static_cast<int>(of.loops.size());
  MatrixXcd z(count, count);
  const auto ohm = [&](int i) {
    return of.array.loops[index(i)].coil_ohm + of.array.loops[index(i)].body_ohm;
  };
  const auto henry = [&](int i) { return of.loops[index(i)].inductance_nh * 1e-9; };
  for (int a = 0; a < count; ++a)
    for (int b = 0; b < count; ++b) {
      const double coupled = coupling(job, index(a), index(b));
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
  const CircuitFigures& of = *job.figures.electrical;
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
                      {"standard_pf", each.gap->plate ? Json() : Json(rounded(each.standard.pf, 2))},
                      {"plate", each.gap->plate ? plate_json(*each.gap->plate, job.settings) : Json()},
                      {"place_mm", array(each.gap->place, 1)}});
    loops.push_back({{"id", loop_id(job, i)},
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
  // From about here on the wave in the head is as short as the head.
  constexpr double quasi_static_mhz = 200;
  return {{"frequency_mhz", rounded(job.settings.circuit.frequency_mhz, 3)},
          {"order_of_magnitude", job.settings.circuit.frequency_mhz > quasi_static_mhz},
          {"body",
           {{"centre_mm", array(of.array.body.centre, 1)},
            {"radius_mm", rounded(of.array.body.radius_mm, 2)},
            {"rms_mm", rounded(of.array.body.rms_mm, 2)},
            {"above_mm", rounded(of.above_mm, 2)}}},
          {"preamp_db", rounded(job.settings.circuit.preamp_db, 1)},
          {"strongest_current", strongest_current(job)},
          {"loops", std::move(loops)}};
}

std::optional<Warning> small_capacitors(const Finished& job) {
  double least = least_gap_pf;
  std::string loops;
  Warning out{.code = "capacitors-small", .text = {}};
  for (std::size_t i = 0; i < job.figures.electrical->loops.size(); ++i)
    for (const Soldered& each : soldered(job, i)) {
      if (each.gap->port || each.gap->plate || !(each.wanted_pf > 0) || each.wanted_pf >= least_gap_pf)
        continue;
      least = std::min(least, each.wanted_pf);
      const Eigen::Vector3d& at = each.gap->place;
      if (out.marks.size() < Warning::most_marks) out.marks.push_back({{at.x(), at.y(), at.z()}, 5});
      const std::string id = loop_id(job, i);
      if (loops.ends_with(id)) continue;
      loops += (loops.empty() ? "" : ", ") + id;
    }
  if (loops.empty()) return std::nullopt;
  out.text =
      "capacitors of less than 2 pF tune loops at " + decimal(job.settings.circuit.frequency_mhz, 2) + " MHz";
  out.place = loops;
  out.figure = Warning::Figure{least, "pF", least_gap_pf};
  return out;
}

std::string coils_csv(const Finished& job) {
  std::string out =
      "number,loop,gap,kind,wanted_pF,value_pF,detuning_percent,x_mm,y_mm,z_mm,tail_mm,tail_ohm,tail_nH\r\n";
  for (std::size_t i = 0; i < job.figures.electrical->loops.size(); ++i) {
    int gap = 0;
    for (const Soldered& each : soldered(job, i)) {
      const bool port = each.gap->port;
      out += std::to_string(each.gap->number) + ',' + field(loop_id(job, i)) + ',' + std::to_string(++gap) +
             (port              ? ",port"
              : each.gap->plate ? ",printed"
                                : ",capacitor");
      add_number(out, each.wanted_pf, 2, ',');
      add_number(out, each.standard.pf, 2, ',');
      if (port)
        out += ',';
      else
        add_number(out, 100 * each.standard.detuning, 2, ',');
      for (const double mm : {each.gap->place.x(), each.gap->place.y(), each.gap->place.z()})
        add_number(out, mm, 1, ',');
      const Tail* const tail = port ? tail_of(job, each.gap->coil) : nullptr;
      if (tail) {
        add_number(out, tail->length_mm, 1, ',');
        add_number(out, tail_ohm(*tail, job.settings.circuit), 3, ',');
        add_number(out, tail->inductance_nh, 1, ',');
      } else {
        out += ",,,";
      }
      out += "\r\n";
    }
  }
  return out;
}

std::string array_json(const Finished& job) {
  const CircuitFigures& of = *job.figures.electrical;
  const CoilTable& table = job.figures.measured->coils;
  Json out = electrical_json(job);
  for (std::size_t i = 0; i < of.loops.size(); ++i) {
    Json line = Json::array();
    for (const Vector3d& p : of.loops[i].line) line.push_back(array(p, 3));
    out["loops"][i]["line_mm"] = std::move(line);
  }
  out["k"] = table.k.with.count() > 0 ? matrix(table.k.with, of.coils) : Json();
  Json& currents = out["currents"] = Json::array();
  for (std::size_t a = 0; a < of.loops.size(); ++a) {
    Json& row = currents.emplace_back(Json::array());
    for (std::size_t b = 0; b < of.loops.size(); ++b)
      row.push_back(a == b ? Json(1) : rounded(current(job, a, b) * left_by_preamplifiers(job), 5));
  }
  out["noise"] = matrix(of.array.noise, all_of(of.array.noise));
  return out.dump(1) + "\n";
}

std::string array_touchstone(const Finished& job) {
  const CircuitFigures& of = *job.figures.electrical;
  const std::size_t count = of.loops.size();
  constexpr int steps = 50;
  constexpr double about = 0.025;
  std::string out = "! Vacuform " + job.label + "\n! ports: ";
  for (std::size_t i = 0; i < of.loops.size(); ++i) out += (i == 0 ? "" : ", ") + loop_id(job, i);
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
        for (const double part : {s(a, b).real(), s(a, b).imag()}) add_number(out, part, 7);
      out += "\n";
    }
  }
  return out + "[End]\n";
}

}  // namespace vacuform
