// Work over many items that hears a cancel.
#pragma once

#include "worker/stage/context.hpp"
#include "worker/stage/index.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

// Calls work(i) for each i in [0, count), `batch` of them at a time on several threads; reports progress and checks for
// cancellation between batches. Take a batch of about 0.1 s. Errors: cancelled.
template <class Work>
Result<void> in_batches(std::size_t count, int batch, Stage stage, const Context& context, const Work& work) {
  const int all = static_cast<int>(count);
  for (int begin = 0; begin < all; begin += batch) {
    VACUFORM_CHECK(context.step(stage, static_cast<double>(begin) / all));
    in_parallel(begin, std::min(begin + batch, all), [&](int first, int last) {
      for (int i = first; i < last; ++i) work(index(i));
    });
  }
  return {};
}

}  // namespace vacuform
