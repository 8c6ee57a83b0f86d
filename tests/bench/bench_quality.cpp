// Seconds of forming in each quality, and how far its sheet is from that of the fine one.
//
//   bench_quality [--json] [runs]        (3 runs; the median counts)
//
// neonate-40w and adult-scalp on a 300 mm sheet at default settings. The distance is that between the same points of the
// sheet where the fine one touches the mold.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "worker/forming/formed_sheet.hpp"
#include "worker/studies/convergence.hpp"

namespace {

using namespace vacuform;

std::vector<std::uint8_t> bytes_of(const std::string& scan) {
  std::ifstream in(std::string(VACUFORM_SHARED_DATA) + "/scans/" + scan, std::ios::binary);
  if (!in) {
    std::fprintf(stderr, "bench_quality: cannot read the real scan %s; see tests/fetch-scans\n",
                 scan.c_str());
    std::exit(1);
  }
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false;
  int runs = 3;
  for (int i = 1; i < argc; ++i)
    if (std::string_view(argv[i]) == "--json")
      json = true;
    else
      runs = std::max(1, std::atoi(argv[i]));

  auto rows = nlohmann::ordered_json::array();
  if (!json)
    std::printf("%-22s %-9s %8s %8s %8s %8s %8s\n", "scan", "quality", "seconds", "mean mm", "p95", "p99",
                "max");
  for (const std::string scan : {"neonate-40w.stl", "adult-scalp-ascii.ply"}) {
    const Settings settings;
    const auto mold = make_mold(bytes_of(scan), scan, settings.scan, Context{});
    if (!mold) std::exit(1);
    FormedSheet fine;
    for (const FormingQuality quality :
         {FormingQuality::fine, FormingQuality::standard, FormingQuality::fast}) {
      FormingSettings forming = settings.forming;
      forming.quality = quality;
      std::vector<double> seconds;
      FormedSheet sheet;
      for (int run = 0; run < (quality == FormingQuality::fine ? 1 : runs); ++run) {
        const auto start = std::chrono::steady_clock::now();
        auto formed =
            form(*mold, settings.sheet, settings.machine, forming, TemperatureField(140), Context{});
        seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
        if (!formed) {
          std::fprintf(stderr, "%s\n", formed.error().text().c_str());
          return 1;
        }
        sheet = std::move(*formed);
      }
      std::sort(seconds.begin(), seconds.end());
      const double median = seconds[seconds.size() / 2];
      DistanceStatistics off;
      if (quality == FormingQuality::fine)
        fine = std::move(sheet);
      else
        off = compare(sheet, fine).head;
      if (json)
        rows.push_back(
            {{"scan", scan}, {"quality", name(quality)}, {"seconds", median}, {"off_mm", json_of(off)}});
      else
        std::printf("%-22s %-9s %8.2f %8.4f %8.4f %8.4f %8.4f\n", scan.c_str(),
                    std::string(name(quality)).c_str(), median, off.mean, off.p95, off.p99, off.max);
      std::fflush(stdout);
    }
  }
  if (json) std::printf("%s\n", rows.dump(2).c_str());
  return 0;
}
