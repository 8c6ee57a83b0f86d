// The promises of server/store/store.hpp, held against the interface alone: every store is named at the end and must pass
// all of it. A crash is played by copying the files under a running store and opening the copy.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "server/secrets.hpp"
#include "server/store/store.hpp"

namespace vacuform {
namespace {

namespace fs = std::filesystem;

// A store by its name and the way to open it; blobs lie in its folder whatever keeps the rows.
struct Backend {
  const char* name;
  Result<std::unique_ptr<Store>> (*open)(const std::filesystem::path& data, StoreOptions options);
};

void PrintTo(const Backend& backend, std::ostream* out) { *out << backend.name; }

class StoreTest : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    folder_ = fs::temp_directory_path() / ("vacuform-store-" + random_hex(8));
    reopen();
  }
  void TearDown() override {
    store_.reset();
    fs::remove_all(folder_);
  }

  fs::path data() const { return folder_ / "data"; }
  void reopen() {
    store_.reset();
    auto store = GetParam().open(data(), options());
    ASSERT_TRUE(store) << store.error().text();
    store_ = std::move(*store);
  }
  StoreOptions options() {
    StoreOptions options;
    options.clock = [this] { return now_; };
    options.losses = 3;
    options.backoff = 0;  // faults rest only where a test says so
    return options;
  }
  // What the next start finds after the power went: the files as they are at this moment.
  void crash() {
    fs::copy(data(), folder_ / "after", fs::copy_options::recursive);
    store_.reset();
    fs::remove_all(data());
    fs::rename(folder_ / "after", data());
    reopen();
  }

  Upload upload(const std::string& bytes) {
    auto upload = store_->upload();
    EXPECT_TRUE(upload && upload->write(bytes));
    return std::move(*upload);
  }
  NewJob submission(const std::string& scan = "a scan", const std::string& pattern = "a pattern",
                    const std::string& key = "") {
    NewJob job{"{}", key};
    job.add("scan", upload(scan), "stl");
    job.add("pattern", upload(pattern), "svg");
    return job;
  }
  Job create(const std::string& scan = "a scan", const std::string& pattern = "a pattern") {
    auto job = store_->create(submission(scan, pattern));
    EXPECT_TRUE(job) << job.error().text();
    return *job;
  }
  LeaseKey lease() {
    auto lease = store_->lease("tester");
    EXPECT_TRUE(lease && *lease);
    return {(*lease)->job.id, (*lease)->token};
  }
  Job job(const std::string& id) { return store_->job(id).value(); }
  std::set<std::string> blobs() const {
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(data() / "blobs"))
      if (entry.is_regular_file()) names.insert(entry.path().filename().string());
    return names;
  }
  std::string bytes_of(const Blob& blob) {
    auto file = store_->open(blob);
    if (!file) return "no file";
    std::string text(blob.bytes, '\0');
    EXPECT_EQ(file->read_at(0, text).value(), blob.bytes);
    return text;
  }

  fs::path folder_;
  Millis now_ = 1'800'000'000'000;
  std::unique_ptr<Store> store_;
};

TEST_P(StoreTest, KeepsAJobWithItsFiles) {
  const Job made = create("solid head", "<svg/>");
  const Job found = job(made.id);
  EXPECT_EQ(found.id.size(), 26u);
  EXPECT_EQ(found.state, JobState::queued);
  EXPECT_EQ(found.attempt, 0);
  EXPECT_EQ(found.created, now_);
  EXPECT_EQ(found.input("scan")->extension, "stl");
  EXPECT_EQ(found.input("scan")->blob.bytes, 10u);
  EXPECT_EQ(found.input("scan")->blob.sha256, text_hash("solid head"));
  EXPECT_EQ(bytes_of(found.input("scan")->blob), "solid head");
  EXPECT_EQ(bytes_of(found.input("pattern")->blob), "<svg/>");
}

