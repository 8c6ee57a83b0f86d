// Seconds and peak memory by stage, for the bundled sample and for a real neonate's head, at default
// settings.
//
//   bench_stages [--json]
//
// Peak memory is the process's resident peak within the stage (Linux: clear_refs and VmHWM), inputs included.
#include <cstdio>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tests/bench/step_cost.hpp"
#include "worker/coils/coupled_neighbours.hpp"
#include "worker/forming/inked_face.hpp"
#include "worker/inspection/inspection.hpp"
#include "worker/sample/sample.hpp"
#include "worker/surface/stl.hpp"

namespace {

using namespace vacuform;
using Bytes = std::vector<std::uint8_t>;

struct Row {
  std::string head, stage, made;  // made: what came out, with its size
  StepCost cost;
};

std::string count(std::size_t n, const char* unit) { return std::to_string(n) + " " + unit; }

class Bench {
  std::vector<Row> rows;

  template <class Stage>
  auto measure(const std::string& head, const std::string& stage_name, const Stage& stage) {
    StepCost cost;
    auto made = measured("bench_stages: " + head + ", " + stage_name, stage, cost);
    rows.push_back({head, stage_name, "", cost});
    return made;
  }

 public:
  // Runs the stages on one head.
  void run(const std::string& head, const Bytes& scan, const std::string& pattern_name,
           const Bytes& drawing) {
    const Settings settings;
    const Context context;
    const auto mold =
        measure(head, "scan", [&] { return make_mold(scan, head + ".stl", settings.scan, context); });
    rows.back().made = count(mold.mesh.triangles.size(), "triangles");

    const auto sheet = measure(head, "forming", [&] {
      return form(mold, settings.sheet, settings.machine, settings.forming, TemperatureField(140), context);
    });
    rows.back().made = count(sheet.triangles.size(), "triangles");

    const InkedSurface surface = inked_surface(sheet, settings.pattern.inked_face);
    const auto flattening = measure(
        head, "flattening", [&] { return flatten(sheet, surface, mold, settings.flattening, context); });
    const ChartedSurface charted(surface, flattening);
    char text[96];
    std::snprintf(text, sizeof text, "%zu triangles, energy %.5f", flattening.triangles.size(),
                  flattening.energy);
    rows.back().made = text;

    const auto pattern = measure(head, "pattern", [&] {
      return Pattern::read(drawing, pattern_name, settings.pattern, settings.print.dpi);
    });
    rows.back().made = pattern.format();
    std::vector<Warning> of_drawing;
    const auto lines = read_drawing(pattern, of_drawing);
    const auto placement = measure(head, "placement", [&]() -> Result<Placement> {
      VACUFORM_TRY(placed, place(charted, lines ? &*lines : nullptr, settings, context));
      if (lines) VACUFORM_CHECK(add_couplings(charted, *lines, settings, context, placed));
      return placed;
    });
    rows.back().made = count(placement.elements.size(), "elements");
    const auto print = measure(head, "printing", [&]() -> Result<Print> {
      std::shared_ptr<const LayerSource> source;
      if (lines) {
        VACUFORM_TRY(drawn, drawing_layer(pattern, *lines, placement, settings, context));
        source = std::move(drawn);
      } else {
        source = picture_layer(pattern, placement, nullptr, false);
      }
      return make_print({.charted = charted,
                         .placement = placement,
                         .settings = settings,
                         .label = {"benchmark"},
                         .layers = {{.name = "print", .source = std::move(source)}}},
                        context);
    });
    rows.back().made = count(print.main().files.png.size() / 1024, "KiB of print.png");

    Finished finished{.settings = settings,
                      .mold = mold,
                      .sheet = sheet,
                      .surface = surface,
                      .flattening = flattening,
                      .pattern = pattern,
                      .placement = placement,
                      .print = print};
    const auto files = measure(head, "inspection", [&] {
      add_chart_figures(finished);
      report(finished);
      return artifacts(finished, context);
    });
    std::size_t bytes = 0;
    for (const auto& file : files) bytes += file.bytes.size();
    rows.back().made = count(bytes / 1024, "KiB of artifacts");
  }

  void print_table() const {
    std::printf("%-14s %-18s %9s %9s %9s  %s\n", "head", "stage", "s", "CPU s", "peak MiB", "made");
    std::string head;
    double total = 0;
    for (const auto& row : rows) {
      std::printf("%-14s %-18s %9.3f %9.3f %9.0f  %s\n", row.head == head ? "" : row.head.c_str(),
                  row.stage.c_str(), row.cost.seconds, row.cost.cpu_seconds, row.cost.peak_mib,
                  row.made.c_str());
      head = row.head;
      total += row.cost.seconds;
    }
    std::printf("%-14s %-18s %9.3f\n", "all", "", total);
  }

  void print_json() const {
    auto list = nlohmann::ordered_json::array();
    for (const auto& row : rows)
      list.push_back({{"head", row.head},
                      {"stage", row.stage},
                      {"seconds", row.cost.seconds},
                      {"cpu_seconds", row.cost.cpu_seconds},
                      {"peak_mib", row.cost.peak_mib},
                      {"made", row.made}});
    std::printf("%s\n", list.dump(2).c_str());
  }
};

Bytes read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  if (bytes.empty())
    std::fprintf(stderr, "bench_stages: cannot read %s; see tests/fetch-scans\n", path.c_str());
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  const bool json = argc == 2 && std::string_view(argv[1]) == "--json";
  if (argc > 1 && !json) {
    std::fprintf(stderr, "usage: bench_stages [--json]\n");
    return 2;
  }
  const Bytes neonate = read(VACUFORM_SHARED_DATA "/scans/neonate-40w.stl");
  const Bytes rings = read(VACUFORM_RING_FILES "/rings-19x40mm.svg");
  const std::string coils = sample_pattern();

  Bench bench;
  bench.run("sample", stl_bytes(sample_head()), "pattern.svg", Bytes(coils.begin(), coils.end()));
  if (!neonate.empty()) bench.run("neonate-40w", neonate, "rings-19x40mm.svg", rings);
  json ? bench.print_json() : bench.print_table();
}
