// Measures coils by what a lab gets, and shares no code with what made it: reads formed.ply, print.svg and the drawing, and
// prints as JSON how round, large, far apart and coupled the formed coils are.
//
//     measure_coils FORMED.PLY PRINT.SVG PATTERN.SVG [--inner] [--scale X] [--spacing] [--couplings] [--lines]
//
// With --spacing also whether the distances are at their least squares optimum: `spacing_gain` is the largest share by which
// the sum of the squares of their errors falls when one centre alone is moved by half a millimetre, in eight directions.
// With --lines also each coil's centre line in space, as 60 points, and the width of its trace.
// The inked surface is the formed one, or (the outer face) lies one thickness from it along its vertex normals. A coil is a
// group of the drawing with an id whose largest closed line is a circle, an ellipse or a path of M, L, C and Z, without
// transforms; in the print it is the largest closed path of class centreline in the group of the same id. Its centre is
// the point of the surface from which the geodesic radii vary least. Geodesics are exact on the triangles (Xin and Wang
// 2009, by CGAL). Exit 0; 2 with one line on stderr.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <pugixml.hpp>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;
using Line = std::vector<Vector2d>;

struct Surface {
  std::vector<Vector2d> rest;
  std::vector<Vector3d> place;
  std::vector<std::array<int, 3>> triangles;
};

// --- formed.ply -----------------------------------------------------------------------------------------------------

template <class T>
T take(const std::vector<char>& bytes, std::size_t& at) {
  T value;
  if (at + sizeof value > bytes.size()) throw std::runtime_error("formed.ply ends early");
  std::memcpy(&value, bytes.data() + at, sizeof value);
  at += sizeof value;
  return value;
}

