// Order, limits and cancellation in the queue; log, events and lists of jobs.
#include "tests/unit/server/store/store_fixture.hpp"

namespace vacuform {
namespace {

TEST_P(StoreTest, OwnersTakeTurns) {
  const auto submit = [&](const std::string& owner, int priority = 0) {
    NewJob job = submission();
    job.owner = owner;
    job.priority = priority;
    return store_->create(std::move(job))->id;
  };
  const auto next = [&] { return lease().job; };
  // One owner submits many jobs at once; the other owners do not wait for all of them.
  const std::string a1 = submit("a"), a2 = submit("a"), a3 = submit("a"), a4 = submit("a");
  const std::string b1 = submit("b"), b2 = submit("b", -1), b3 = submit("b"), c1 = submit("c");
  EXPECT_EQ(next(), a1);
  EXPECT_EQ(next(), b1);  // a has one running job
  EXPECT_EQ(next(), c1);
  EXPECT_EQ(next(), a2);  // each has one running job: a was served the longest ago
  EXPECT_EQ(next(), b3);  // which its owner put before b2
  const std::string c2 = submit("c");
  EXPECT_EQ(next(), c2);  // c has one running job, a and b have two
  const std::string a5 = submit("a", 3), b4 = submit("b", 5);
  EXPECT_EQ(next(), b4);  // a raised priority comes first, regardless of the owner
  EXPECT_EQ(next(), a5);
  EXPECT_EQ(next(), b2);  // a and b have three running jobs each, and b was served before a
  EXPECT_EQ(next(), a3);
  EXPECT_EQ(next(), a4);
  EXPECT_FALSE(store_->lease("idle").value().has_value());
}

TEST_P(StoreTest, TellsThePlaceInTheQueue) {
  const auto submit = [&](const std::string& owner, int priority = 0) {
    NewJob job = submission();
    job.owner = owner;
    job.priority = priority;
    return store_->create(std::move(job))->id;
  };
  const auto place = [&](const std::string& id) { return store_->estimate(job(id))->queue_position; };
  std::vector<std::string> waiting;
  for (const char* owner : {"a", "a", "a", "a", "b", "b", "c"}) waiting.push_back(submit(owner));
  waiting.push_back(submit("b", -1));
  // One worker, which ends each job before it takes the next.
  while (!waiting.empty()) {
    std::map<std::int64_t, std::string> order;
    for (const std::string& id : waiting) order[place(id).value()] = id;
    ASSERT_EQ(order.size(), waiting.size());
    EXPECT_EQ(order.begin()->first, 1);
    EXPECT_EQ(order.rbegin()->first, static_cast<std::int64_t>(waiting.size()));
    const LeaseKey key = lease();
    EXPECT_EQ(key.job, order.begin()->second);
    EXPECT_FALSE(place(key.job));
    ASSERT_TRUE(store_->fail_job(key, {Code::unusable_scan, "it is flat", {}, {}}, Retry::never));
    EXPECT_FALSE(place(key.job));
    std::erase(waiting, key.job);
  }
  const std::string usual = submit("a"), second = submit("b", 1), first = submit("b", 2),
                    third = submit("c", 1);
  EXPECT_EQ(place(first), 1);
  EXPECT_EQ(place(second), 2);
  EXPECT_EQ(place(third), 3);
  EXPECT_EQ(place(usual), 4);
}

TEST_P(StoreTest, TellsHowLongAJobMayTake) {
  const auto expected = [&](const std::string& scan, JobKind kind = JobKind::print) {
    NewJob job = submission(scan);
    job.kind = kind;
    const Job made = store_->create(std::move(job)).value();
    const auto seconds = store_->estimate(made)->seconds_expected;
    EXPECT_TRUE(store_->cancel(made.id));
    EXPECT_FALSE(store_->estimate(this->job(made.id))->seconds_expected);  // it has ended
    return seconds;
  };
  const auto run = [&](const std::string& scan, Millis time) {
    create(scan);
    const LeaseKey key = lease();
    now_ += time;
    ASSERT_TRUE(complete(key));
  };
  const std::string small(100, 's'), large(1000, 'l');
  EXPECT_FALSE(expected(small));
  for (const Millis time : {9000, 1000, 2000}) run(small, time);
  EXPECT_EQ(expected(small), 2.0);
  EXPECT_EQ(expected(std::string(400, 's')), 2.0);
  EXPECT_EQ(expected(large), 2.0);  // none of its size: all of its kind
  run(large, 20'000);
  EXPECT_EQ(expected(large), 20.0);
  EXPECT_EQ(expected(small), 2.0);
  EXPECT_FALSE(expected(small, JobKind::inspection));
  for (int i = 0; i < 20; ++i) run(small, 5000);
  EXPECT_EQ(expected(small), 5.0);  // the last twenty alone
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
  EXPECT_EQ(submit("a", "key-0001")->id, first);  // which was accepted already
  ASSERT_TRUE(submit("b") && submit("b"));
  EXPECT_EQ(submit("b").error().what, "the queue is full: 5 jobs wait");
  ASSERT_TRUE(store_->cancel(first));
  reopen();
  EXPECT_TRUE(submit("b"));
  lease();
  EXPECT_TRUE(submit("c"));  // running jobs do not count as waiting
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
  ASSERT_TRUE(complete(lease()));
  EXPECT_EQ(store_->cancel(id).error().code, Code::conflict);
  EXPECT_EQ(store_->cancel("nobody").error().code, Code::not_found);
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
  ASSERT_TRUE(store_->log(key, 0, {"a", "b", "c"}));  // the answer to this call was lost
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
  EXPECT_EQ(store_->wait_for_change(made.id, 0, 1h)->version, made.version);  // a known one is no change
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
  EXPECT_TRUE(eventually([&] { return refused > 0; }));
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

}  // namespace
}  // namespace vacuform