TEST_P(StoreTest, KeepsTokensAndRevokesThemForGood) {
  const Token first{"0001",    "station-1", {Scope::submit, Scope::read}, std::string(64, 'a'), 5,
                    now_ + 10, {}};
  const Token second{"0002", "admin", {Scope::admin}, std::string(64, 'b'), 6, {}, {}};
  ASSERT_TRUE(store_->add_token(first));
  ASSERT_TRUE(store_->add_token(second));
  EXPECT_EQ(store_->add_token(first).error().code, Code::conflict);
  ASSERT_TRUE(store_->revoke_token("0002"));
  const Millis revoked = now_;
  now_ += 1000;
  ASSERT_TRUE(store_->revoke_token("0002"));  // it stays the first time
  EXPECT_EQ(store_->revoke_token("0003").error().code, Code::not_found);
  crash();
  const Token found = store_->token("0001").value();
  EXPECT_EQ(found.owner, "station-1");
  EXPECT_EQ(found.scopes, first.scopes);
  EXPECT_EQ(found.hash, first.hash);
  EXPECT_EQ(found.created, 5);
  EXPECT_EQ(found.expires, first.expires);
  EXPECT_FALSE(found.revoked);
  EXPECT_EQ(store_->token("0002")->revoked, revoked);
  EXPECT_EQ(store_->token("0003").error().code, Code::not_found);
  EXPECT_EQ(store_->tokens()->size(), 2u);
}

TEST_P(StoreTest, ListsTheJobsOfOneOwner) {
  const auto submit = [&](const std::string& owner) {
    NewJob job = submission("a", "b");
    job.owner = owner;
    return store_->create(std::move(job))->id;
  };
  std::vector<std::string> first, all;
  for (int i = 0; i < 5; ++i) {
    first.insert(first.begin(), submit("first"));
    all.insert(all.begin(), first.front());
    all.insert(all.begin(), submit("second"));
  }
  const auto ids = [&](const std::optional<std::string>& owner) {
    std::vector<std::string> found;
    std::string cursor;
    for (;;) {
      const JobPage page = store_->list(2, cursor, owner).value();
      for (const Job& job : page.jobs) found.push_back(job.id);
      if (!page.next) return found;
      cursor = *page.next;
    }
  };
  EXPECT_EQ(ids("first"), first);
  EXPECT_EQ(ids(std::nullopt), all);
  EXPECT_TRUE(ids("third").empty());
}

TEST_P(StoreTest, CountsItsJobsByState) {
  EXPECT_EQ(store_->counts().value(), JobCounts{});
  create();
  create();
  store_->cancel(create().id).value();
  lease();
  JobCounts expected{};
  expected[static_cast<std::size_t>(JobState::queued)] = 1;
  expected[static_cast<std::size_t>(JobState::running)] = 1;
  expected[static_cast<std::size_t>(JobState::cancelled)] = 1;
  EXPECT_EQ(store_->counts().value(), expected);
}

TEST_P(StoreTest, WhatWasCreatedSurvivesACrashAndWhatWasNotLeavesNothing) {
  const Job made = create("kept", "kept too");
  Upload unfinished = upload("half a scan");
  crash();
  EXPECT_EQ(bytes_of(job(made.id).input("scan")->blob), "kept");
  EXPECT_TRUE(fs::is_empty(data() / "incoming"));
  EXPECT_EQ(blobs(), (std::set<std::string>{text_hash("kept"), text_hash("kept too")}));
}

// Every kind of input is kept over a crash, is part of what a key means, and goes with the job.
TEST_P(StoreTest, KeepsTheFurtherInputsOfAJobThatHasThem) {
  const auto submit = [&](const std::string& celsius) {
    NewJob job = submission("a scan", "a pattern", "key-0001");
    if (!celsius.empty()) job.add("temperature", upload(celsius), "csv");
    return store_->create(std::move(job));
  };
  const auto made = submit("140,141");
  ASSERT_TRUE(made) << made.error().text();
  crash();
  const Job found = job(made->id);
  ASSERT_EQ(found.inputs.size(), 3u);
  EXPECT_EQ(found.inputs[0].name, "scan");  // the order of api/job.hpp
  EXPECT_EQ(found.inputs[2].name, "temperature");
  EXPECT_EQ(found.inputs[2].extension, "csv");
  EXPECT_EQ(bytes_of(found.input("temperature")->blob), "140,141");
  EXPECT_EQ(submit("140,141")->id, made->id);
  EXPECT_EQ(submit("140,142").error().code, Code::conflict);
  EXPECT_EQ(submit("").error().code, Code::conflict);
  EXPECT_FALSE(job(create().id).input("temperature"));
  ASSERT_TRUE(store_->cancel(made->id) && store_->remove(made->id));
  EXPECT_EQ(blobs(), (std::set<std::string>{text_hash("a scan"), text_hash("a pattern")}));
}