Surface read_ply(const std::string& name, bool outer) {
  std::ifstream in(name, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
  const std::string text(bytes.begin(), bytes.end()), end = "end_header\n";
  std::size_t at = text.find(end);
  if (at == std::string::npos) throw std::runtime_error(name + " is no PLY");
  std::istringstream header(text.substr(0, at));
  at += end.size();
  std::size_t vertices = 0, faces = 0;
  std::vector<std::string> properties, types;
  bool of_vertices = false;
  for (std::string line; std::getline(header, line);) {
    std::istringstream words(line);
    std::string word, type, last;
    words >> word >> type >> last;
    if (word == "format" && type != "binary_little_endian") throw std::runtime_error(name + " is not binary");
    if (word == "element")
      of_vertices = type == "vertex", (of_vertices ? vertices : faces) = std::stoul(last);
    if (word == "property" && of_vertices) types.push_back(type), properties.push_back(last);
  }
  Surface surface;
  std::vector<double> thickness;
  for (std::size_t i = 0; i < vertices; ++i) {
    std::map<std::string, double> of;
    for (std::size_t k = 0; k < properties.size(); ++k)
      of[properties[k]] = types[k] == "uchar" ? take<unsigned char>(bytes, at) : take<float>(bytes, at);
    surface.rest.emplace_back(of.at("s"), of.at("t"));
    surface.place.emplace_back(of.at("x"), of.at("y"), of.at("z"));
    thickness.push_back(of.at("thickness"));
  }
  for (std::size_t i = 0; i < faces; ++i) {
    if (take<unsigned char>(bytes, at) != 3)
      throw std::runtime_error(name + " has faces that are no triangles");
    std::array<int, 3> t{};
    for (int& v : t) v = take<std::int32_t>(bytes, at);
    surface.triangles.push_back(t);
  }
  if (!outer) return surface;
  std::vector<Vector3d> normals(vertices, Vector3d::Zero());
  for (const auto& t : surface.triangles) {
    const Vector3d n =
        (surface.place[t[1]] - surface.place[t[0]]).cross(surface.place[t[2]] - surface.place[t[0]]);
    for (const int v : t) normals[v] += n;
  }
  for (std::size_t i = 0; i < vertices; ++i)
    if (normals[i].norm() > 0) surface.place[i] += thickness[i] * normals[i].normalized();
  return surface;
}

// --- SVG ------------------------------------------------------------------------------------------------------------

// Closed subpaths of M, L, C and Z, curves cut into 64 pieces.
std::vector<Line> closed_lines(const std::string& d) {
  std::string spaced;
  for (const char c : d)
    spaced += std::isalpha(static_cast<unsigned char>(c)) && c != 'e' && c != 'E' ? std::string(" ") + c + " "
              : c == ','                                                          ? std::string(" ")
                                                                                  : std::string(1, c);
  std::istringstream in(spaced);
  std::vector<Line> closed;
  Line line;
  std::string word;
  char command = 0;
  const auto number = [&] {
    std::string text;
    if (!(in >> text)) throw std::runtime_error("a path ends early");
    return std::stod(text);
  };
  const auto point = [&] {
    const double x = number();
    return Vector2d(x, number());
  };
  while (in >> std::ws && in.peek() != EOF) {
    if (std::isalpha(in.peek())) in >> command;
    if (command == 'Z' || command == 'z') {
      if (line.size() > 2) closed.push_back(line);
      line.clear();
      command = 0;
    } else if (command == 'M') {
      line.assign(1, point());
      command = 'L';
    } else if (command == 'L') {
      line.push_back(point());
    } else if (command == 'C') {
      const Vector2d a = line.back(), b = point(), c = point(), e = point();
      for (int i = 1; i <= 64; ++i) {
        const double x = i / 64.0, y = 1 - x;
        line.push_back(y * y * y * a + 3 * x * y * y * b + 3 * x * x * y * c + x * x * x * e);
      }
    } else {
      throw std::runtime_error("a path has other commands than M, L, C and Z");
    }
  }
  return closed;
}

double area_of(const Line& line) {
  double twice = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vector2d &p = line[i], &q = line[(i + 1) % line.size()];
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return twice / 2;
}
void keep_largest(Line& largest, const Line& line) {
  if (std::abs(area_of(line)) > std::abs(area_of(largest))) largest = line;
}

struct Drawn {
  std::string id;
  Line line;  // mm, y up
  double width_mm = 0;
};

double length_mm(const std::string& text) {
  if (text.ends_with("mm")) return std::stod(text);
  if (text.ends_with("cm")) return 10 * std::stod(text);
  return std::stod(text) * 25.4 / 96;
}

std::vector<Drawn> read_pattern(const std::string& name, double scale) {
  pugi::xml_document xml;
  if (!xml.load_file(name.c_str())) throw std::runtime_error(name + " is no SVG");
  const pugi::xml_node svg = xml.document_element();
  std::istringstream box(svg.attribute("viewBox").as_string());
  double x, y, w, h;
  if (!(box >> x >> y >> w >> h)) throw std::runtime_error(name + " has no viewBox");
  const double unit = scale * length_mm(svg.attribute("width").as_string()) / w;
  std::vector<Drawn> coils;
  for (const auto& found : svg.select_nodes("//*[local-name()='g'][@id]")) {
    Drawn coil{found.node().attribute("id").as_string(), {}, 0};
    for (const auto& child : found.node().select_nodes(".//*")) {
      const pugi::xml_node shape = child.node();
      Line line;
      const std::string kind = shape.name();
      if (kind == "circle" || kind == "ellipse") {
        const double rx = shape.attribute(kind == "circle" ? "r" : "rx").as_double();
        const double ry = shape.attribute(kind == "circle" ? "r" : "ry").as_double();
        for (int i = 0; i < 1440; ++i)
          line.emplace_back(shape.attribute("cx").as_double() + rx * std::cos(i * M_PI / 720),
                            shape.attribute("cy").as_double() + ry * std::sin(i * M_PI / 720));
      } else if (kind == "path") {
        for (const Line& closed : closed_lines(shape.attribute("d").as_string())) keep_largest(line, closed);
      }
      if (std::abs(area_of(line)) <= std::abs(area_of(coil.line))) continue;
      coil.line = line;
      coil.width_mm = unit * shape.attribute("stroke-width").as_double(1);
    }
    for (Vector2d& p : coil.line) p = unit * Vector2d(p.x() - x - w / 2, -(p.y() - y - h / 2));
    if (!coil.line.empty()) coils.push_back(coil);
  }
  return coils;
}

std::map<std::string, Line> read_print(const std::string& name) {
  pugi::xml_document xml;
  if (!xml.load_file(name.c_str())) throw std::runtime_error(name + " is no SVG");
  std::map<std::string, Line> loops;
  for (const auto& found : xml.select_nodes("//*[local-name()='g'][@id]"))
    for (const auto& child :
         found.node().select_nodes("./*[contains(concat(' ', @class, ' '), ' centreline ')]"))
      for (Line line : closed_lines(child.node().attribute("d").as_string())) {
        for (Vector2d& p : line) p.y() = -p.y();
        if (area_of(line) < 0) std::reverse(line.begin(), line.end());
        keep_largest(loops[found.node().attribute("id").as_string()], line);
      }
  return loops;
}

// --- the formed sheet -------------------------------------------------------------------------------------------------

struct OnSurface {
  int triangle = -1;
  Vector3d weights{0, 0, 0};
};

class Sheet {
 public:
  explicit Sheet(Surface surface) : s(std::move(surface)) {
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
      const auto low = cell(corner(t, 0).cwiseMin(corner(t, 1)).cwiseMin(corner(t, 2)));
      const auto high = cell(corner(t, 0).cwiseMax(corner(t, 1)).cwiseMax(corner(t, 2)));
      for (int i = low.first; i <= high.first; ++i)
        for (int j = low.second; j <= high.second; ++j) cells_[{i, j}].push_back(static_cast<int>(t));
    }
  }

  OnSurface find(const Vector2d& p) const {
    OnSurface best;
    double least = -1e-6;
    const auto found = cells_.find(cell(p));
    if (found == cells_.end()) throw std::runtime_error("a line leaves the sheet");
    for (const int t : found->second) {
      const auto k = static_cast<std::size_t>(t);
      Eigen::Matrix2d m;
      m << corner(k, 1) - corner(k, 0), corner(k, 2) - corner(k, 0);
      const Vector2d w = m.inverse() * (p - corner(k, 0));
      const Vector3d weights(1 - w.sum(), w.x(), w.y());
      if (weights.minCoeff() > least) least = weights.minCoeff(), best = {t, weights};
    }
    if (best.triangle < 0) throw std::runtime_error("a line leaves the sheet");
    return best;
  }
  Vector3d place(const OnSurface& at) const {
    const auto& t = s.triangles[static_cast<std::size_t>(at.triangle)];
    return at.weights[0] * s.place[t[0]] + at.weights[1] * s.place[t[1]] + at.weights[2] * s.place[t[2]];
  }
  Vector3d place(const Vector2d& p) const { return place(find(p)); }
  // Formed area over flat area.
  double growth(int triangle) const {
    const auto k = static_cast<std::size_t>(triangle);
    const auto& t = s.triangles[k];
    Eigen::Matrix2d m;
    m << corner(k, 1) - corner(k, 0), corner(k, 2) - corner(k, 0);
    return (s.place[t[1]] - s.place[t[0]]).cross(s.place[t[2]] - s.place[t[0]]).norm() /
           std::abs(m.determinant());
  }

  Surface s;

 private:
  static constexpr double cell_mm = 2;
  static std::pair<int, int> cell(const Vector2d& p) {
    return {static_cast<int>(std::floor(p.x() / cell_mm)), static_cast<int>(std::floor(p.y() / cell_mm))};
  }
  const Vector2d& corner(std::size_t t, std::size_t k) const { return s.rest[s.triangles[t][k]]; }
  std::map<std::pair<int, int>, std::vector<int>> cells_;
};

