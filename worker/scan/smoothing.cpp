#include "worker/scan/smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "worker/scan/topology.hpp"

namespace vacuform {
namespace {

using Vectors = std::vector<Eigen::Vector3d>;

constexpr double gain = 1.36;  // of the second umbrella difference for white noise, six neighbours each
constexpr double median_of_normal = 0.6745;  // of the absolute value, in standard deviations
constexpr int most_steps = 300;
constexpr double noise_share = 0.002;      // of the radius
constexpr double coarse_share = 1.0 / 12;  // of the radius: longer edges are those of a model
constexpr double facet_share = 0.05;       // of an edge: facets look like noise of 3 % of their length

// The neighbours of each vertex, as offsets into one list; a vertex of a border has none.
struct Neighbours {
  std::vector<int> first, of;
  std::size_t count(std::size_t v) const { return static_cast<std::size_t>(first[v + 1] - first[v]); }
};

Neighbours inner_neighbours(const TriangleMesh& mesh) {
  const auto uses = edge_uses(mesh);
  const std::size_t n = mesh.vertices.size();
  std::vector<char> border(n, 0);
  std::vector<std::pair<int, int>> edges;
  for (std::size_t i = 0, next; i < uses.size(); i = next) {
    for (next = i + 1;
         next < uses.size() && uses[next].low == uses[i].low && uses[next].high == uses[i].high;)
      ++next;
    edges.emplace_back(uses[i].low, uses[i].high);
    if (next != i + 2) border[uses[i].low] = border[uses[i].high] = 1;
  }
  Neighbours neighbours;
  neighbours.first.assign(n + 1, 0);
  for (const auto& [a, b] : edges)
    for (const int v : {a, b})
      if (!border[v]) ++neighbours.first[static_cast<std::size_t>(v) + 1];
  for (std::size_t v = 0; v < n; ++v) neighbours.first[v + 1] += neighbours.first[v];
  std::vector<int> at(neighbours.first.begin(), neighbours.first.end() - 1);
  neighbours.of.resize(static_cast<std::size_t>(neighbours.first.back()));
  for (const auto& [a, b] : edges) {
    if (!border[a]) neighbours.of[at[static_cast<std::size_t>(a)]++] = b;
    if (!border[b]) neighbours.of[at[static_cast<std::size_t>(b)]++] = a;
  }
  return neighbours;
}

// The degree of each inner vertex times the umbrella operator: its degree times x minus the sum of its neighbours. Zero
// at borders. Symmetric in the inner vertices.
void umbrella(const Neighbours& neighbours, const Vectors& x, Vectors& out) {
  for (std::size_t v = 0; v < x.size(); ++v) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int i = neighbours.first[v]; i < neighbours.first[v + 1]; ++i)
      sum += x[neighbours.of[static_cast<std::size_t>(i)]];
    out[v] = neighbours.count(v) > 0 ? Eigen::Vector3d(static_cast<double>(neighbours.count(v)) * x[v] - sum)
                                     : Eigen::Vector3d::Zero();
  }
}
void divide_by_degree(const Neighbours& neighbours, Vectors& x) {
  for (std::size_t v = 0; v < x.size(); ++v)
    if (neighbours.count(v) > 0) x[v] /= static_cast<double>(neighbours.count(v));
}

double inner_product(const Vectors& a, const Vectors& b) {
  double sum = 0;
  for (std::size_t v = 0; v < a.size(); ++v) sum += a[v].dot(b[v]);
  return sum;
}

double mean_edge(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) sum += (mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm();
  return sum / (3 * static_cast<double>(std::max<std::size_t>(1, mesh.triangles.size())));
}

}  // namespace