TEST_P(StoreTest, AJobCanShareTheFilesOfAnother) {
  const Job first = create("a scan", "a pattern");
  const auto shared = [&] {
    NewJob job{"{}"};
    job.add("scan", first.input("scan")->blob, "stl");
    job.add("pattern", upload("another pattern"), "svg");
    return store_->create(std::move(job));
  };
  const Job second = shared().value();
  ASSERT_TRUE(store_->cancel(first.id) && store_->remove(first.id));
  EXPECT_EQ(bytes_of(job(second.id).input("scan")->blob), "a scan");
  ASSERT_TRUE(store_->cancel(second.id) && store_->remove(second.id));
  EXPECT_EQ(shared().error().code, Code::gone);
  EXPECT_TRUE(blobs().empty());
  EXPECT_TRUE(store_->list(1, "")->jobs.empty());
}

TEST_P(StoreTest, KnowsTheNewestInspectionOfAScan) {
  const auto scan = store_->add_scan("station", upload("a scan"), "stl");
  ASSERT_TRUE(scan);
  const auto inspect = [&](const std::string& owner, const std::string& bytes, const std::string& extension) {
    NewJob job{"{}"};
    job.add("scan", upload(bytes), extension);
    job.owner = owner;
    job.kind = JobKind::inspection;
    return store_->create(std::move(job))->id;
  };
  inspect("another", "a scan", "stl");
  inspect("station", "a scan", "obj");
  inspect("station", "another scan", "stl");
  NewJob print = submission();
  print.owner = "station";
  const std::string printed = store_->create(std::move(print))->id;
  EXPECT_EQ(job(printed).kind, JobKind::print);
  EXPECT_FALSE(*store_->newest_inspection(*scan));
  inspect("station", "a scan", "stl");
  const std::string newest = inspect("station", "a scan", "stl");
  reopen();
  const auto found = store_->newest_inspection(*scan);
  ASSERT_TRUE(found && *found);
  EXPECT_EQ((*found)->id, newest);
  EXPECT_EQ((*found)->kind, JobKind::inspection);
  EXPECT_FALSE((*found)->input("pattern"));
}

TEST_P(StoreTest, ABlobWithoutARowIsDeletedAtTheNextStart) {
  create("kept", "kept too");
  const std::string orphan = text_hash("orphan");
  fs::create_directories(data() / "blobs" / orphan.substr(0, 2));
  std::ofstream(data() / "blobs" / orphan.substr(0, 2) / orphan) << "orphan";
  reopen();
  EXPECT_EQ(blobs().count(orphan), 0u);
  EXPECT_EQ(blobs().size(), 2u);
}

TEST_P(StoreTest, AnAbandonedUploadLeavesNoFile) {
  { const Upload gone = upload("nobody wants this"); }
  EXPECT_TRUE(fs::is_empty(data() / "incoming"));
}

TEST_P(StoreTest, OneProcessAtATime) {
  const auto second = GetParam().open(data(), options());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Code::unavailable);
  EXPECT_EQ(second.error().what, "another server uses this data folder");
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
  EXPECT_EQ(store_->complete(second).value().state, JobState::succeeded);
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
  const auto expired = store_->bury("local-1").value();
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
  const Job done = store_->complete(key).value();
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
  const Error error{Code::internal, "broke down", "", ""};
  EXPECT_EQ(store_->fail_job(lease(), error, Retry::after_fault).value().state, JobState::queued);
  EXPECT_EQ(store_->fail_job(lease(), error, Retry::after_crash).value().state, JobState::queued);
  EXPECT_EQ(store_->fail_job(lease(), error, Retry::after_crash).value().state, JobState::failed);
  EXPECT_EQ(store_->log_after(id, 0, 100)->back().text, "failed: internal");
  EXPECT_EQ(store_->log_after(id, 0, 100)->size(), 7u);
}

TEST_P(StoreTest, WhatBefellItsWorkersIsNotHeldAgainstAJob) {
  const std::string id = create().id;
  const Error error{Code::internal, "broke down", "", ""};
  ASSERT_TRUE(store_->fail_job(lease(), error, Retry::after_crash));
  for (int i = 0; i < 2; ++i) {  // of three
    lease();
    now_ += 30'001;
    ASSERT_EQ(store_->expire()->size(), 1u);
  }
  EXPECT_EQ(store_->complete(lease())->state, JobState::succeeded);
}