struct TooFar : std::runtime_error {
  TooFar() : std::runtime_error("a coil reaches farther than was looked") {}
};

// Exact distances within a ball about a place.
class Distances {
 public:
  Distances(const Sheet& sheet, const Vector3d& middle, double radius) : radius_(radius) {
    std::map<int, Mesh::Vertex_index> vertices;
    for (std::size_t t = 0; t < sheet.s.triangles.size(); ++t) {
      const auto& c = sheet.s.triangles[t];
      double least = 1e9, edge = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        least = std::min(least, (sheet.s.place[c[k]] - middle).norm());
        edge = std::max(edge, (sheet.s.place[c[k]] - sheet.s.place[c[(k + 1) % 3]]).norm());
      }
      if (least > radius + edge) continue;
      std::array<Mesh::Vertex_index, 3> v;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [found, is_new] = vertices.try_emplace(c[k]);
        const Vector3d& p = sheet.s.place[c[k]];
        if (is_new) found->second = mesh_.add_vertex({p.x(), p.y(), p.z()});
        v[k] = found->second;
      }
      if (const auto face = mesh_.add_face(v[0], v[1], v[2]); face != Mesh::null_face())
        faces_[static_cast<int>(t)] = {face, v};
    }
    paths_.emplace(mesh_);
  }

  // From one point to others, mm. Throws when they are farther than the ball is large.
  Eigen::VectorXd operator()(const OnSurface& from, const std::vector<OnSurface>& to) {
    paths_->remove_all_source_points();
    // CGAL errs from sources that all but lie on an edge.
    const auto source = location(from, 1e-5);
    paths_->add_source_point(source.first, source.second);
    Eigen::VectorXd out(static_cast<Eigen::Index>(to.size()));
    for (std::size_t i = 0; i < to.size(); ++i) {
      const auto target = location(to[i], 0);
      const double d = paths_->shortest_distance_to_source_points(target.first, target.second).first;
      if (!(d >= 0) || d > radius_) throw TooFar();
      out[static_cast<Eigen::Index>(i)] = d;
    }
    return out;
  }

 private:
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  using Traits = CGAL::Surface_mesh_shortest_path_traits<Kernel, Mesh>;

  std::pair<Mesh::Face_index, Traits::Barycentric_coordinates> location(const OnSurface& at,
                                                                        double least) const {
    const auto found = faces_.find(at.triangle);
    if (found == faces_.end()) throw TooFar();
    const auto& [face, v] = found->second;
    Vector3d w = at.weights.cwiseMax(least);
    w /= w.sum();
    const auto h = mesh_.halfedge(face);
    std::array<double, 3> in_order{};
    const std::array<Mesh::Vertex_index, 3> order{mesh_.source(h), mesh_.target(h),
                                                  mesh_.target(mesh_.next(h))};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k)
        if (order[i] == v[k]) in_order[i] = w[static_cast<Eigen::Index>(k)];
    return {face, {in_order[0], in_order[1], in_order[2]}};
  }

  double radius_;
  Mesh mesh_;
  std::map<int, std::pair<Mesh::Face_index, std::array<Mesh::Vertex_index, 3>>> faces_;
  std::optional<CGAL::Surface_mesh_shortest_path<Traits>> paths_;
};

