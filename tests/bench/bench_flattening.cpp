// Processor seconds, energies and flips of every method of flattening, beside CGAL's ARAP in the same run.
//
//   bench_flattening [--json] [vertices a side ...]     (101 201 when none is given)
//
// For each grid of a 300 mm sheet: a dome that the whole sheet lies on (201 a side: 80,000 triangles); the region of
// interest of neonate-40w; and that region with a weight of 10 on the ink of rings-19x40mm and towards the top, with the
// energy where the weight is before and after. Then flattening and a print of about 7000 x 7000 gray pixels, as the
// pipeline makes it. All on one core. `of cgal` is CGAL's seconds over this method's, `part` the energy where the weight is.
#include <sched.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "worker/flattening/methods.hpp"
#include "worker/forming/inked_face.hpp"
#include "worker/placement/alignment.hpp"
#include "worker/printing/print.hpp"

namespace {

using namespace vacuform;
using Bytes = std::vector<std::uint8_t>;

struct Row {
  std::string surface, method;
  int side = 0;
  std::size_t triangles = 0;
  double seconds = 0, arap = NAN, dirichlet = NAN, part_before = NAN, part_after = NAN;
  int iterations = 0, flipped = 0;
};

// Of this process, so that what else the machine does hardly tells.
double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

[[noreturn]] void stop(const std::string& why) {
  std::fprintf(stderr, "bench_flattening: %s\n", why.c_str());
  std::exit(1);
}

Bytes read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  if (bytes.empty()) stop("cannot read " + path + "; see tests/fetch-scans");
  return bytes;
}

const char* name_of(FlatteningMethod method) {
  switch (method) {
    case FlatteningMethod::arap:
      return "arap";
    case FlatteningMethod::symmetric_dirichlet:
      return "symmetric_dirichlet";
    case FlatteningMethod::lscm:
      return "lscm";
    case FlatteningMethod::cgal_arap:
      return "cgal_arap";
    case FlatteningMethod::bfs:
      return "bfs";
  }
  return "";
}

// A sheet of side x side vertices that lies wholly on a dome of 85 mm, down to 80 degrees in its corners.
FormedSheet dome(int side) {
  FormedSheet sheet;
  const auto at = [&](int i) { return 300.0 * i / (side - 1) - 150; };
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const Eigen::Vector2d st(at(i), at(j));
      const double polar = 1.4 * st.norm() / (150 * std::sqrt(2));
      const Eigen::Vector2d along = st.norm() > 0 ? Eigen::Vector2d(st.normalized()) : Eigen::Vector2d(1, 0);
      sheet.rest.push_back(st);
      sheet.formed.emplace_back(85 * std::sin(polar) * along.x(), 85 * std::sin(polar) * along.y(),
                                85 * std::cos(polar));
    }
  for (int j = 0; j + 1 < side; ++j)
    for (int i = 0; i + 1 < side; ++i) {
      const int a = j * side + i, b = a + 1, d = a + side, c = d + 1;
      if ((i + j) % 2 == 0)
        sheet.triangles.insert(sheet.triangles.end(), {Triangle{a, b, c}, Triangle{a, c, d}});
      else
        sheet.triangles.insert(sheet.triangles.end(), {Triangle{a, b, d}, Triangle{b, c, d}});
    }
  sheet.thickness.assign(sheet.rest.size(), 1);
  sheet.contact.assign(sheet.rest.size(), Contact::mold);
  return sheet;
}

class Bench {
  std::vector<Row> rows_;

 public:
  Flattening measure(const std::string& surface, int side, const FormedSheet& sheet, const Mold& mold,
                     const FlatteningSettings& settings, const std::string& more = "",
                     const InkCoverage& ink = {}) {
    const double start = cpu_seconds();
    auto made = flatten(sheet, inked_surface(sheet, InkedFace::outer), mold, settings, Context{}, ink);
    const double seconds = cpu_seconds() - start;
    if (!made) stop(made.error().text());
    Row row;
    row.surface = surface, row.method = name_of(settings.method) + more, row.side = side;
    row.triangles = made->triangles.size(), row.seconds = seconds;
    row.arap = made->energy, row.dirichlet = made->symmetric_dirichlet;
    row.iterations = made->iterations, row.flipped = made->flipped;
    rows_.push_back(row);
    return std::move(*made);
  }

  void every_method(const std::string& surface, int side, const FormedSheet& sheet, const Mold& mold) {
    for (const auto method :
         {FlatteningMethod::cgal_arap, FlatteningMethod::arap, FlatteningMethod::symmetric_dirichlet,
          FlatteningMethod::lscm, FlatteningMethod::bfs}) {
      FlatteningSettings settings;
      settings.method = method;
      measure(surface, side, sheet, mold, settings);
    }
  }

