// Progress of the scan stage: the steps of the stage report how far it is; long operations within a step only tick.
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
  // Checks for cancellation and tells the listener that the stage is still running.
  Result<void> tick() const { return context_.step(Stage::scan, fraction_); }

 private:
  const Context& context_;
  double fraction_ = 0;
};

}  // namespace vacuform