TEST_P(StoreTest, AJobOutlivesEightMinutesOfTroubleButNotAnHour) {
  store_.reset();
  StoreOptions plain;  // what a server has
  plain.clock = [this] { return now_; };
  store_ = std::move(*GetParam().open(data(), plain));
  const std::string id = create().id;
  const Millis begun = now_;
  int attempts = 0;
  for (; job(id).state == JobState::queued; ++attempts) {
    now_ = job(id).not_before.value_or(now_);
    lease();
    ASSERT_EQ(store_->bury("tester")->size(), 1u);
  }
  EXPECT_EQ(attempts, 10);
  EXPECT_EQ(job(id).state, JobState::failed);
  EXPECT_EQ(job(id).error->what, "10 workers were lost while they ran this job");
  EXPECT_GE(now_ - begun, 511'000);  // (2 s + 4 s + ... + 512 s) / 2
  EXPECT_LE(now_ - begun, 1'533'000);
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
  EXPECT_FALSE(job(id).not_before);  // given back unharmed
  lease();
  now_ += 30'001;
  ASSERT_EQ(store_->expire()->size(), 1u);
  EXPECT_GE(job(id).not_before.value(), now_ + 8000);  // the fifth
}

TEST_P(StoreTest, OwnersTakeTurns) {
  const auto submit = [&](const std::string& owner, int priority = 0) {
    NewJob job = submission();
    job.owner = owner;
    job.priority = priority;
    return store_->create(std::move(job))->id;
  };
  const auto next = [&] { return lease().job; };
  // One submits many at once, the others do not wait for all of them.
  const std::string a1 = submit("a"), a2 = submit("a"), a3 = submit("a"), a4 = submit("a");
  const std::string b1 = submit("b"), b2 = submit("b", -1), b3 = submit("b"), c1 = submit("c");
  EXPECT_EQ(next(), a1);
  EXPECT_EQ(next(), b1);  // a runs one
  EXPECT_EQ(next(), c1);
  EXPECT_EQ(next(), a2);  // each runs one: a was served the longest ago
  EXPECT_EQ(next(), b3);  // which its owner put before b2
  const std::string c2 = submit("c");
  EXPECT_EQ(next(), c2);  // c runs one, a and b two
  const std::string a5 = submit("a", 3), b4 = submit("b", 5);
  EXPECT_EQ(next(), b4);  // raised, whoever's turn it is
  EXPECT_EQ(next(), a5);
  EXPECT_EQ(next(), b2);  // a and b run three each, and b was served before a
  EXPECT_EQ(next(), a3);
  EXPECT_EQ(next(), a4);
  EXPECT_FALSE(store_->lease("idle").value().has_value());
}

TEST_P(StoreTest, TheQueueIsBounded) {
  StoreOptions small = options();
  small.most_queued = 5;
  small.most_queued_by_owner = 3;
  store_.reset();
  store_ = std::move(*GetParam().open(data(), small));
  const auto submit = [&](const std::string& owner, const std::string& key = "") {
    NewJob job = submission("a scan", "a pattern", key);
    job.owner = owner;
    return store_->create(std::move(job));
  };
  const std::string first = submit("a", "key-0001")->id;
  ASSERT_TRUE(submit("a") && submit("a"));
  EXPECT_EQ(submit("a").error().code, Code::busy);
  EXPECT_EQ(submit("a", "key-0001")->id, first);  // which it has taken already
  ASSERT_TRUE(submit("b") && submit("b"));
  EXPECT_EQ(submit("b").error().what, "the queue is full: 5 jobs wait");
  ASSERT_TRUE(store_->cancel(first));
  reopen();
  EXPECT_TRUE(submit("b"));
  lease();
  EXPECT_TRUE(submit("c"));  // what runs does not wait
}

TEST_P(StoreTest, ADamagedFileIsNotGiven) {
  const Job made = create("a scan", "a pattern");
  reopen();
  const std::string hash = made.input("scan")->blob.sha256;
  std::ofstream(data() / "blobs" / hash.substr(0, 2) / hash) << "a scar";
  EXPECT_EQ(store_->open(made.input("scan")->blob).error().code, Code::gone);
  EXPECT_EQ(bytes_of(made.input("pattern")->blob), "a pattern");
}

TEST_P(StoreTest, SendingADamagedFileAgainMendsIt) {
  const Job made = create("a scan", "a pattern");
  const std::string hash = made.input("scan")->blob.sha256;
  std::ofstream(data() / "blobs" / hash.substr(0, 2) / hash) << "a scar";
  create("a scan", "another pattern");
  EXPECT_EQ(bytes_of(made.input("scan")->blob), "a scan");
}

TEST_P(StoreTest, TellsWhenABlobIsGone) {
  std::vector<std::string> gone;
  StoreOptions telling = options();
  telling.blob_gone = [&](const std::string& sha256) { gone.push_back(sha256); };
  store_.reset();
  store_ = std::move(*GetParam().open(data(), telling));
  const Job first = create("a scan", "one"), second = create("a scan", "two");
  ASSERT_TRUE(store_->cancel(first.id) && store_->remove(first.id));
  EXPECT_EQ(gone, std::vector{text_hash("one")});
  ASSERT_TRUE(store_->cancel(second.id) && store_->remove(second.id));
  EXPECT_EQ(std::set<std::string>(gone.begin(), gone.end()),
            (std::set{text_hash("one"), text_hash("a scan"), text_hash("two")}));
}

TEST_P(StoreTest, ABackupOpensAsTheStoreWas) {
  const Job made = create("a scan", "a pattern"), ended = create("a scan", "another");
  const LeaseKey key = lease();
  ASSERT_TRUE(store_->put_artifact(key, "print.png", upload("ink")));
  ASSERT_TRUE(store_->complete(key));
  const fs::path to = folder_ / "backup";
  const auto go_on = [] { return true; };
  EXPECT_EQ(store_->backup(to, go_on).error().code, Code::bad_usage);  // no such folder
  fs::create_directory(to);
  EXPECT_EQ(store_->backup(to, go_on).error().code, Code::bad_usage);  // others may look into it
  fs::permissions(to, fs::perms::owner_all);
  const auto report = store_->backup(to, [&] {  // in use meanwhile
    EXPECT_TRUE(store_->cancel(ended.id));
    return true;
  });
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->jobs, 2);
  EXPECT_EQ(report->blobs, 4);
  EXPECT_TRUE(report->damaged.empty());
  EXPECT_EQ(store_->backup(to, go_on).error().code, Code::bad_usage);  // not empty any more
  ASSERT_TRUE(store_->remove(made.id));
  store_.reset();
  fs::remove_all(data());
  fs::rename(to, data());
  reopen();
  EXPECT_EQ(job(made.id).state, JobState::succeeded);
  EXPECT_EQ(bytes_of(job(made.id).artifacts.at(0).blob), "ink");
  EXPECT_EQ(bytes_of(job(ended.id).input("pattern")->blob), "another");
}

