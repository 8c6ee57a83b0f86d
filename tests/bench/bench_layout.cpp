// Arrays of 8 to 64 loops on the shared heads at default settings: how long a layout takes, and how the loops couple.
//
//   bench_layout [--json] [count...] [head...]
//
// Per head and count: seconds and CPU seconds of lay_out_array() (the head is formed before), loops off the head, the
// share of the head within a loop, and of all pairs of the laid loops the rms of k and the largest |k|.
#include <chrono>
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

#include "worker/coils/array_layout.hpp"
#include "worker/flattening/flattening.hpp"
#include "worker/forming/inked_face.hpp"

namespace {

using namespace vacuform;

constexpr int counts[] = {8, 12, 16, 24, 31, 48, 64};

[[noreturn]] void stop(const std::string& why) {
  std::fprintf(stderr, "bench_layout: %s\n", why.c_str());
  std::exit(1);
}

template <class T>
T value_of(Result<T> result) {
  if (!result) stop(result.error().text());
  return *std::move(result);
}

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void measure(const std::string& head, const std::vector<int>& wanted, bool json) {
  std::ifstream in(std::string(VACUFORM_SHARED_DATA) + "/scans/" + head, std::ios::binary);
  if (!in) stop("cannot read the real scan " + head + "; see tests/fetch-scans");
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
  const Settings settings;
  const Mold mold = value_of(make_mold(bytes, head, settings.scan, Context{}));
  const FormedSheet sheet = value_of(
      form(mold, settings.sheet, settings.machine, settings.forming, TemperatureField(140), Context{}));
  const InkedSurface surface = inked_surface(sheet, settings.pattern.inked_face);
  const Flattening flattening = value_of(flatten(sheet, surface, mold, settings.flattening, Context{}));
  const ChartedSurface charted(surface, flattening);
  for (const int count : wanted) {
    LayoutSettings wish = settings.layout;
    wish.count = count;
    const double begin = seconds(), begin_cpu = cpu_seconds();
    const Array array = value_of(lay_out_array(charted, wish, settings.coils, Context{}));
    const double took = seconds() - begin, cpu = cpu_seconds() - begin_cpu;
    const double neighbours = array.strongest_neighbours ? array.strongest_neighbours->k : 0,
                 all = array.strongest ? array.strongest->k : 0;
    if (json)
      std::printf("%s\n", nlohmann::json{{"head", head},
                                         {"count", count},
                                         {"seconds", took},
                                         {"cpu_seconds", cpu},
                                         {"off_head", array.off_head},
                                         {"covered", array.covered},
                                         {"k_rms", array.k_rms},
                                         {"k_neighbours", neighbours},
                                         {"k", all}}
                              .dump()
                              .c_str());
    else
      std::printf(
          "%-28s %3d loops of %5.1f mm  %6.2f s %6.2f CPU s  %d off, %2.0f %%  k: rms %.4f, neighbours "
          "%+.4f, all "
          "%+.4f\n",
          head.c_str(), count, array.diameter_mm, took, cpu, array.off_head, 100 * array.covered, array.k_rms,
          neighbours, all);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false;
  std::vector<std::string> heads;
  std::vector<int> wanted;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == "--json")
      json = true;
    else if (argument.find_first_not_of("0123456789") == argument.npos)
      wanted.push_back(std::atoi(argv[i]));
    else
      heads.emplace_back(argument);
  }
  if (wanted.empty()) wanted.assign(std::begin(counts), std::end(counts));
  if (heads.empty())
    heads = {"adult-scalp-ascii.ply", "neonate-40w.stl", "child-headform-metres.stl",
             "adult-fsaverage-metres.obj"};
  for (const std::string& head : heads) measure(head, wanted, json);
}
