// The states of a job and what leads from one to another. Pure functions for any store: they read no clock and no
// database, so that the same job and event give the same answer everywhere.
//
//              leased         cancel asked   worker finished                    lease expired       given back
//   queued     running        cancelled      lease_lost                         lease_lost          lease_lost
//   running    conflict       cancelling     succeeded, failed, cancelled,      queued or failed    queued
//                                            queued after a fault
//   cancelling conflict       (unchanged)    cancelled                          cancelled           cancelled
//   succeeded  conflict       conflict       (unchanged)                        lease_lost          lease_lost
//   failed     conflict       conflict       (unchanged)                        lease_lost          lease_lost
//   cancelled  conflict       (unchanged)    (unchanged)                        lease_lost          lease_lost
//
// Only a job that has ended can be deleted.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "api/retry.hpp"
#include "server/store/job.hpp"

namespace vacuform {

// Attempts that a job lost so far: with their worker or by its fault, and by a breakdown of the job's own process.
struct Faults {
  int losses = 0, crashes = 0;
};

struct RetryLimits {
  int losses = 10, crashes = 2;  // with so many the job fails
  Millis backoff = 2'000;        // the first rest
};

// How a store writes it: a job that goes back to the queue loses what its attempt left behind (stage, progress, worker,
// lease, artifacts); one that ends keeps artifacts only when it succeeded, or those that explain a failure.
struct Transition {
  bool changes = true;  // otherwise the job stays as it is, and that is the answer
  JobState state = JobState::queued;
  int attempt = 0;
  Faults faults = {};
  std::optional<Millis> rest = {};  // of a queued job, before it is leased again
  std::optional<Error> error = {};  // of a failed job
  bool explained = false;           // a worker refused it, and may have sent what explains that
  std::string line = {};            // for the job's log
  bool forgets_lease =
      false;  // the worker must not hear that its lease was good; otherwise an ending may be repeated
};

// How a worker ended an attempt.
struct Ending {
  JobState wanted = JobState::succeeded;  // or failed, or cancelled
  std::optional<Error> error = {};        // of a failed one
  Retry retry = Retry::never;
  std::span<const StoredArtifact> artifacts = {};  // made so far
};

// `chance` is random, below 2^24: a rest is half as long to half as long again by it.
Result<Transition> when_leased(const Job& job, const Faults& faults);
Result<Transition> when_cancel_asked(const Job& job, const Faults& faults);
// Conflict, too, when the job is to succeed without an artifact that its kind must have.
Result<Transition> when_finished(const Job& job, const Faults& faults, const Ending& ending,
                                 const RetryLimits& limits, std::uint32_t chance);
Result<Transition> when_expired(const Job& job, const Faults& faults, const RetryLimits& limits,
                                std::uint32_t chance);
Result<Transition> when_given_back(const Job& job, const Faults& faults);
// Errors: conflict, unless the job has ended.
Result<void> may_be_deleted(const Job& job);

}  // namespace vacuform