TEST_P(StoreTest, ABackupKeepsWhatIsDeletedMeanwhileAndLeavesOutWhatIsDamaged) {
  const Job made = create("a scan", "a pattern");
  ASSERT_TRUE(store_->cancel(made.id));
  const std::string damaged = create("damaged", "whole").input("scan")->blob.sha256;
  reopen();
  std::ofstream(data() / "blobs" / damaged.substr(0, 2) / damaged) << "other";
  const fs::path to = folder_ / "backup";
  fs::create_directory(to);
  fs::permissions(to, fs::perms::owner_all);
  int asked = 0;
  const auto report = store_->backup(to, [&] {
    if (++asked == 2) {  // the rows are copied, the blobs not yet
      EXPECT_TRUE(store_->remove(made.id));
    }
    return true;
  });
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->jobs, 2);
  EXPECT_EQ(report->blobs, 3);
  EXPECT_EQ(report->damaged, std::vector{damaged});
  EXPECT_EQ(blobs().size(), 2u);  // of the store itself
  store_.reset();
  fs::remove_all(data());
  fs::rename(to, data());
  reopen();
  EXPECT_EQ(bytes_of(job(made.id).input("scan")->blob), "a scan");
}

TEST_P(StoreTest, CancellingAQueuedJobIsDoneAtOnce) {
  const std::string id = create().id;
  EXPECT_EQ(store_->cancel(id).value().state, JobState::cancelled);
  EXPECT_EQ(store_->cancel(id).value().state, JobState::cancelled);
  EXPECT_FALSE(store_->lease("worker").value().has_value());
}