  // The energy where the weight is, with an even chart and with the weighted one.
  void weighted(int side, const FormedSheet& sheet, const Mold& mold, const InkCoverage& ink) {
    for (const auto method : {FlatteningMethod::arap, FlatteningMethod::symmetric_dirichlet})
      for (const auto weights : {FlatteningWeights::ink, FlatteningWeights::center}) {
        FlatteningSettings settings;
        settings.method = method;
        const InkedSurface surface = inked_surface(sheet, InkedFace::outer);
        const auto even = flatten(sheet, surface, mold, settings, Context{});
        if (!even) stop(even.error().text());
        settings.weights = weights;
        const auto made = measure("neonate-40w", side, sheet, mold, settings,
                                  weights == FlatteningWeights::ink ? ", ink" : ", center", ink);
        Chart before{{}, surface.inked(), even->chart};
        for (std::size_t k = 0; k < made.triangles.size(); ++k)
          if (made.favoured[k]) before.triangles.push_back(sheet.triangles[made.triangles[k]]);
        rows_.back().part_before = chart_quality(before).arap;
        rows_.back().part_after = made.energy_favoured;
      }
  }

  void with_print(int side, const FormedSheet& sheet, const Mold& mold, const Settings& settings,
                  const Pattern& pattern) {
    const double start = cpu_seconds();
    const InkedSurface surface = inked_surface(sheet, InkedFace::outer);
    const auto flat = flatten(sheet, surface, mold, settings.flattening, Context{});
    if (!flat) stop(flat.error().text());
    const auto placement = place(ChartedSurface(surface, *flat), nullptr, settings, Context{});
    if (!placement) stop(placement.error().text());
    const auto print = make_print(
        {.charted = ChartedSurface(surface, *flat),
         .placement = *placement,
         .settings = settings,
         .label = {"benchmark"},
         .layers = {{.name = "print", .source = picture_layer(pattern, *placement, nullptr, false)}}},
        Context{});
    if (!print) stop(print.error().text());
    Row row;
    row.surface = "neonate-40w", row.side = side, row.triangles = flat->triangles.size();
    row.method =
        "arap, print " + std::to_string(print->grid.width) + " x " + std::to_string(print->grid.height);
    row.seconds = cpu_seconds() - start;
    rows_.push_back(row);
  }

  void print_table() const {
    std::printf("%-12s %5s %9s  %-28s %8s %8s %5s %9s %9s %6s %9s %9s\n", "surface", "side", "triangles",
                "method", "CPU s", "of cgal", "its", "arap", "dirichlet", "flips", "part was", "part is");
    double cgal = NAN;
    for (const Row& r : rows_) {
      if (r.method == "cgal_arap") cgal = r.seconds;
      std::printf("%-12s %5d %9zu  %-28s %8.3f %8.1f %5d %9.6f %9.5f %6d %9.6f %9.6f\n", r.surface.c_str(),
                  r.side, r.triangles, r.method.c_str(), r.seconds, cgal / r.seconds, r.iterations, r.arap,
                  r.dirichlet, r.flipped, r.part_before, r.part_after);
    }
  }

  void print_json() const {
    auto list = nlohmann::ordered_json::array();  // what is not a number is null
    for (const Row& r : rows_)
      list.push_back({{"surface", r.surface},
                      {"vertices_a_side", r.side},
                      {"triangles", r.triangles},
                      {"method", r.method},
                      {"cpu_seconds", r.seconds},
                      {"iterations", r.iterations},
                      {"arap", r.arap},
                      {"symmetric_dirichlet", r.dirichlet},
                      {"flipped", r.flipped},
                      {"part_arap_before", r.part_before},
                      {"part_arap", r.part_after}});
    std::printf("%s\n", list.dump(2).c_str());
  }
};

}  // namespace

int main(int argc, char** argv) {
  bool json = false;
  std::vector<int> sides;
  for (int i = 1; i < argc; ++i)
    if (std::string_view(argv[i]) == "--json")
      json = true;
    else
      sides.push_back(std::atoi(argv[i]));
  if (sides.empty()) sides = {101, 201};
  for (const int side : sides)
    if (side < 16 || side > 601) {
      std::fprintf(stderr, "usage: bench_flattening [--json] [vertices a side, 16 to 601 ...]\n");
      return 2;
    }

  Settings settings;
  settings.pattern.placement = PatternPlacement::chart;
  settings.print.dpi = 593;  // 300 mm in 7004 pixels
  const auto mold = make_mold(read(VACUFORM_SHARED_DATA "/scans/neonate-40w.stl"), "neonate-40w.stl",
                              settings.scan, Context{});
  if (!mold) stop(mold.error().text());
  const auto pattern = Pattern::read(read(VACUFORM_RING_FILES "/rings-19x40mm.svg"), "rings-19x40mm.svg",
                                     settings.pattern, settings.print.dpi);
  if (!pattern) stop(pattern.error().text());
  const InkCoverage ink = [&](const Eigen::Vector2d& chart, double blur_mm) {
    return pattern->sample(plain_alignment(settings.pattern).pattern(chart), blur_mm).coverage();
  };

  Bench bench;
  for (const int side : sides) {
    settings.sheet.resolution_mm = settings.sheet.width_mm / (side - 1);
    const auto sheet =
        form(*mold, settings.sheet, settings.machine, settings.forming, TemperatureField(140), Context{});
    if (!sheet) stop(sheet.error().text());
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(0, &one);
    sched_setaffinity(0, sizeof one, &one);
    Mold top;
    top.top = {0, 0, 85};
    bench.every_method("dome", side, dome(side), top);
    bench.every_method("neonate-40w", side, *sheet, *mold);
    bench.weighted(side, *sheet, *mold, ink);
    bench.with_print(side, *sheet, *mold, settings, *pattern);
  }
  json ? bench.print_json() : bench.print_table();
}
