// Seconds and peak memory of a step of a benchmark. Linux only.
#pragma once

#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>

namespace vacuform {

struct StepCost {
  double seconds = 0, cpu_seconds = 0;
  double peak_mib = 0;  // the largest resident set of the process within the step
};

inline double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

// A field of /proc/self/status in kB, such as "VmRSS:", as MiB.
inline double status_mib(std::string_view field) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (word == field) {
      double kib = 0;
      status >> kib;
      return kib / 1024;
    }
  return 0;
}

// What `step` returns, a Result. A refusal ends the program: a benchmark of nothing must not look fast.
template <class Step>
auto measured(const std::string& name, const Step& step, StepCost& cost) {
  std::ofstream("/proc/self/clear_refs") << 5;  // the peak starts again
  const double cpu = cpu_seconds();
  const auto start = std::chrono::steady_clock::now();
  auto made = step();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  if (!made) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), made.error().text().c_str());
    std::exit(1);
  }
  cost = {wall.count(), cpu_seconds() - cpu, status_mib("VmHWM:")};
  return std::move(*made);
}

}  // namespace vacuform