TEST_P(StoreTest, CancellingARunningJobIsToldToItsWorker) {
  const std::string id = create().id;
  const LeaseKey key = lease();
  EXPECT_EQ(store_->cancel(id).value().state, JobState::cancelling);
  EXPECT_TRUE(store_->heartbeat(key, Stage::scan, 0.5).value());
  EXPECT_EQ(store_->cancelled(key).value().state, JobState::cancelled);
  EXPECT_TRUE(job(id).ended.has_value());
}

TEST_P(StoreTest, ACancelWinsOverACompletionThatDidNotHearOfIt) {
  const std::string id = create().id;
  const LeaseKey key = lease();
  ASSERT_TRUE(store_->cancel(id));
  EXPECT_EQ(store_->complete(key).value().state, JobState::cancelled);
}

TEST_P(StoreTest, ACancelledJobWhoseWorkerDiedIsCancelledNotRunAgain) {
  const std::string id = create().id;
  lease();
  ASSERT_TRUE(store_->cancel(id));
  now_ += 30'001;
  EXPECT_EQ(store_->expire().value().at(0).state, JobState::cancelled);
  EXPECT_EQ(job(id).state, JobState::cancelled);
}

TEST_P(StoreTest, AnEndedJobCannotBeCancelled) {
  const std::string id = create().id;
  ASSERT_TRUE(store_->complete(lease()));
  EXPECT_EQ(store_->cancel(id).error().code, Code::conflict);
  EXPECT_EQ(store_->cancel("nobody").error().code, Code::not_found);
}

TEST_P(StoreTest, OnlyEndedJobsAreDeleted) {
  const std::string id = create().id;
  EXPECT_EQ(store_->remove(id).error().code, Code::conflict);
  const LeaseKey key = lease();
  EXPECT_EQ(store_->remove(id).error().code, Code::conflict);
  ASSERT_TRUE(store_->complete(key));
  EXPECT_TRUE(store_->remove(id));
  EXPECT_EQ(store_->job(id).error().code, Code::not_found);
  EXPECT_EQ(store_->remove(id).error().code, Code::not_found);
  EXPECT_TRUE(blobs().empty());
}

TEST_P(StoreTest, ASharedFileStaysAsLongAsAnyJobNamesIt) {
  const std::string first = create("same scan", "one").id, second = create("same scan", "two").id;
  EXPECT_EQ(blobs().size(), 3u);  // the scan is there once
  const LeaseKey key = lease();
  ASSERT_TRUE(store_->put_artifact(key, "report.json", upload("one")));  // the bytes of a pattern
  ASSERT_TRUE(store_->complete(key));
  auto reading = store_->open(job(first).input("pattern")->blob).value();
  ASSERT_TRUE(store_->remove(first));
  EXPECT_EQ(blobs(), (std::set<std::string>{text_hash("same scan"), text_hash("two")}));
  EXPECT_EQ(bytes_of(job(second).input("scan")->blob), "same scan");
  std::string text(3, '\0');
  EXPECT_EQ(reading.read_at(0, text).value(), 3u);  // a download under way ends well
  EXPECT_EQ(text, "one");
}

TEST_P(StoreTest, OnlySuccessKeepsArtifacts) {
  const auto half_done = [&](const std::string& bytes) {
    create();
    const LeaseKey key = lease();
    EXPECT_TRUE(store_->put_artifact(key, "print.png", upload(bytes)));
    return key;
  };
  const LeaseKey failed = half_done("of the failed");
  EXPECT_EQ(
      store_->fail_job(failed, {Code::internal, "a fault", "", ""}, Retry::never).value().artifacts.size(),
      0u);
  const LeaseKey cancelled = half_done("of the cancelled");
  ASSERT_TRUE(store_->cancel(cancelled.job));
  EXPECT_EQ(store_->cancelled(cancelled).value().artifacts.size(), 0u);
  const LeaseKey done = half_done("of the done");
  EXPECT_EQ(store_->complete(done).value().artifacts.size(), 1u);
  EXPECT_EQ(blobs().count(text_hash("of the failed")) + blobs().count(text_hash("of the cancelled")), 0u);
  EXPECT_EQ(blobs().count(text_hash("of the done")), 1u);
}

