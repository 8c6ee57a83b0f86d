// A part of a longer piece of work: several runs of a stage under one progress and one cancellation.
#pragma once

#include "worker/stage/context.hpp"

namespace vacuform {

// A part of the progress of a stage, between two fractions of it.
struct StageShare {
  Stage stage;
  double from = 0, to = 1;
};

// Passes `whole` on as the context of one of several runs: every stage that the run reports moves the stage of the whole
// within the share.
class SubProgress {
 public:
  SubProgress(const Context& whole, const StageShare& share)
      : part_(whole.part([whole, share](Stage, double fraction) {
          whole.report(share.stage, share.from + (share.to - share.from) * fraction);
        })) {}

  const Context& context() const { return part_; }

 private:
  Context part_;
};

}  // namespace vacuform