// --- figures ----------------------------------------------------------------------------------------------------------

// `count` points along the closed line, evenly by length where `place` puts them.
template <class Place>
Line evenly(const Line& line, int count, Place&& place) {
  Line fine;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vector2d &a = line[i], &b = line[(i + 1) % line.size()];
    const int parts = std::max(1, static_cast<int>(std::ceil((b - a).norm() / 0.2)));
    for (int k = 0; k < parts; ++k) fine.push_back(a + (b - a) * k / parts);
  }
  std::vector<double> until{0};
  for (std::size_t i = 0; i < fine.size(); ++i)
    until.push_back(until.back() + (place(fine[(i + 1) % fine.size()]) - place(fine[i])).norm());
  Line out;
  std::size_t i = 0;
  for (int k = 0; k < count; ++k) {
    const double wanted = until.back() * k / count;
    while (until[i + 1] <= wanted) ++i;
    out.push_back(fine[i] +
                  (fine[(i + 1) % fine.size()] - fine[i]) * (wanted - until[i]) / (until[i + 1] - until[i]));
  }
  return out;
}

struct Round {
  Vector2d centre;
  Eigen::VectorXd radii;
  double diameter() const { return 2 * radii.mean(); }
  double circularity() const { return (radii.array() - radii.mean()).abs().maxCoeff() / radii.mean(); }
};

