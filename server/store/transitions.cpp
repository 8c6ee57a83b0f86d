#include "server/store/transitions.hpp"

#include <algorithm>

#include "api/problem.hpp"

namespace vacuform {

namespace {

bool has_lease(const Job& job) { return job.state == JobState::running || job.state == JobState::cancelling; }

tl::unexpected<Error> lease_lost(const Job& job) {
  return fail(Code::lease_lost, "the lease of this job has ended", job.id,
              "stop working on this job and ask for another");
}

Transition unchanged(const Job& job, const Faults& faults) {
  Transition same{false, job.state, job.attempt, faults};
  return same;
}

Transition end(const Job& job, const Faults& faults, JobState state, std::optional<Error> error = {}) {
  Transition next{true, state, job.attempt, faults};
  next.line = error ? "failed: " + std::string(meaning(error->code).slug) : std::string(name(state));
  next.error = std::move(error);
  return next;
}

Transition queue_again(const Job& job, const Faults& faults, const std::string& why,
                       std::optional<Millis> rest = {}) {
  Transition next{true, JobState::queued, job.attempt, faults};
  next.rest = rest;
  next.line = why + ", queued again";
  next.forgets_lease = true;
  return next;
}

Millis rest_after(const Faults& faults, Millis first, std::uint32_t chance) {
  constexpr Millis longest = 10 * 60 * 1000;
  const Millis rest = std::min(longest, first << std::min(faults.losses + faults.crashes - 1, 20));
  return rest / 2 + ((rest * chance) >> 24);
}

Result<void> check_artifacts(const Job& job, std::span<const StoredArtifact> artifacts) {
  std::string missing;
  for (const ArtifactKind& kind : artifact_kinds)
    if (due(job.kind, kind) && std::none_of(artifacts.begin(), artifacts.end(),
                                            [&](const StoredArtifact& a) { return a.name == kind.name; }))
      missing.append(missing.empty() ? "" : ", ").append(kind.name);
  if (missing.empty()) return {};
  return fail(Code::conflict, "the job lacks artifacts that it must have: " + missing, job.id,
              "send them before the job is completed, or say that it failed");
}

}  // namespace

Result<Transition> when_leased(const Job& job, const Faults& faults) {
  if (job.state != JobState::queued)
    return fail(Code::conflict, "the job is " + std::string(name(job.state)), job.id, "lease a queued one");
  Transition next{true, JobState::running, job.attempt + 1, faults};
  next.line = "attempt " + std::to_string(next.attempt) + " begins";
  return next;
}

Result<Transition> when_cancel_asked(const Job& job, const Faults& faults) {
  switch (job.state) {
    case JobState::queued:
      return end(job, faults, JobState::cancelled);
    case JobState::running: {
      Transition next{true, JobState::cancelling, job.attempt, faults};
      next.line = "asked to cancel";
      return next;
    }
    case JobState::cancelling:
    case JobState::cancelled:
      return unchanged(job, faults);
    case JobState::succeeded:
    case JobState::failed:
      break;
  }
  return fail(Code::conflict, "the job has " + std::string(name(job.state)) + " already", job.id,
              "delete it if you do not need it");
}

Result<Transition> when_finished(const Job& job, const Faults& faults, const Ending& ending,
                                 const RetryLimits& limits, std::uint32_t chance) {
  if (ended(job.state)) return unchanged(job, faults);  // the worker repeats what it has said
  if (!has_lease(job)) return lease_lost(job);
  if (job.state == JobState::cancelling) return end(job, faults, JobState::cancelled);
  if (ending.wanted == JobState::succeeded) VACUFORM_CHECK(check_artifacts(job, ending.artifacts));
  if (ending.wanted != JobState::failed) return end(job, faults, ending.wanted);
  if (ending.retry == Retry::never) {
    Transition next = end(job, faults, JobState::failed, ending.error);
    next.explained = true;
    return next;
  }
  Faults now = faults;
  ++(ending.retry == Retry::after_crash ? now.crashes : now.losses);
  if (now.losses >= limits.losses || now.crashes >= limits.crashes)
    return end(job, now, JobState::failed, ending.error);
  return queue_again(
      job, now,
      ending.retry == Retry::after_crash ? "its process crashed" : "its worker had an internal fault",
      rest_after(now, limits.backoff, chance));
}

Result<Transition> when_expired(const Job& job, const Faults& faults, const RetryLimits& limits,
                                std::uint32_t chance) {
  if (!has_lease(job)) return lease_lost(job);
  const Faults now{faults.losses + 1, faults.crashes};
  Transition next =
      job.state == JobState::cancelling ? end(job, now, JobState::cancelled)
      : now.losses >= limits.losses
          ? end(job, now, JobState::failed,
                Error{Code::internal,
                      std::to_string(now.losses) + " workers were lost while they ran this job", job.id,
                      "look at the workers' logs; a coarser sheet.resolution_mm needs less memory"})
          : queue_again(job, now, "its worker was lost", rest_after(now, limits.backoff, chance));
  next.forgets_lease = true;
  return next;
}

Result<Transition> when_given_back(const Job& job, const Faults& faults) {
  if (!has_lease(job)) return lease_lost(job);
  if (job.state == JobState::cancelling) return end(job, faults, JobState::cancelled);
  return queue_again(job, faults, "given back by its worker");
}

Result<void> may_be_deleted(const Job& job) {
  if (ended(job.state)) return {};
  return fail(Code::conflict, "the job is " + std::string(name(job.state)), job.id, "cancel it first");
}

}  // namespace vacuform
