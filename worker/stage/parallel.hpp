// Divides independent items (rows of a picture, triangles of a sheet) among threads. One thread makes each item from
// the same inputs, so the result does not depend on the number of threads.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <utility>

namespace vacuform {

// Calls work(begin, end) over disjoint ranges that cover [first, last), on up to eight threads, and waits. May be
// nested. An exception in any range is rethrown.
template <class Work>
void in_parallel(int first, int last, Work&& work) {
  const int parts =
      std::clamp(tbb::this_task_arena::max_concurrency(), 1, std::min(8, std::max(1, last - first)));
  const auto items = static_cast<long>(last - first);
  tbb::parallel_for(
      0, parts,
      [&](int i) {
        work(first + static_cast<int>(items * i / parts), first + static_cast<int>(items * (i + 1) / parts));
      },
      tbb::simple_partitioner{});
}

// Calls work(item) for each of [first, last), for items that are few and take long, and waits. May be nested. An exception
// in any is rethrown.
template <class Work>
void each_in_parallel(int first, int last, Work&& work) {
  tbb::parallel_for(first, last, work, tbb::simple_partitioner{});
}

// Runs two or more independent pieces of work, on several threads if there are some, and waits. May be nested. An
// exception in any is rethrown.
template <class... Work>
void together(Work&&... works) {
  tbb::parallel_invoke(std::forward<Work>(works)...);
}

}  // namespace vacuform