// The centre from which `radii_from` gives the most equal radii: Gauss and Newton, by differences taken once.
template <class Radii>
Round fit_centre(Vector2d centre, Radii&& radii_from) {
  constexpr double h = 0.4;
  Eigen::VectorXd r = radii_from(centre);
  Eigen::MatrixXd slopes(r.size(), 2);
  for (int k = 0; k < 2; ++k)
    slopes.col(k) =
        (radii_from(centre + h * Vector2d::Unit(k)) - radii_from(centre - h * Vector2d::Unit(k))) / (2 * h);
  const Eigen::MatrixXd centred = slopes.rowwise() - slopes.colwise().mean();
  for (int round = 0; round < 12; ++round) {
    const Eigen::VectorXd spread = r.array() - r.mean();
    const Vector2d move = -centred.colPivHouseholderQr().solve(spread);
    centre += move;
    r = radii_from(centre);
    if (move.norm() < 0.005) break;
  }
  return {centre, r};
}

// The surface inside of the loop: rows 0.05 mm apart, pieces of 0.1 mm.
double enclosed_area(const Sheet& sheet, const Line& line) {
  double low = line[0].y(), high = low, sum = 0;
  for (const Vector2d& p : line) low = std::min(low, p.y()), high = std::max(high, p.y());
  const int rows = static_cast<int>(std::ceil((high - low) / 0.05));
  const double height = (high - low) / rows;
  for (int j = 0; j < rows; ++j) {
    const double y = low + (j + 0.5) * height;
    std::vector<double> crossings;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Vector2d &a = line[i], &b = line[(i + 1) % line.size()];
      if ((a.y() <= y) != (b.y() <= y))
        crossings.push_back(a.x() + (b.x() - a.x()) * (y - a.y()) / (b.y() - a.y()));
    }
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
      const int parts = std::max(1, static_cast<int>(std::ceil((crossings[i + 1] - crossings[i]) / 0.1)));
      const double width = (crossings[i + 1] - crossings[i]) / parts;
      for (int k = 0; k < parts; ++k)
        sum += width * height * sheet.growth(sheet.find({crossings[i] + (k + 0.5) * width, y}).triangle);
    }
  }
  return sum;
}

double worst_stretch(const Sheet& sheet, const Line& line) {
  const Line even =
      evenly(line, std::max(8, static_cast<int>(4 * std::sqrt(4 * M_PI * std::abs(area_of(line))))),
             [](const Vector2d& p) { return p; });
  double worst = 0;
  for (std::size_t i = 0; i < even.size(); ++i) {
    double flat = 0, formed = 0;
    for (std::size_t k = i; k < i + 4; ++k) {
      const Vector2d &a = even[k % even.size()], &b = even[(k + 1) % even.size()];
      flat += (b - a).norm(), formed += (sheet.place(b) - sheet.place(a)).norm();
    }
    worst = std::max(worst, formed / flat);
  }
  return worst;
}

// Neumann's double integral with a softened distance, nH; of a loop with itself the softening is its strip's width / 4.
double neumann(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b, double softened) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vector3d p = (a[i] + a[(i + 1) % a.size()]) / 2, da = a[(i + 1) % a.size()] - a[i];
    for (std::size_t j = 0; j < b.size(); ++j) {
      const Vector3d q = (b[j] + b[(j + 1) % b.size()]) / 2;
      sum += da.dot(b[(j + 1) % b.size()] - b[j]) / std::sqrt((p - q).squaredNorm() + softened * softened);
    }
  }
  return 0.1 * sum;
}

struct Coil {
  Drawn drawn;
  Vector2d drawn_centre;
  double drawn_diameter = 0;
  Round formed;
  std::vector<Vector3d> line;  // in space, 1500 points
  double inductance = 0;
};

