// Every state of a job with every event.
#include "server/store/transitions.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace vacuform {
namespace {

constexpr RetryLimits limits{3, 2, 2'000};
constexpr std::uint32_t half = 1u << 23;  // of the random range: a pause has its nominal length

Job job_in(JobState state) {
  Job job;
  job.id = "01j";
  job.state = state;
  job.attempt = 4;
  return job;
}

std::vector<StoredArtifact> all_artifacts(JobKind kind) {
  std::vector<StoredArtifact> artifacts;
  for (const ArtifactKind& artifact : artifact_kinds)
    if (due(kind, artifact)) artifacts.push_back({std::string(artifact.name), {}});
  return artifacts;
}

const Error refusal{Code::unusable_scan, "no mold", "scan", "look at it"};
const auto artifacts = all_artifacts(JobKind::print);

// The result of an event for a job that has not lost an attempt yet.
using Event = std::function<Result<Transition>(const Job&)>;
struct NamedEvent {
  const char* name;
  Event event;
  // By state: queued, running, succeeded, failed, cancelling, cancelled. "=" means unchanged, a state is the next one,
  // anything else is the code of the refusal.
  std::array<std::string_view, 6> next;
};

Event ending(JobState wanted, Retry retry = Retry::never) {
  return [=](const Job& job) {
    const auto error = wanted == JobState::failed ? std::optional(refusal) : std::nullopt;
    return when_finished(job, {}, {wanted, error, retry, artifacts}, limits, half);
  };
}

const std::vector<NamedEvent> events{
    {"leased",
     [](const Job& job) { return when_leased(job, {}); },
     {"running", "conflict", "conflict", "conflict", "conflict", "conflict"}},
    {"cancel asked",
     [](const Job& job) { return when_cancel_asked(job, {}); },
     {"cancelled", "cancelling", "conflict", "conflict", "=", "="}},
    {"succeeded", ending(JobState::succeeded), {"lease_lost", "succeeded", "=", "=", "cancelled", "="}},
    {"failed for good", ending(JobState::failed), {"lease_lost", "failed", "=", "=", "cancelled", "="}},
    {"failed by a fault",
     ending(JobState::failed, Retry::after_fault),
     {"lease_lost", "queued", "=", "=", "cancelled", "="}},
    {"failed by a crash",
     ending(JobState::failed, Retry::after_crash),
     {"lease_lost", "queued", "=", "=", "cancelled", "="}},
    {"cancelled", ending(JobState::cancelled), {"lease_lost", "cancelled", "=", "=", "cancelled", "="}},
    {"lease expired",
     [](const Job& job) { return when_expired(job, {}, limits, half); },
     {"lease_lost", "queued", "lease_lost", "lease_lost", "cancelled", "lease_lost"}},
    {"given back",
     [](const Job& job) { return when_given_back(job, {}); },
     {"lease_lost", "queued", "lease_lost", "lease_lost", "cancelled", "lease_lost"}},
};

TEST(Transitions, LeadFromEveryStateByEveryEventWhereTheTableSays) {
  for (const NamedEvent& event : events)
    for (std::size_t i = 0; i < job_state_names.size(); ++i) {
      const auto state = static_cast<JobState>(i);
      SCOPED_TRACE(std::string(event.name) + ", " + std::string(name(state)));
      const auto next = event.event(job_in(state));
      const std::string_view wanted = event.next[i];
      if (wanted == "conflict" || wanted == "lease_lost") {
        ASSERT_FALSE(next);
        EXPECT_EQ(next.error().code, wanted == "conflict" ? Code::conflict : Code::lease_lost);
        EXPECT_EQ(next.error().where, "01j");
        EXPECT_FALSE(next.error().fix.empty());
        continue;
      }
      ASSERT_TRUE(next) << next.error().text();
      EXPECT_EQ(next->changes, wanted != "=");
      EXPECT_EQ(name(next->state), wanted == "=" ? name(state) : wanted);
      EXPECT_EQ(next->line.empty(), !next->changes);
      EXPECT_EQ(next->attempt, next->state == JobState::running && next->changes ? 5 : 4);
      EXPECT_EQ(next->error.has_value(), next->changes && next->state == JobState::failed);
    }
}

TEST(Transitions, SayWhatTheLogSays) {
  const auto line = [](const Event& event, JobState state) { return event(job_in(state))->line; };
  EXPECT_EQ(line(events[0].event, JobState::queued), "attempt 5 begins");
  EXPECT_EQ(line(events[1].event, JobState::queued), "cancelled");
  EXPECT_EQ(line(events[1].event, JobState::running), "asked to cancel");
  EXPECT_EQ(line(events[2].event, JobState::running), "succeeded");
  EXPECT_EQ(line(events[3].event, JobState::running), "failed: unusable-scan");
  EXPECT_EQ(line(events[4].event, JobState::running), "its worker had an internal fault, queued again");
  EXPECT_EQ(line(events[5].event, JobState::running), "its process crashed, queued again");
  EXPECT_EQ(line(events[7].event, JobState::running), "its worker was lost, queued again");
  EXPECT_EQ(line(events[8].event, JobState::running), "given back by its worker, queued again");
  EXPECT_EQ(line(events[8].event, JobState::cancelling), "cancelled");
}

TEST(Transitions, CountFaultsUpToTheirLimits) {
  const Job job = job_in(JobState::running);
  const auto ended_by = [&](Faults faults, Retry retry) {
    return *when_finished(job, faults, {JobState::failed, refusal, retry, {}}, limits, half);
  };
  const Transition fault = ended_by({1, 1}, Retry::after_fault), crash = ended_by({2, 0}, Retry::after_crash);
  EXPECT_EQ(fault.state, JobState::queued);
  EXPECT_EQ(fault.faults.losses, 2);
  EXPECT_EQ(fault.faults.crashes, 1);
  EXPECT_EQ(crash.state, JobState::queued);
  EXPECT_EQ(crash.faults.crashes, 1);
  const Transition third = ended_by({2, 0}, Retry::after_fault),
                   second = ended_by({0, 1}, Retry::after_crash);
  EXPECT_EQ(third.state, JobState::failed);
  EXPECT_EQ(third.error->code, Code::unusable_scan);
  EXPECT_EQ(second.state, JobState::failed);
  EXPECT_EQ(second.error->what, "no mold");
  EXPECT_EQ(ended_by({0, 0}, Retry::never).faults.losses, 0);

  EXPECT_EQ(when_expired(job, {1, 1}, limits, half)->state, JobState::queued);
  const auto lost = when_expired(job, {2, 1}, limits, half);
  EXPECT_EQ(lost->state, JobState::failed);
  EXPECT_EQ(lost->faults.losses, 3);
  EXPECT_EQ(lost->error->code, Code::internal);
  EXPECT_EQ(lost->error->what, "3 workers were lost while they ran this job");
  EXPECT_EQ(lost->line, "failed: internal");
  const auto given_back = when_given_back(job, {2, 1});
  EXPECT_EQ(given_back->state, JobState::queued);  // the attempt does not count as a failure
  EXPECT_EQ(given_back->faults.losses, 2);
}

TEST(Transitions, RestsDoubleUpToTenMinutesAndVaryByHalf) {
  const Job job = job_in(JobState::running);
  const RetryLimits patient{40, 40, 2'000};
  const auto rest = [&](Faults faults, std::uint32_t chance) {
    return *when_expired(job, faults, patient, chance)->rest;
  };
  EXPECT_EQ(rest({0, 0}, half), 2'000);
  EXPECT_EQ(rest({1, 0}, half), 4'000);
  EXPECT_EQ(rest({1, 1}, half), 8'000);
  EXPECT_EQ(rest({7, 0}, half), 256'000);
  EXPECT_EQ(rest({30, 0}, half), 600'000);
  EXPECT_EQ(rest({0, 0}, 0), 1'000);
  EXPECT_EQ(rest({0, 0}, (1u << 24) - 1), 2'999);
  EXPECT_FALSE(when_given_back(job, {3, 1})->rest);
  EXPECT_FALSE(when_expired(job_in(JobState::cancelling), {}, patient, half)->rest);
  EXPECT_FALSE(when_finished(job, {}, {JobState::failed, refusal, Retry::never, {}}, limits, half)->rest);
}

TEST(Transitions, ALostLeaseIsForgottenAndAnEndingMayBeRepeated) {
  for (const JobState state : {JobState::running, JobState::cancelling}) {
    EXPECT_TRUE(when_expired(job_in(state), {}, limits, half)->forgets_lease);
    EXPECT_FALSE(ending(JobState::succeeded)(job_in(state))->forgets_lease);
  }
  EXPECT_TRUE(when_expired(job_in(JobState::running), {2, 0}, limits, half)->forgets_lease);  // the last one
  EXPECT_TRUE(when_given_back(job_in(JobState::running), {})->forgets_lease);
  EXPECT_FALSE(when_given_back(job_in(JobState::cancelling), {})->forgets_lease);
}

TEST(Transitions, AJobSucceedsWithAllItsArtifactsAlone) {
  for (const JobKind kind : {JobKind::print, JobKind::inspection, JobKind::layout}) {
    Job job = job_in(JobState::running);
    job.kind = kind;
    auto made = all_artifacts(kind);
    const auto finished = [&] {
      return when_finished(job, {}, {JobState::succeeded, {}, Retry::never, made}, limits, half);
    };
    EXPECT_TRUE(finished());
    const std::string last = made.back().name;
    made.pop_back();
    ASSERT_FALSE(finished());
    EXPECT_EQ(finished().error().code, Code::conflict);
    EXPECT_NE(finished().error().what.find("must have: " + last), std::string::npos);
    job.state = JobState::cancelling;
    EXPECT_EQ(finished()->state, JobState::cancelled);  // the cancel came first
  }
}

TEST(Transitions, OnlyWhatHasEndedIsDeleted) {
  for (std::size_t i = 0; i < job_state_names.size(); ++i) {
    const auto state = static_cast<JobState>(i);
    const auto may = may_be_deleted(job_in(state));
    EXPECT_EQ(may.has_value(), ended(state)) << name(state);
    if (!may) {
      EXPECT_EQ(may.error().code, Code::conflict);
    }
  }
}

}  // namespace
}  // namespace vacuform
