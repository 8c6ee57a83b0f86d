// The power fails at every flush of the store, before and after it, and after every answer: whatever was answered until
// then is there when the store is opened again, and what was under way has happened wholly or not at all.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <vector>

#include "api/base/file.hpp"
#include "api/base/secrets.hpp"
#include "flushed_disk.hpp"
#include "server/store/store.hpp"

namespace vacuform {
namespace {

namespace fs = std::filesystem;

using States = std::map<std::string, JobState>;  // of the jobs there are

// What may be found after a loss of power at one moment.
struct Moment {
  FlushedDisk disk, live;
  std::size_t answered;  // calls of the store
};

class PowerLoss : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    folder_ = fs::temp_directory_path() / ("vacuform-power-" + random_hex(8));
    fs::create_directories(folder_);
    folder_ = fs::canonical(folder_);
    watch_flushes([this](const FlushedDisk& disk) {
      moments_.push_back({disk, live_disk(data()), answers_.size()});
    });
    auto store = open_store(data(), options());
    ASSERT_TRUE(store) << store.error().text();
    store_ = std::move(*store);
    answered(states_);
  }
  void TearDown() override {
    watch_flushes({});
    store_.reset();
    fs::remove_all(folder_);
  }

  fs::path data() const { return folder_ / "data"; }
  static StoreOptions options() {
    StoreOptions options;
    options.clock = [] { return Millis{1'800'000'000'000}; };
    options.kept_free = 0;
    return options;
  }

  Upload upload(const std::string& bytes) {
    auto upload = store_->upload();
    EXPECT_TRUE(upload && upload->write(bytes));
    return std::move(*upload);
  }
  // A call was answered: from now on the jobs are in these states.
  void answered(const States& states) {
    states_ = states;
    answers_.push_back(states);
    moments_.push_back({flushed_disk(), live_disk(data()), answers_.size()});
  }
  void answered(const Job& job) {
    States states = states_;
    states[job.id] = job.state;
    answered(states);
  }
  Job created(const std::string& scan) {
    NewJob wanted{.settings = "{}", .kind = JobKind::inspection};
    wanted.add("scan", upload(scan), "stl");
    wanted.add("pattern", upload("a pattern"), "svg");
    const auto job = store_->create(std::move(wanted));
    EXPECT_TRUE(job) << job.error().text();
    answered(*job);
    return *job;
  }
  LeaseKey leased() {
    const auto lease = store_->lease("worker");
    EXPECT_TRUE(lease && *lease);
    answered((*lease)->job);
    return {(*lease)->job.id, (*lease)->token};
  }

  // The states after a loss of power at that moment; each job's scan must be whole.
  States found_after(const FlushedDisk& disk) {
    const fs::path after = folder_ / "after";
    fs::remove_all(after);
    disk.restore(data(), after);
    States states;
    const auto store = open_store(after, options());
    EXPECT_TRUE(store) << store.error().text();
    if (!store) return states;
    const auto page = (*store)->list(100, "");
    EXPECT_TRUE(page) << page.error().text();
    if (!page) return states;
    for (const Job& job : page->jobs) {
      states[job.id] = job.state;
      const auto file = (*store)->open(job.input("scan")->blob);
      EXPECT_TRUE(file) << file.error().text();
      if (job.state == JobState::succeeded) {
        EXPECT_EQ(job.artifacts.size(), 3u);
        EXPECT_TRUE((*store)->open(job.artifacts.at(0).blob));
      }
    }
    return states;
  }

  fs::path folder_;
  std::unique_ptr<Store> store_;
  States states_;
  std::vector<States> answers_;
  std::vector<Moment> moments_;
};

class PowerLossWhileWorking : public PowerLoss {
 protected:
  void work() {
    const Job first = created("first"), second = created("second"), third = created("third");
    const LeaseKey one = leased();
    for (const char* name : {"findings.json", "preview-findings.png", "mold.stl"})
      ASSERT_TRUE(store_->put_artifact(one, name, upload("{}")));
    answered(*store_->complete(one));
    answered(*store_->cancel(second.id));
    const LeaseKey three = leased();
    answered(*store_->release(three));
    States without = states_;
    ASSERT_TRUE(store_->remove(second.id));
    without.erase(second.id);
    answered(without);
    created("first");  // the same bytes as a file that is there
    watch_flushes({});
    ASSERT_GT(moments_.size(), 60u);  // ten answers, each with a flush or more, before and after it
  }

  // `disk_at` gives what is on the disk after a loss at that moment.
  template <class DiskAt>
  void expect_what_was_answered(DiskAt&& disk_at) {
    for (std::size_t i = 0; i < moments_.size(); ++i) {
      SCOPED_TRACE("moment " + std::to_string(i) + " of " + std::to_string(moments_.size()));
      const std::size_t n = moments_[i].answered;
      if (n == 0) continue;  // the store was not open yet
      const States found = found_after(disk_at(moments_[i]));
      const bool as_before = found == answers_[n - 1], as_after = n < answers_.size() && found == answers_[n];
      EXPECT_TRUE(as_before || as_after) << "after " << n << " answers: " << testing::PrintToString(found);
    }
  }
};

TEST_F(PowerLossWhileWorking, KeepsAcknowledgedWorkAfterALossAtEveryFlush) {
  work();
  expect_what_was_answered([](const Moment& moment) { return moment.disk; });
}

TEST_F(PowerLossWhileWorking, KeepsAcknowledgedWorkWhenUnflushedWritesAreTornAndReordered) {
  work();
  for (unsigned seed = 1; seed <= 5; ++seed)
    expect_what_was_answered([&](const Moment& moment) { return torn_disk(moment.disk, moment.live, seed); });
}

TEST_F(PowerLoss, BytesThatAreThereCostNoFlush) {
  created("first");
  const std::size_t before = moments_.size();
  created("first");
  EXPECT_EQ(moments_.size(), before + 3);  // one flush of the row, before and after it counts, and the answer
}

// Without this a model that forgets nothing would pass.
TEST_F(PowerLoss, TheDiskForgetsWhatWasNotFlushed) {
  const fs::path file = data() / "unflushed";
  { std::ofstream(file) << "bytes"; }
  const fs::path after = folder_ / "after";
  flushed_disk().restore(data(), after);
  EXPECT_FALSE(fs::exists(after / "unflushed"));
  ASSERT_TRUE(sync_directory(data()));
  flushed_disk().restore(data(), folder_ / "named");
  EXPECT_EQ(fs::file_size(folder_ / "named" / "unflushed"), 0u);
}

// Nor may one that never tears.
TEST_F(PowerLoss, TheDiskTearsWhatWasNotFlushed) {
  const fs::path file = data() / "torn";
  std::ofstream(file) << std::string(64 * 512, 'a');
  const FlushedDisk before = live_disk(data());
  std::ofstream(file, std::ios::in | std::ios::out) << std::string(64 * 512, 'b');
  torn_disk(before, live_disk(data()), 1).restore(data(), folder_ / "torn");
  std::ifstream in(folder_ / "torn" / "torn");
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  ASSERT_EQ(bytes.size(), 64u * 512);
  EXPECT_NE(bytes.find(std::string(512, 'a')), std::string::npos);
  EXPECT_NE(bytes.find(std::string(512, 'b')), std::string::npos);
}

}  // namespace
}  // namespace vacuform
