// Progress and cancellation, handed to every stage.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "api/error.hpp"
#include "api/job.hpp"

namespace vacuform {

// A copyable handle; all copies share one state. cancel() is sticky and may be called from any thread or from a
// signal handler. The listener is called on the thread that runs the stage, in order, never concurrently.
class Context {
 public:
  // Receives the running stage and its fraction done, in [0, 1] and not decreasing within a stage.
  using Listener = std::function<void(Stage, double)>;

  Context() : Context(Listener{}) {}
  explicit Context(Listener listener) : state_(std::make_shared<State>()) {
    state_->listener = std::move(listener);
  }

  void cancel() noexcept { state_->cancelled.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept { return state_->cancelled.load(std::memory_order_relaxed); }

  // Stages call this at least every 0.2 s of work.
  void report(Stage stage, double fraction) const {
    if (state_->listener) state_->listener(stage, fraction);
  }

  // Reports and looks at the cancellation in one call.
  Result<void> step(Stage stage, double fraction) const {
    if (cancelled()) return fail(Code::cancelled, "cancelled");
    report(stage, fraction);
    return {};
  }

 private:
  struct State {
    std::atomic<bool> cancelled{false};
    Listener listener;
  };
  std::shared_ptr<State> state_;
};

// Something the user must be told that is not an error: it goes into report.json and onto the page.
// `code` is stable for machines ("undercut", "ink-off-chart"), `text` is one sentence for people.
struct Warning {
  std::string code;
  std::string text;
  // Where and how large, for marks in a preview; `marks` may hold several places of one warning, worst first, at most
  // most_marks.
  static constexpr std::size_t most_marks = 20;
  struct Mark {
    std::array<double, 3> place_mm;  // in the mold's frame
    double size_mm = 0;              // across; 0: a point
  };
  std::vector<Mark> marks = {};
};

}  // namespace vacuform
