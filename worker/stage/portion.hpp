// A part of a longer piece of work: several runs of a stage under one progress and one cancellation.
#pragma once

#include "worker/stage/context.hpp"

namespace vacuform {

// Passes `whole` on as the context of one of several runs: every stage that the run reports moves the `stage` of the
// whole between the fractions `from` and `to`, and a cancellation of the whole cancels the run at its next report.
class Portion {
 public:
  Portion(const Context& whole, Stage stage, double from, double to)
      : part_([this, whole, stage, from, to](Stage, double fraction) {
          if (whole.cancelled()) part_.cancel();
          whole.report(stage, from + (to - from) * fraction);
        }) {}
  Portion(const Portion&) = delete;  // its context's listener refers to it
  Portion& operator=(const Portion&) = delete;

  const Context& context() const { return part_; }

 private:
  Context part_;
};

}  // namespace vacuform
