// Progress of the scan stage: the steps of the stage say how far it is, whatever runs long within a step only
// ticks.
#pragma once

#include "worker/stage/context.hpp"

namespace vacuform {

class ScanProgress {
 public:
  explicit ScanProgress(const Context& context) : context_(context) {}

  // The stage has come this far, in [0, 1], never less than before. Error: cancelled.
  Result<void> reach(double fraction) {
    fraction_ = fraction;
    return tick();
  }
  // Still there: looks at the cancellation and shows the listener a sign of life.
  Result<void> tick() const { return context_.step(Stage::scan, fraction_); }

 private:
  const Context& context_;
  double fraction_ = 0;
};

}  // namespace vacuform
