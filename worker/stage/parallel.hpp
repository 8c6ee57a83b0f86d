// Independent items (rows of a picture, triangles of a sheet) shared out over threads. Every item is made by one thread
// from the same inputs, so the result does not depend on their number.
#pragma once

#include <algorithm>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

namespace vacuform {

// Calls work(begin, end) over disjoint ranges that cover [first, last), each on a separate thread, and waits. An
// exception in any range is rethrown.
template <class Work>
void in_parallel(int first, int last, Work&& work) {
  const int threads = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1,
                                 std::min(8, std::max(1, last - first)));
  std::vector<std::exception_ptr> faults(static_cast<std::size_t>(threads));
  const auto range = [&](int i) {
    try {
      const auto items = static_cast<long>(last - first);
      work(first + static_cast<int>(items * i / threads),
           first + static_cast<int>(items * (i + 1) / threads));
    } catch (...) {
      faults[static_cast<std::size_t>(i)] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    int started = 1;
    try {
      for (; started < threads; ++started) others.emplace_back(range, started);
    } catch (const std::system_error&) {
      // If the number of threads is limited, the calling thread does the rest.
    }
    range(0);
    for (int i = started; i < threads; ++i) range(i);
  }
  for (const auto& fault : faults)
    if (fault) std::rethrow_exception(fault);
}

}  // namespace vacuform