TEST_P(StoreTest, ASecondArtifactOfTheSameNameReplacesTheFirst) {
  const std::string id = create().id;
  const LeaseKey key = lease();
  ASSERT_TRUE(store_->put_artifact(key, "report.json", upload("first")));
  ASSERT_TRUE(store_->put_artifact(key, "print.png", upload("ink")));
  ASSERT_TRUE(store_->put_artifact(key, "report.json", upload("second")));
  const Job found = job(id);
  ASSERT_EQ(found.artifacts.size(), 2u);
  EXPECT_EQ(found.artifacts[0].name, "print.png");  // the order of api/job.hpp
  EXPECT_EQ(bytes_of(found.artifacts[1].blob), "second");
  EXPECT_EQ(blobs().count(text_hash("first")), 0u);
}

TEST_P(StoreTest, ARestartLeavesRunningJobsAWholeLeaseMore) {
  const std::string id = create().id;
  const LeaseKey key = lease();
  now_ += 60'000;  // the server was away
  crash();
  EXPECT_EQ(job(id).state, JobState::running);
  now_ += 29'000;
  EXPECT_FALSE(store_->heartbeat(key, Stage::forming, 0.5).value());
  now_ += 30'001;
  EXPECT_EQ(store_->expire().value().size(), 1u);
}

TEST_P(StoreTest, OneKeyMakesOneJob) {
  const auto submit = [&](const std::string& scan, const std::string& key) {
    return store_->create(submission(scan, "a pattern", key));
  };
  const std::string id = submit("a scan", "key-0001")->id;
  EXPECT_EQ(submit("a scan", "key-0001")->id, id);
  reopen();
  EXPECT_EQ(submit("a scan", "key-0001")->id, id);
  EXPECT_EQ(submit("another", "key-0001").error().code, Code::conflict);
  EXPECT_EQ(blobs().size(), 2u);
  EXPECT_NE(submit("a scan", "key-0002")->id, id);
  EXPECT_NE(submit("a scan", "")->id, submit("a scan", "")->id);
  EXPECT_EQ(store_->list(100, "")->jobs.size(), 4u);
}

TEST_P(StoreTest, WritesDownWhatHappensToAJob) {
  const std::string id = create().id;
  ASSERT_TRUE(store_->release(lease()));
  const LeaseKey key = lease();
  ASSERT_TRUE(store_->log(key, 0, {"stage scan", "stage forming"}));
  ASSERT_TRUE(store_->cancel(id));
  ASSERT_TRUE(store_->cancelled(key));
  crash();
  std::vector<std::string> texts;
  const auto lines = store_->log_after(id, 0, 100).value();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_EQ(lines[i].number, static_cast<std::int64_t>(i) + 1);
    EXPECT_EQ(lines[i].time, now_);
    texts.push_back(lines[i].text);
  }
  EXPECT_EQ(texts, (std::vector<std::string>{"queued", "attempt 1 begins",
                                             "given back by its worker, queued again", "attempt 2 begins",
                                             "stage scan", "stage forming", "asked to cancel", "cancelled"}));
  const auto page = store_->log_after(id, 4, 2).value();
  ASSERT_EQ(page.size(), 2u);
  EXPECT_EQ(page[0].text, "stage scan");
  EXPECT_TRUE(store_->log_after(id, 8, 2)->empty());
  EXPECT_EQ(store_->log_after("nobody", 0, 2).error().code, Code::not_found);
}

TEST_P(StoreTest, AWorkersLinesAreWrittenOnceAndAreBounded) {
  const std::string id = create().id;
  const LeaseKey key = lease();
  const auto before = store_->log_after(id, 0, 1000)->size();
  ASSERT_TRUE(store_->log(key, 0, {"a", "b"}));
  ASSERT_TRUE(store_->log(key, 0, {"a", "b", "c"}));  // whose answer was lost
  ASSERT_TRUE(store_->log(key, 2, {"c"}));
  ASSERT_TRUE(store_->log(key, 5, {"out of order"}));
  const auto lines = store_->log_after(id, static_cast<std::int64_t>(before), 1000).value();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[2].text, "c");
  std::vector<std::string> many(700, std::string(300, 'x'));
  many[0] = "caf\xc3\xa9\n";
  ASSERT_TRUE(store_->log(key, 3, many));
  const auto all = store_->log_after(id, static_cast<std::int64_t>(before), 1000).value();
  EXPECT_EQ(all.size(), static_cast<std::size_t>(most_log_lines));
  EXPECT_EQ(all[3].text, "caf???");
  EXPECT_EQ(all[4].text.size(), static_cast<std::size_t>(longest_log_line));
  EXPECT_EQ(store_->log({id, "wrong"}, 0, {"x"}).error().code, Code::lease_lost);
  ASSERT_TRUE(store_->release(key));
  ASSERT_TRUE(store_->log(lease(), 0, {"of the second attempt"}));
}

