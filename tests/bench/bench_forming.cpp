// Seconds, steps, residual and memory of the forming stage against the grid, and the order of growth.
//
//   bench_forming [--json] [--fast] [cells a side ...]     (50 for the preview, then 100 200 400 when none is given)
//
// Each grid of a 300 mm sheet over neonate-40w and adult-scalp, at default settings or with forming.quality=fast, in a process of its own: its peak
// memory is that of forming alone, with the mold. `order` is the exponent b of seconds ~ vertices^b against the row above.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "worker/forming/formed_sheet.hpp"

namespace {

using namespace vacuform;

// What the child tells the parent.
struct Row {
  bool formed = false;
  double seconds = 0, residual = 0;
  int vertices = 0, drape_steps = 0, vacuum_steps = 0, iterations = 0;
};

Row form_in_this_process(const std::string& scan, int cells, FormingQuality quality) {
  std::ifstream in(std::string(VACUFORM_SHARED_DATA) + "/scans/" + scan, std::ios::binary);
  if (!in) {
    std::fprintf(stderr, "bench_forming: cannot read the real scan %s; see tests/fetch-scans\n",
                 scan.c_str());
    return {};
  }
  const std::vector<std::uint8_t> bytes((std::istreambuf_iterator<char>(in)), {});
  Settings settings;
  settings.sheet.resolution_mm = settings.sheet.width_mm / cells;
  settings.forming.quality = quality;
  const auto mold = make_mold(bytes, scan, settings.scan, Context{});
  if (!mold) {
    std::fprintf(stderr, "%s\n", mold.error().text().c_str());
    return {};
  }
  const auto start = std::chrono::steady_clock::now();
  const auto sheet =
      form(*mold, settings.sheet, settings.machine, settings.forming, TemperatureField(140), Context{});
  Row row;
  row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!sheet) {
    std::fprintf(stderr, "%s\n", sheet.error().text().c_str());
    return row;
  }
  const FormingSummary& s = sheet->summary;
  row.formed = true;
  row.residual = s.residual;
  row.vertices = static_cast<int>(sheet->rest.size());
  row.drape_steps = s.drape_steps, row.vacuum_steps = s.vacuum_steps, row.iterations = s.iterations;
  return row;
}

// The row, and the peak memory of the process that made it in MiB.
std::pair<Row, double> measure(const std::string& scan, int cells, FormingQuality quality) {
  int channel[2];
  if (pipe(channel) != 0) std::abort();
  const pid_t child = fork();
  if (child < 0) std::abort();
  if (child == 0) {
    const Row row = form_in_this_process(scan, cells, quality);
    _exit(write(channel[1], &row, sizeof row) == sizeof row ? 0 : 1);
  }
  close(channel[1]);
  Row row;
  if (read(channel[0], &row, sizeof row) != sizeof row) row = {};
  close(channel[0]);
  rusage usage{};
  wait4(child, nullptr, 0, &usage);
  return {row, static_cast<double>(usage.ru_maxrss) / 1024};
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false;
  FormingQuality quality = FormingQuality::standard;
  std::vector<int> sizes;
  for (int i = 1; i < argc; ++i)
    if (std::string_view(argv[i]) == "--json")
      json = true;
    else if (std::string_view(argv[i]) == "--fast")
      quality = FormingQuality::fast;
    else
      sizes.push_back(std::atoi(argv[i]));
  if (sizes.empty()) sizes = {50, 100, 200, 400};

  auto rows = nlohmann::ordered_json::array();
  if (!json)
    std::printf("%-22s %7s %8s %8s %6s %7s %6s %9s %7s %6s\n", "scan", "a side", "vertices", "seconds",
                "drape", "vacuum", "its", "residual", "MiB", "order");
  bool all_formed = true;
  for (const std::string scan : {"neonate-40w.stl", "adult-scalp-ascii.ply"}) {
    Row before;
    for (const int cells : sizes) {
      if (cells < 15 || cells > 600) {
        std::fprintf(stderr, "a grid has 15 to 600 cells a side\n");
        return 2;
      }
      const auto [row, mib] = measure(scan, cells, quality);
      all_formed = all_formed && row.formed;
      const double order = before.formed && row.formed ? std::log(row.seconds / before.seconds) /
                                                             std::log(double(row.vertices) / before.vertices)
                                                       : std::nan("");
      if (json)
        rows.push_back(
            {{"scan", scan},
             {"cells_a_side", cells},
             {"vertices", row.vertices},
             {"formed", row.formed},
             {"seconds", row.seconds},
             {"drape_steps", row.drape_steps},
             {"vacuum_steps", row.vacuum_steps},
             {"iterations", row.iterations},
             {"residual", row.residual},
             {"peak_mib", mib},
             {"order", std::isnan(order) ? nlohmann::ordered_json() : nlohmann::ordered_json(order)}});
      else
        std::printf("%-22s %7d %8d %8.2f %6d %7d %6d %9.1e %7.0f %6s\n", scan.c_str(), cells + 1,
                    row.vertices, row.seconds, row.drape_steps, row.vacuum_steps, row.iterations,
                    row.residual, mib, std::isnan(order) ? "" : std::to_string(order).substr(0, 4).c_str());
      std::fflush(stdout);
      before = row;
    }
  }
  if (json) std::printf("%s\n", rows.dump(2).c_str());
  return all_formed ? 0 : 1;
}