double noise_of(const TriangleMesh& mesh) {
  const Neighbours neighbours = inner_neighbours(mesh);
  const std::size_t n = mesh.vertices.size();
  // The normals of the surface averaged over a few neighbours: those of a noisy one point anywhere.
  Vectors normal(n, Eigen::Vector3d::Zero()), next = normal;
  for (const auto& t : mesh.triangles)
    for (const int v : t) normal[v] += area_vector(mesh, t);
  for (int round = 0; round < 4; ++round) {
    for (std::size_t v = 0; v < n; ++v) {
      next[v] = normal[v];
      for (int i = neighbours.first[v]; i < neighbours.first[v + 1]; ++i)
        next[v] += normal[neighbours.of[static_cast<std::size_t>(i)]];
    }
    normal.swap(next);
  }
  Vectors once(n), twice(n);
  umbrella(neighbours, mesh.vertices, once);
  divide_by_degree(neighbours, once);
  umbrella(neighbours, once, twice);
  divide_by_degree(neighbours, twice);
  std::vector<double> sizes;
  for (std::size_t v = 0; v < n; ++v) {
    bool inner = neighbours.count(v) > 0 && normal[v].norm() > 0;
    for (int i = neighbours.first[v]; inner && i < neighbours.first[v + 1]; ++i)
      inner = neighbours.count(static_cast<std::size_t>(neighbours.of[i])) > 0;
    if (inner) sizes.push_back(std::abs(twice[v].dot(normal[v].normalized())));
  }
  if (sizes.empty()) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle / (gain * median_of_normal);
}

Result<TriangleMesh> smoothed(const TriangleMesh& mesh, double noise_mm, double target_mm, double longest_mm,
                              const ScanProgress& progress) {
  // On a hexagonal lattice of edge h, a wave of q radians an edge has the eigenvalue q^2 / 4 of L, and the waves up to q
  // are q^2 sqrt(3) / (8 pi) of all.
  const double share = std::pow(target_mm / noise_mm, 2);
  const double shortest = 2 * std::numbers::pi * mean_edge(mesh) / longest_mm;
  const double k = std::max(2 * std::numbers::pi / std::sqrt(3.0) * share, shortest * shortest / 4);
  if (k >= 1) return mesh;
  const double weight = 1 / (k * k);
  const Neighbours neighbours = inner_neighbours(mesh);
  const std::size_t n = mesh.vertices.size();
  // Solves (D + weight Lg D^-1 Lg) y = -weight Lg D^-1 Lg x0 for the shift y, with D the degrees and Lg = D L.
  Vectors work(n), image(n);
  const auto bend = [&](const Vectors& x, Vectors& out) {
    umbrella(neighbours, x, work);
    divide_by_degree(neighbours, work);
    umbrella(neighbours, work, out);
    for (auto& p : out) p *= weight;
  };
  Vectors shift(n, Eigen::Vector3d::Zero()), residual(n), precise(n), step;
  bend(mesh.vertices, residual);
  for (auto& p : residual) p = -p;
  precise = residual;
  divide_by_degree(neighbours, precise);
  step = precise;
  double size = inner_product(residual, precise);
  const double enough = 1e-8 * size;
  for (int round = 0; round < most_steps && size > enough; ++round) {
    if (round % 16 == 0) VACUFORM_CHECK(progress.tick());
    bend(step, image);
    for (std::size_t v = 0; v < n; ++v) image[v] += static_cast<double>(neighbours.count(v)) * step[v];
    const double along = size / inner_product(step, image);
    for (std::size_t v = 0; v < n; ++v) shift[v] += along * step[v], residual[v] -= along * image[v];
    precise = residual;
    divide_by_degree(neighbours, precise);
    const double smaller = inner_product(residual, precise);
    for (std::size_t v = 0; v < n; ++v) step[v] = precise[v] + smaller / size * step[v];
    size = smaller;
  }
  TriangleMesh smooth = mesh;
  for (std::size_t v = 0; v < n; ++v) smooth.vertices[v] += shift[v];
  return smooth;
}

bool has_long_edges(const TriangleMesh& mesh, double radius) {
  return mean_edge(mesh) > coarse_share * radius;
}

bool is_rough(const TriangleMesh& mesh, double radius) {
  const double edge = mean_edge(mesh);
  return edge <= coarse_share * radius &&
         noise_of(mesh) >= std::max(noise_share * radius, facet_share * edge);
}

Result<std::optional<TriangleMesh>> without_noise(const TriangleMesh& mesh, double radius,
                                                  const ScanProgress& progress) {
  if (!is_rough(mesh, radius)) return std::nullopt;
  VACUFORM_TRY(smooth, smoothed(mesh, noise_of(mesh), noise_share / 3 * radius, radius, progress));
  return smooth;
}

}  // namespace vacuform