TEST_P(StoreTest, EveryVisibleChangeGivesAJobAGreaterVersion) {
  const Job made = create();
  std::int64_t version = made.version;
  const auto grown = [&] {
    const std::int64_t before = version;
    version = job(made.id).version;
    return version > before;
  };
  EXPECT_FALSE(grown());
  const LeaseKey key = lease();
  EXPECT_TRUE(grown());
  ASSERT_TRUE(store_->heartbeat(key, Stage::scan, 0.5));
  EXPECT_TRUE(grown());
  ASSERT_TRUE(store_->heartbeat(key, Stage::scan, 0.5));
  EXPECT_FALSE(grown());
  ASSERT_TRUE(store_->log(key, 0, {"a line"}));
  EXPECT_TRUE(grown());
  ASSERT_TRUE(store_->cancel(made.id));
  EXPECT_TRUE(grown());
  ASSERT_TRUE(store_->cancelled(key));
  EXPECT_TRUE(grown());
}

TEST_P(StoreTest, WaitsForNewsOfAJob) {
  using namespace std::chrono_literals;
  const Job made = create(), other = create();
  EXPECT_EQ(store_->wait_for_change(made.id, 0, 1h)->version, made.version);  // what is known is no news
  EXPECT_EQ(store_->wait_for_change(made.id, made.version, 0ms)->version, made.version);
  EXPECT_EQ(store_->wait_for_change("nobody", 0, 1h).error().code, Code::not_found);
  std::thread worker([&] {
    ASSERT_TRUE(store_->cancel(other.id));
    ASSERT_TRUE(store_->cancel(made.id));
  });
  EXPECT_EQ(store_->wait_for_change(made.id, made.version, 1h)->state, JobState::cancelled);
  worker.join();
  const std::int64_t last = job(made.id).version;
  std::thread deleter([&] { ASSERT_TRUE(store_->remove(made.id)); });
  EXPECT_EQ(store_->wait_for_change(made.id, last, 1h).error().code, Code::not_found);
  deleter.join();
}

TEST_P(StoreTest, OnlySoManyWait) {
  using namespace std::chrono_literals;
  StoreOptions two = options();
  two.most_waiters = 2;
  store_.reset();
  store_ = std::move(*GetParam().open(data(), two));
  const Job made = create();
  std::atomic<int> refused = 0;
  std::vector<std::thread> waiters;
  for (int i = 0; i < 3; ++i)
    waiters.emplace_back([&] {
      const auto seen = store_->wait_for_change(made.id, made.version, 1h);
      if (!seen && seen.error().code == Code::busy) ++refused;
    });
  while (refused == 0) std::this_thread::yield();
  ASSERT_TRUE(store_->cancel(made.id));
  for (auto& waiter : waiters) waiter.join();
  EXPECT_EQ(refused, 1);
}

TEST_P(StoreTest, ListsInPagesFromTheNewest) {
  std::vector<std::string> made;
  for (int i = 0; i < 7; ++i) made.insert(made.begin(), create("scan " + std::to_string(i)).id);
  std::vector<std::string> listed;
  std::string cursor;
  for (int pages = 1;; ++pages) {
    const JobPage page = store_->list(3, cursor).value();
    for (const Job& j : page.jobs) listed.push_back(j.id);
    if (!page.next) {
      EXPECT_EQ(pages, 3);
      break;
    }
    cursor = *page.next;
  }
  EXPECT_EQ(listed, made);
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
        if (!store_->complete({(*leased)->job.id, (*leased)->token})) return;
        const std::lock_guard hold(mutex);
        done.push_back((*leased)->job.id);
      }
    });
  for (auto& worker : workers) worker.join();
  EXPECT_EQ(done.size(), static_cast<std::size_t>(jobs));
  EXPECT_EQ(std::set<std::string>(done.begin(), done.end()).size(), static_cast<std::size_t>(jobs));
}

INSTANTIATE_TEST_SUITE_P(, StoreTest, testing::Values(Backend{"Sqlite", open_store}),
                         [](const auto& backend) { return backend.param.name; });

}  // namespace
}  // namespace vacuform
