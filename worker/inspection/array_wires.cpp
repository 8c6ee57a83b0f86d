#include "worker/inspection/array_wires.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "api/base/decimal.hpp"
#include "worker/coils/inductance.hpp"
#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;

constexpr double wires_apart_mm = 0.6;

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

}  // namespace

void add_number(std::string& row, double value, int places, char before) {
  row += before;
  row += decimal(value, places);
}

const std::string& loop_id(const Finished& job, std::size_t i) {
  return job.placed->elements[index(job.figures.electrical->elements[i])].id;
}
std::vector<const LoopGap*> loop_gaps(const Finished& job, std::size_t i) {
  std::vector<const LoopGap*> out;
  for (const LoopGap& gap : job.build->gaps)
    if (gap.coil == job.figures.electrical->elements[i]) out.push_back(&gap);
  return out;
}

LoopWire loop_wire(const Finished& job, std::size_t i) {
  constexpr double longest_mm = 4.5, near_mm = 2.5;
  const CircuitFigures& of = *job.figures.electrical;
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
  std::vector<std::size_t> gaps;
  for (const LoopGap* const gap : loop_gaps(job, i)) gaps.push_back(nearest_to(gap->place));
  const std::size_t port = gaps.empty() ? 0 : gaps.front();
  corners.insert(port);
  corners.insert(gaps.begin(), gaps.end());
  corners.insert(lifted.begin(), lifted.end());
  std::vector<std::size_t> order(corners.begin(), corners.end());
  std::rotate(order.begin(), std::find(order.begin(), order.end(), port), order.end());
  LoopWire out;
  out.gaps.resize(gaps.size());
  for (std::size_t c = 0; c < order.size(); ++c) {
    const std::size_t from = order[c], next = order[(c + 1) % order.size()];
    const std::size_t way = (next + line.size() - from) % line.size();
    for (std::size_t g = 0; g < gaps.size(); ++g)
      if (gaps[g] == from) out.gaps[g] = out.points.size();
    double mm = 0;
    for (std::size_t k = 0; k < (way == 0 ? line.size() : way); ++k)
      mm += (line[(from + k + 1) % line.size()] - line[(from + k) % line.size()]).norm();
    const auto parts = static_cast<std::size_t>(std::max(1.0, std::ceil(mm / longest_mm)));
    for (std::size_t k = 0; k < parts; ++k) {
      Vector3d p = line[(from + k * (way == 0 ? line.size() : way) / parts) % line.size()];
      if (k == 0 && lifted.contains(from)) p += wires_apart_mm * (p - of.array.body.centre).normalized();
      out.points.push_back(p);
    }
  }
  return out;
}

std::string array_nec(const Finished& job) {
  const CircuitFigures& of = *job.figures.electrical;
  std::string out = "CM Vacuform " + job.label +
                    "\nCM tag i: the i-th loop of array.json; segment 1 holds its port\nCE\n",
              loads;
  for (std::size_t i = 0; i < of.loops.size(); ++i) {
    const std::vector<Vector3d> points = loop_wire(job, i).points;
    const std::string tag = std::to_string(i + 1);
    for (std::size_t k = 0; k < points.size(); ++k) {
      out += "GW " + tag + " 1";
      for (const Vector3d& p : {points[k], points[(k + 1) % points.size()]})
        for (const double mm : {p.x(), p.y(), p.z()}) add_number(out, mm / 1000, 7);
      add_number(out, wire_radius_mm / 1000, 7);
      out += "\n";
    }
    // A wire has more inductance than the strip: less of it along all segments.
    const LoopCircuit& loop = of.array.loops[i];
    const double excess = self_inductance_nh(points, 4 * wire_radius_mm) - of.loops[i].inductance_nh;
    loads += "LD 0 " + tag + " 0 0 0";
    add_number(loads, -excess / static_cast<double>(points.size()), 6);
    loads += "E-09 0\n";
    const std::string far = std::to_string(points.size() / 2);  // from the port
    loads += "LD 0 " + tag + ' ' + far + ' ' + far;
    add_number(loads, loop.coil_ohm + loop.body_ohm, 5);
    loads += " 0";
    add_number(loads, loop.series_pf, 4);
    loads += "E-12\n";
  }
  return out + "GE 0\n" + loads + "FR 0 1 0 0 " + decimal(job.settings.circuit.frequency_mhz, 4) +
         " 0\nEX 0 1 1 0 1 0\nXQ\nEN\n";
}

namespace {

std::string element(std::size_t number, int type, std::size_t tag, std::initializer_list<std::size_t> nodes) {
  std::string out = std::to_string(number) + ' ' + std::to_string(type) + " 2 " + std::to_string(tag) + ' ' +
                    std::to_string(tag);
  for (const std::size_t node : nodes) out += ' ' + std::to_string(node);
  return out + '\n';
}

}  // namespace

std::string marie_mesh(const Finished& job) {
  constexpr int line = 1, point = 15;  // as Gmsh numbers types of elements
  std::string nodes;
  std::vector<std::size_t> gaps;                   // their nodes, from 1
  std::vector<std::array<std::size_t, 3>> pieces;  // loop, from, to
  std::size_t count = 0;
  for (std::size_t i = 0; i < job.figures.electrical->loops.size(); ++i) {
    const LoopWire wire = loop_wire(job, i);
    const std::size_t first = count + 1;
    for (const std::size_t gap : wire.gaps) gaps.push_back(first + gap);
    for (std::size_t k = 0; k < wire.points.size(); ++k) {
      nodes += std::to_string(++count);
      for (const double mm : wire.points[k]) add_number(nodes, mm / 1000, 9);
      nodes += '\n';
      pieces.push_back({i + 1, count, k + 1 < wire.points.size() ? count + 1 : first});
    }
  }
  std::string elements;
  std::size_t number = 0;
  for (const std::size_t gap : gaps) {
    ++number;
    elements += element(number, point, number, {gap});
  }
  for (const auto& [loop, from, to] : pieces) elements += element(++number, line, loop, {from, to});
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + std::to_string(count) + '\n' + nodes +
         "$EndNodes\n$Elements\n" + std::to_string(number) + '\n' + elements + "$EndElements\n";
}

std::string marie_circuit(const Finished& job) {
  using Json = nlohmann::ordered_json;
  constexpr double quality = 2000, range = 10;  // of the capacitors; how far its optimizer may change them
  Json elements = Json::array();
  for (std::size_t i = 0; i < job.figures.electrical->loops.size(); ++i) {
    const LoopCircuit& loop = job.figures.electrical->array.loops[i];
    const auto gaps = loop_gaps(job, i);
    for (const LoopGap* const gap : gaps) {
      const double others = std::max(1.0, static_cast<double>(gaps.size()) - 1);
      const double farad = 1e-12 * (gap->port ? loop.matching_pf : loop.series_pf * others);
      elements.push_back({{"number", elements.size() + 1},
                          {"type", gap->port ? "port" : "element"},
                          {"load", gap->port ? "capacitorParallel" : "capacitor"},
                          {"value", farad},
                          {"optim",
                           {{"boolean", 1},
                            {"minim", farad / range},
                            {"maxim", farad * range},
                            {"symmetry", elements.size() + 1}}},
                          {"cross_talk", Json::object()},
                          {"excitation", {{"entity", i + 1}, {"TxRx", "Rx"}}},
                          {"Q", quality}});
    }
  }
  Json all = {{"name", "array-marie.json"}, {"tmd", "false"}};
  all["elements"] = std::move(elements);
  return Json{{"coil_configuration", std::move(all)}}.dump(1) + "\n";
}

}  // namespace vacuform
