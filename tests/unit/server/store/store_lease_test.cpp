// Leases, and the fate of a job whose worker or pipeline fails.
#include <sstream>

#include "tests/unit/server/store/store_fixture.hpp"

namespace vacuform {
namespace {

// Everything that anybody can see of a job.
std::string shown(const Job& job) {
  std::ostringstream out;
  const auto time = [&](const std::optional<Millis>& value) { out << ' ' << value.value_or(-1); };
  out << job.id << ' ' << static_cast<int>(job.kind) << ' ' << name(job.state) << ' '
      << (job.stage ? name(*job.stage) : "none") << ' ' << job.stage_progress << ' ' << job.attempt << ' '
      << job.priority << ' ' << job.version << ' ' << job.serious_warnings.value_or(-1);
  time(job.created), time(job.started), time(job.ended), time(job.not_before);
  out << '\n'
      << (job.error ? job.error->text() : "no error") << '\n'
      << job.settings << ' ' << job.request << ' ' << job.owner << ' ' << job.derived_from.value_or("none")
      << ' ' << job.reference << ' ' << job.note << '\n';
  for (const Input& input : job.inputs)
    out << input.name << ' ' << input.blob.sha256 << ' ' << input.blob.bytes << ' ' << input.extension
        << '\n';
  for (const StoredArtifact& artifact : job.artifacts)
    out << artifact.name << ' ' << artifact.blob.sha256 << ' ' << artifact.blob.bytes << '\n';
  return out.str();
}

TEST_P(StoreTest, EveryChangeReturnsTheJobAsItIsThen) {
  const auto submit = [&] {
    NewJob made{R"({"print":{"dpi":300}})", "key-" + random_hex(8)};
    made.add("pattern", upload("a pattern"), "svg");  // not in the order of the kinds
    made.add("scan", upload("a scan"), "stl");
    made.request = "request-1";
    made.owner = "station-1";
    made.priority = 3;
    made.derived_from = std::string(26, '0');
    made.reference = "CASE-1";
    made.note = "thin";
    const Job job = store_->create(std::move(made)).value();
    EXPECT_EQ(shown(job), shown(this->job(job.id)));
    return job.id;
  };
  const auto leased = [&](const std::string& id) {
    const auto lease = store_->lease("tester").value();
    EXPECT_EQ(lease->job.id, id);
    EXPECT_EQ(shown(lease->job), shown(job(id)));
    return LeaseKey{id, lease->token};
  };
  const auto expect = [&](const Result<Job>& returned) {
    ASSERT_TRUE(returned) << returned.error().text();
    EXPECT_EQ(shown(*returned), shown(job(returned->id)));
  };
  const LeaseKey good = leased(submit());
  EXPECT_TRUE(store_->heartbeat(good, Stage::forming, 0.5));
  expect(complete(good));
  EXPECT_FALSE(job(good.job).artifacts.empty());
  expect(store_->complete(good));  // repeated
  for (const Retry retry : {Retry::after_fault, Retry::never}) {
    const LeaseKey bad = leased(submit());
    for (const char* file : {"print.png", "findings.json", "mold.stl"})
      EXPECT_TRUE(store_->put_artifact(bad, file, upload(file)));
    expect(store_->fail_job(bad, {Code::forming_failed, "the sheet tears", "here", "heat it"}, retry));
    if (retry == Retry::after_fault) expect(store_->cancel(bad.job));
  }
  const LeaseKey back = leased(submit());
  expect(store_->release(back));
  expect(store_->cancel(leased(back.job).job));
}

TEST_P(StoreTest, LeasesTheOldestJobOnceAndOnlyOnce) {
  const Job first = create(), second = create();
  EXPECT_LT(first.id, second.id);  // even within one millisecond
  EXPECT_EQ(lease().job, first.id);
  EXPECT_EQ(lease().job, second.id);
  EXPECT_FALSE(store_->lease("third").value().has_value());
  EXPECT_EQ(job(first.id).state, JobState::running);
  EXPECT_EQ(job(first.id).attempt, 1);
}

TEST_P(StoreTest, EveryWriteNeedsTheTokenOfTheCurrentLease) {
  const std::string id = create().id;
  const LeaseKey good = lease(), bad{id, std::string(64, '0')}, empty{id, ""};
  for (const LeaseKey& key : {bad, empty, LeaseKey{"no such job", good.token}}) {
    EXPECT_EQ(store_->leased(key).error().code, Code::lease_lost);
    EXPECT_EQ(store_->heartbeat(key, Stage::forming, 1).error().code, Code::lease_lost);
    EXPECT_EQ(store_->put_artifact(key, "print.png", upload("x")).error().code, Code::lease_lost);
    EXPECT_EQ(store_->complete(key).error().code, Code::lease_lost);
    EXPECT_EQ(store_->fail_job(key, {Code::internal, "x", "", ""}, Retry::never).error().code,
              Code::lease_lost);
    EXPECT_EQ(store_->cancelled(key).error().code, Code::lease_lost);
    EXPECT_EQ(store_->release(key).error().code, Code::lease_lost);
  }
  EXPECT_EQ(job(id).state, JobState::running);
  EXPECT_TRUE(job(id).artifacts.empty());
  EXPECT_EQ(blobs().size(), 2u);  // the refused artifact left no file
}

TEST_P(StoreTest, AHeartbeatRenewsTheLeaseAndNotesTheProgress) {
  const std::string id = create().id;
  const LeaseKey key = lease();
  for (int i = 1; i <= 5; ++i) {
    now_ += 29'000;
    EXPECT_FALSE(store_->heartbeat(key, Stage::forming, 0.2 * i).value());
  }
  EXPECT_EQ(job(id).stage, Stage::forming);
  EXPECT_DOUBLE_EQ(job(id).stage_progress, 1.0);
  now_ += 30'001;
  EXPECT_EQ(store_->heartbeat(key, Stage::forming, 1).error().code, Code::lease_lost);
}

TEST_P(StoreTest, AnExpiredLeaseGoesToAnotherWorkerAndTheFirstIsRefused) {
  const std::string id = create().id;
  const LeaseKey first = lease();
  ASSERT_TRUE(store_->put_artifact(first, "print.png", upload("of the first")));
  now_ += 30'001;
  const auto expired = store_->expire().value();
  ASSERT_EQ(expired.size(), 1u);
  EXPECT_EQ(expired[0].job, id);
  EXPECT_EQ(expired[0].state, JobState::queued);
  EXPECT_TRUE(job(id).artifacts.empty());
  EXPECT_EQ(blobs().size(), 2u);
  const LeaseKey second = lease();
  EXPECT_EQ(second.job, id);
  EXPECT_EQ(job(id).attempt, 2);
  EXPECT_EQ(store_->complete(first).error().code, Code::lease_lost);
  EXPECT_EQ(store_->put_artifact(first, "print.png", upload("late")).error().code, Code::lease_lost);
  EXPECT_EQ(complete(second).value().state, JobState::succeeded);
  EXPECT_EQ(store_->complete(first).error().code, Code::lease_lost);
}

TEST_P(StoreTest, AJobThatTakesThreeWorkersDownFailsWithThatReason) {
  const std::string id = create().id;
  for (int i = 0; i < 3; ++i) {
    lease();
    now_ += 30'001;
    store_->expire().value();
  }
  EXPECT_EQ(job(id).state, JobState::failed);
  EXPECT_EQ(job(id).attempt, 3);
  ASSERT_TRUE(job(id).error);
  EXPECT_EQ(job(id).error->what, "3 workers were lost while they ran this job");
  EXPECT_FALSE(store_->lease("fourth").value().has_value());
}

TEST_P(StoreTest, ADeadWorkersJobsNeedNotWait) {
  const std::string first = create().id, second = create().id;
  ASSERT_TRUE(store_->lease("local-1"));
  const auto other = store_->lease("local-2").value();
  const auto expired = store_->end_leases_of("local-1").value();
  ASSERT_EQ(expired.size(), 1u);
  EXPECT_EQ(expired[0].job, first);
  EXPECT_EQ(lease().job, first);
  EXPECT_FALSE(store_->heartbeat({second, other->token}, Stage::scan, 0).value());
}

TEST_P(StoreTest, ARefusedChangeTakesNoOtherWithIt) {
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i)
    threads.emplace_back([&, i] {
      for (int k = 0; k < 5; ++k) {
        EXPECT_FALSE(store_->complete({"no such job", "no such token"}));
        create("scan " + std::to_string(10 * i + k), "pattern " + std::to_string(i));
        EXPECT_FALSE(store_->remove("no such job"));
      }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(store_->list(100, "")->jobs.size(), 40u);
  EXPECT_EQ(blobs().size(), 48u);
}

TEST_P(StoreTest, AReleasedJobIsNotALoss) {
  const std::string id = create().id;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(store_->release(lease()).value().state, JobState::queued);
  EXPECT_EQ(job(id).state, JobState::queued);
  EXPECT_EQ(job(id).attempt, 5);
}

TEST_P(StoreTest, EndingTwiceUnderOneTokenIsHarmless) {
  create();
  const LeaseKey key = lease();
  const Job done = complete(key).value();
  now_ += 5'000;
  const Job again = store_->complete(key).value();
  EXPECT_EQ(again.state, JobState::succeeded);
  EXPECT_EQ(again.ended, done.ended);
  EXPECT_EQ(store_->fail_job(key, {Code::internal, "no", "", ""}, Retry::after_fault).value().state,
            JobState::succeeded);
  EXPECT_EQ(store_->heartbeat(key, {}, 0).error().code, Code::lease_lost);
  EXPECT_EQ(store_->put_artifact(key, "print.png", upload("late")).error().code, Code::lease_lost);
}

TEST_P(StoreTest, AFailureKeepsItsReason) {
  const std::string id = create().id;
  ASSERT_TRUE(
      store_->fail_job(lease(), {Code::ambiguous_units, "cm or in", "scan", "set scan.units"}, Retry::never));
  reopen();
  EXPECT_EQ(job(id).state, JobState::failed);
  EXPECT_EQ(job(id).error->code, Code::ambiguous_units);
  EXPECT_EQ(job(id).error->text(), "cm or in (scan); set scan.units");
}

TEST_P(StoreTest, AFaultOfTheWorkersIsTriedAgainSoOften) {
  const std::string id = create().id;
  const Error error{Code::internal, "no room", "", ""};
  EXPECT_EQ(store_->fail_job(lease(), error, Retry::after_fault).value().state, JobState::queued);
  EXPECT_EQ(store_->fail_job(lease(), error, Retry::after_fault).value().state, JobState::queued);
  EXPECT_EQ(store_->fail_job(lease(), error, Retry::after_fault).value().state, JobState::failed);
  EXPECT_EQ(job(id).error->what, "no room");
}

TEST_P(StoreTest, ASecondCrashEndsAJobWithItsLog) {
  const std::string id = create().id;
  const Error error{Code::internal, "crashed", "", ""};
  EXPECT_EQ(store_->fail_job(lease(), error, Retry::after_fault).value().state, JobState::queued);
  EXPECT_EQ(store_->fail_job(lease(), error, Retry::after_crash).value().state, JobState::queued);
  EXPECT_EQ(store_->fail_job(lease(), error, Retry::after_crash).value().state, JobState::failed);
  EXPECT_EQ(store_->log_after(id, 0, 100)->back().text, "failed: internal");
  EXPECT_EQ(store_->log_after(id, 0, 100)->size(), 7u);
}

TEST_P(StoreTest, DoesNotCountTheFailuresOfAWorkerAgainstAJob) {
  const std::string id = create().id;
  const Error error{Code::internal, "crashed", "", ""};
  ASSERT_TRUE(store_->fail_job(lease(), error, Retry::after_crash));
  for (int i = 0; i < 2; ++i) {  // of three
    lease();
    now_ += 30'001;
    ASSERT_EQ(store_->expire()->size(), 1u);
  }
  EXPECT_EQ(complete(lease())->state, JobState::succeeded);
}

TEST_P(StoreTest, AJobOutlivesEightMinutesOfTroubleButNotAnHour) {
  store_.reset();
  StoreOptions plain;  // what a server has
  plain.clock = plain.elapsed = [this] { return now_; };
  store_ = std::move(*GetParam().open(data(), plain));
  const std::string id = create().id;
  const Millis started = now_;
  int attempts = 0;
  for (; job(id).state == JobState::queued; ++attempts) {
    now_ = job(id).not_before.value_or(now_);
    lease();
    ASSERT_EQ(store_->end_leases_of("tester")->size(), 1u);
  }
  EXPECT_EQ(attempts, 10);
  EXPECT_EQ(job(id).state, JobState::failed);
  EXPECT_EQ(job(id).error->what, "10 workers were lost while they ran this job");
  EXPECT_GE(now_ - started, 511'000);  // (2 s + 4 s + ... + 512 s) / 2
  EXPECT_LE(now_ - started, 1'533'000);
}

TEST_P(StoreTest, AJobRestsLongerWithEveryFault) {
  StoreOptions resting = options();
  resting.backoff = 1000;
  resting.losses = 20;
  store_.reset();
  store_ = std::move(*GetParam().open(data(), resting));
  const std::string id = create().id;
  for (const Millis rest : {1000, 2000, 4000, 8000}) {
    ASSERT_TRUE(store_->fail_job(lease(), {Code::internal, "", "", ""}, Retry::after_fault));
    const Millis until = job(id).not_before.value();
    EXPECT_GE(until, now_ + rest / 2);
    EXPECT_LE(until, now_ + rest + rest / 2);
    now_ = until - 1;
    EXPECT_FALSE(store_->lease("early").value().has_value());
    ++now_;
  }
  const LeaseKey key = lease();
  EXPECT_FALSE(job(id).not_before);
  ASSERT_TRUE(store_->release(key));
  EXPECT_FALSE(job(id).not_before);  // returned without an error
  lease();
  now_ += 30'001;
  ASSERT_EQ(store_->expire()->size(), 1u);
  EXPECT_GE(job(id).not_before.value(), now_ + 8000);  // the fifth
}

TEST_P(StoreTest, ARestartLeavesRunningJobsAWholeLeaseMore) {
  const std::string id = create().id;
  const LeaseKey key = lease();
  now_ += 60'000;  // the server was down
  crash();
  EXPECT_EQ(job(id).state, JobState::running);
  now_ += 29'000;
  EXPECT_FALSE(store_->heartbeat(key, Stage::forming, 0.5).value());
  now_ += 30'001;
  EXPECT_EQ(store_->expire().value().size(), 1u);
}

TEST_P(StoreTest, SettingTheClockNeitherEndsNorExtendsALease) {
  const std::string id = create().id;
  const LeaseKey key = lease();
  for (const Millis set : {86'400'000, -86'400'000}) {
    clock_set_ = set;
    EXPECT_TRUE(store_->expire()->empty());
    EXPECT_TRUE(store_->heartbeat(key, Stage::scan, 0.5));
  }
  now_ += 30'001;
  clock_set_ = -86'400'000;
  EXPECT_EQ(store_->expire()->size(), 1u);
}

TEST_P(StoreTest, SettingTheClockNeitherEndsNorExtendsARest) {
  StoreOptions resting = options();
  resting.backoff = 60'000;
  const auto open = [&] {
    store_.reset();
    store_ = std::move(*GetParam().open(data(), resting));
  };
  open();
  create();
  ASSERT_TRUE(store_->fail_job(lease(), {Code::internal, "", "", ""}, Retry::after_fault));
  clock_set_ = 86'400'000;
  EXPECT_FALSE(*store_->lease("early"));
  clock_set_ = -86'400'000;
  open();  // the clock was set back while no server was running
  now_ += longest_rest;
  EXPECT_TRUE(*store_->lease("in time"));
}

TEST_P(StoreTest, AnEndedLeaseDoesNotCountAsRunning) {
  create();
  const std::string second = create().id;
  lease();
  lease();
  ASSERT_TRUE(store_->cancel(second));
  now_ += 30'001;
  JobCounts expected{};
  expected[static_cast<std::size_t>(JobState::queued)] = 1;
  expected[static_cast<std::size_t>(JobState::cancelled)] = 1;
  EXPECT_EQ(store_->status()->counts, expected);
  ASSERT_EQ(store_->expire()->size(), 2u);
  EXPECT_EQ(store_->status()->counts, expected);
}

TEST_P(StoreTest, AJobSucceedsOnlyWithItsArtifactsAndShowsThemOnlyThen) {
  for (const JobKind kind : {JobKind::print, JobKind::inspection, JobKind::layout}) {
    NewJob wanted = submission();
    wanted.kind = kind;
    const std::string id = store_->create(std::move(wanted))->id;
    const LeaseKey key = lease();
    for (const ArtifactKind& artifact : artifact_kinds) {
      if (!due(kind, artifact)) continue;
      const auto early = store_->complete(key);
      ASSERT_FALSE(early);
      EXPECT_EQ(early.error().code, Code::conflict);
      EXPECT_NE(early.error().what.find(artifact.name), std::string::npos) << early.error().what;
      ASSERT_TRUE(store_->put_artifact(key, std::string(artifact.name), upload("an artifact")));
      EXPECT_TRUE(job(id).artifacts.empty());
    }
    EXPECT_EQ(store_->complete(key)->state, JobState::succeeded);
    EXPECT_EQ(job(id).artifacts.size(), kind == JobKind::print ? 21u : kind == JobKind::inspection ? 3u : 2u);
  }
}

TEST_P(StoreTest, TellsOfEveryEndOnce) {
  std::vector<std::string> ends;
  StoreOptions telling = options();
  telling.job_ended = [&](const Job& job) { ends.emplace_back(name(job.state)); };
  store_.reset();
  store_ = std::move(*GetParam().open(data(), telling));
  const std::string first = create().id;
  ASSERT_TRUE(store_->cancel(first) && store_->cancel(first));
  create();
  const LeaseKey key = lease();
  EXPECT_FALSE(store_->complete(key));
  ASSERT_TRUE(store_->fail_job(key, {}, Retry::never) && store_->fail_job(key, {}, Retry::never));
  EXPECT_EQ(ends, (std::vector<std::string>{"cancelled", "failed"}));
}

TEST_P(StoreTest, ManyWorkersShareTheJobsWithoutOneTwice) {
  constexpr int jobs = 60;
  for (int i = 0; i < jobs; ++i) create("scan " + std::to_string(i));
  std::mutex mutex;
  std::vector<std::string> done;
  std::vector<std::thread> workers;
  for (int i = 0; i < 6; ++i)
    workers.emplace_back([&] {
      for (;;) {
        const auto leased = store_->lease("worker");
        if (!leased || !*leased) return;
        if (!store_->fail_job({(*leased)->job.id, (*leased)->token}, {}, Retry::never)) return;
        const std::lock_guard hold(mutex);
        done.push_back((*leased)->job.id);
      }
    });
  for (auto& worker : workers) worker.join();
  EXPECT_EQ(done.size(), static_cast<std::size_t>(jobs));
  EXPECT_EQ(std::set<std::string>(done.begin(), done.end()).size(), static_cast<std::size_t>(jobs));
}

}  // namespace
}  // namespace vacuform