Coil measure(const Sheet& sheet, const Drawn& drawn, const Line& loop) {
  constexpr int rays = 180;
  const auto flat = [](const Vector2d& p) { return p; };
  Coil coil{drawn, {}, 0, {}, {}, 0};
  const Line drawn_even = evenly(drawn.line, rays, flat);
  const Round plane = fit_centre(Vector2d(drawn_even[0] + drawn_even[rays / 2]) / 2, [&](const Vector2d& c) {
    Eigen::VectorXd r(rays);
    for (int i = 0; i < rays; ++i) r[i] = (drawn_even[static_cast<std::size_t>(i)] - c).norm();
    return r;
  });
  coil.drawn_centre = plane.centre, coil.drawn_diameter = plane.diameter();

  const auto place = [&](const Vector2d& p) { return sheet.place(p); };
  for (const Vector2d& p : evenly(loop, 1500, place)) coil.line.push_back(sheet.place(p));
  std::vector<OnSurface> ends;
  for (const Vector2d& p : evenly(loop, rays, place)) ends.push_back(sheet.find(p));
  Vector2d middle(0, 0);
  for (const Vector2d& p : loop) middle += p / static_cast<double>(loop.size());
  double reach = 0;
  for (const OnSurface& end : ends) reach = std::max(reach, (sheet.place(end) - sheet.place(middle)).norm());
  // No path of a length leaves the ball of that radius about either of its ends.
  std::optional<Distances> distances;
  for (double room = 1.2; !distances; room *= 1.3) try {
      distances.emplace(sheet, sheet.place(middle), room * reach);
      coil.formed = fit_centre(middle, [&](const Vector2d& c) { return (*distances)(sheet.find(c), ends); });
    } catch (const TooFar&) {
      if (room > 4) throw;
      distances.reset();
    }
  coil.inductance = neumann(coil.line, coil.line, drawn.width_mm / 4);
  return coil;
}

struct Pair {
  std::size_t a, b;
  double drawn, mm;
};

double spacing_gain(const Sheet& sheet, const std::vector<Coil>& coils, const std::vector<Pair>& pairs) {
  constexpr int ways = 8;
  constexpr double step_mm = 0.5;
  double now = 0;
  for (const Pair& p : pairs) now += (p.mm - p.drawn) * (p.mm - p.drawn);
  // Per coil and way, the change of the sum of squares.
  std::vector<std::array<double, ways>> change(coils.size(), std::array<double, ways>{});
  const auto moved = [&](const Vector2d& c, int way) -> OnSurface {
    const Vector2d e(std::cos(way * 2 * M_PI / ways), std::sin(way * 2 * M_PI / ways));
    const double growth = (sheet.place(c + 0.2 * e) - sheet.place(c - 0.2 * e)).norm() / 0.4;
    return sheet.find(c + step_mm / growth * e);
  };
  for (std::size_t i = 0; i < coils.size(); ++i) {
    double reach = 0;
    for (const Pair& p : pairs)
      if (p.a == i || p.b == i) reach = std::max(reach, p.mm);
    const OnSurface from = sheet.find(coils[i].formed.centre);
    Distances distances(sheet, sheet.place(from), 1.05 * reach + 2 * step_mm);
    std::vector<OnSurface> to;
    for (const Pair& p : pairs)
      for (int way = 0; way < ways && (p.a == i || p.b == i); ++way)
        to.push_back(moved(coils[p.a == i ? p.b : p.a].formed.centre, way));
    const Eigen::VectorXd mm = distances(from, to);
    Eigen::Index next = 0;
    for (const Pair& p : pairs)
      for (int way = 0; way < ways && (p.a == i || p.b == i); ++way, ++next)
        change[p.a == i ? p.b : p.a][static_cast<std::size_t>(way)] +=
            (mm[next] - p.drawn) * (mm[next] - p.drawn) - (p.mm - p.drawn) * (p.mm - p.drawn);
  }
  double gain = 0;
  for (const auto& of_coil : change)
    for (const double d : of_coil) gain = std::max(gain, -d / now);
  return gain;
}

