// Progress and cancellation, handed to every stage.
#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include "api/base/error.hpp"
#include "api/job.hpp"
#include "worker/stage/warning.hpp"

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
  bool cancelled() const noexcept {
    for (const State* state = state_.get(); state; state = state->whole.get())
      if (state->cancelled.load(std::memory_order_relaxed)) return true;
    return false;
  }

  // A handle with a listener of its own, for a part of the work: it is cancelled with the whole.
  Context part(Listener listener) const {
    Context out(std::move(listener));
    out.state_->whole = state_;
    return out;
  }

  // A handle for work beside a stage: it is cancelled with the others, and reports nothing.
  Context silent() const {
    Context out = *this;
    out.silent_ = true;
    return out;
  }

  // Stages call this at least every 0.2 s of work.
  void report(Stage stage, double fraction) const {
    if (!silent_ && state_->listener) state_->listener(stage, fraction);
  }

  // Reports progress and checks for cancellation in one call.
  Result<void> step(Stage stage, double fraction) const {
    if (cancelled()) return fail(Code::cancelled, "cancelled");
    report(stage, fraction);
    return {};
  }

 private:
  struct State {
    std::atomic<bool> cancelled{false};
    Listener listener;
    std::shared_ptr<const State> whole;
  };
  std::shared_ptr<State> state_;
  bool silent_ = false;
};

}  // namespace vacuform