Json run(const std::string& ply, const std::string& print, const std::string& pattern, bool outer,
         double scale, bool spacing, bool couplings, bool lines) {
  const Sheet sheet(read_ply(ply, outer));
  const auto drawn = read_pattern(pattern, scale);
  const auto loops = read_print(print);
  std::vector<Coil> coils;
  Json out{{"coils", Json::array()}, {"missing", Json::array()}, {"pairs", Json::array()}};
  std::vector<Pair> pairs;
  double circularity = 0, worst_circularity = 0, area = 0, worst_area = 0, squares = 0;
  for (const Drawn& d : drawn) {
    const auto loop = loops.find(d.id);
    if (loop == loops.end()) {
      out["missing"].push_back(d.id);
      continue;
    }
    const Coil coil = measure(sheet, d, loop->second);
    const double area_mm2 = enclosed_area(sheet, loop->second),
                 error = area_mm2 / std::abs(area_of(d.line)) - 1;
    const double off = coil.formed.circularity();
    out["coils"].push_back({{"id", d.id},
                            {"drawn_diameter_mm", coil.drawn_diameter},
                            {"diameter_mm", coil.formed.diameter()},
                            {"circularity", off},
                            {"area_mm2", area_mm2},
                            {"area_error", error},
                            {"worst_stretch", worst_stretch(sheet, loop->second)},
                            {"inductance_nh", coil.inductance}});
    if (lines) {
      Json& line = out["coils"].back()["line"] = Json::array();
      for (std::size_t i = 0; i < coil.line.size(); i += coil.line.size() / 60)
        line.push_back({coil.line[i].x(), coil.line[i].y(), coil.line[i].z()});
      out["coils"].back()["trace_mm"] = d.width_mm;
    }
    circularity += off, worst_circularity = std::max(worst_circularity, off);
    area += std::abs(error), worst_area = std::max(worst_area, std::abs(error));
    coils.push_back(coil);
  }
  for (std::size_t a = 0; a < coils.size(); ++a)
    for (std::size_t b = a + 1; b < coils.size(); ++b) {
      const double apart = (coils[a].drawn_centre - coils[b].drawn_centre).norm();
      const double radii = (coils[a].drawn_diameter + coils[b].drawn_diameter) / 2;
      if (apart > 1.15 * radii) continue;
      const OnSurface p = sheet.find(coils[a].formed.centre), q = sheet.find(coils[b].formed.centre);
      Distances distances(sheet, sheet.place(p), 1.8 * (sheet.place(p) - sheet.place(q)).norm());
      const double mm = distances(p, {q})[0];
      const double formed_radii = (coils[a].formed.diameter() + coils[b].formed.diameter()) / 2;
      out["pairs"].push_back({{"coils", {coils[a].drawn.id, coils[b].drawn.id}},
                              {"drawn_distance_mm", apart},
                              {"distance_mm", mm},
                              {"overlap_mm", formed_radii - mm},
                              {"k", neumann(coils[a].line, coils[b].line, 0.1) /
                                        std::sqrt(coils[a].inductance * coils[b].inductance)}});
      squares += (mm - apart) * (mm - apart);
      pairs.push_back({a, b, apart, mm});
    }
  if (couplings) {
    Json& all = out["couplings"] = Json::array();
    for (std::size_t a = 0; a < coils.size(); ++a)
      for (std::size_t b = a + 1; b < coils.size(); ++b)
        all.push_back({{"coils", {coils[a].drawn.id, coils[b].drawn.id}},
                       {"k", neumann(coils[a].line, coils[b].line, 0.1) /
                                 std::sqrt(coils[a].inductance * coils[b].inductance)}});
  }
  if (spacing) out["spacing_gain"] = spacing_gain(sheet, coils, pairs);
  const double n = std::max<double>(1, static_cast<double>(coils.size()));
  out["mean_circularity"] = circularity / n, out["worst_circularity"] = worst_circularity;
  out["mean_area_error"] = area / n, out["worst_area_error"] = worst_area;
  out["spacing_rms_mm"] = std::sqrt(squares / std::max<double>(1, static_cast<double>(out["pairs"].size())));
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> names;
  bool outer = true, spacing = false, couplings = false, lines = false;
  double scale = 1;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--inner")
      outer = false;
    else if (word == "--spacing")
      spacing = true;
    else if (word == "--couplings")
      couplings = true;
    else if (word == "--lines")
      lines = true;
    else if (word == "--scale" && i + 1 < argc)
      scale = std::atof(argv[++i]);
    else
      names.push_back(word);
  }
  if (names.size() != 3) {
    std::cerr << "usage: measure_coils FORMED.PLY PRINT.SVG PATTERN.SVG [--inner] [--scale X] [--spacing] "
                 "[--couplings] [--lines]\n";
    return 2;
  }
  try {
    std::cout << run(names[0], names[1], names[2], outer, scale, spacing, couplings, lines).dump(2) << "\n";
  } catch (const std::exception& fault) {
    std::cerr << "measure_coils: " << fault.what() << "\n";
    return 2;
  }
  return 0;
}
