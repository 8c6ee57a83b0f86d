// Fills the disk at every call of the store in turn, once or permanently. Nothing that was confirmed is lost, no
// partial data is kept, and everything works again as soon as there is space.
#include "full_disk.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "api/base/secrets.hpp"
#include "server/jobs/uploads.hpp"

namespace vacuform {
namespace {

namespace fs = std::filesystem;

constexpr const char* due_artifacts[] = {"findings.json", "preview-findings.png", "mold.stl"};

class Text : public http::Body {
 public:
  explicit Text(std::string text) : text_(std::move(text)) {}
  Result<void> read(const Taker& take) override { return take(text_); }

 private:
  const std::string text_;
};

class FullDisk : public testing::Test {
 protected:
  // The confirmations that clients received.
  struct Told {
    std::map<std::string, JobState> jobs;
    std::set<std::string> removed;
    std::optional<StoredUpload> upload;
    std::uint64_t offset = 0;
    std::optional<StoredScan> scan;
  };

  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    folder_ = fs::temp_directory_path() / ("vacuform-full-" + random_hex(8));
    fs::create_directories(folder_);
  }
  void TearDown() override {
    empty_disk();
    say_free(std::nullopt);
    fs::remove_all(folder_);
  }

  static Millis now() { return 1'800'000'000'000; }
  static StoreOptions options() {
    StoreOptions options;
    options.clock = options.elapsed = now;
    options.kept_free = 4 << 20;
    return options;
  }

  // SQLite does not report why it could not create a file.
  static void expect_full(const Error& error) {
    EXPECT_TRUE(error.code == Code::disk_full || error.code == Code::unavailable) << error.text();
  }
  template <class T>
  static bool done(const Result<T>& result) {
    if (!result) expect_full(result.error());
    return result.has_value();
  }

  static Result<Job> create(Store& store, const std::string& scan) {
    NewJob job{.settings = "{}", .kind = JobKind::inspection};
    VACUFORM_TRY(file, store.upload());
    VACUFORM_CHECK(file.write(scan));
    job.add("scan", std::move(file), "stl");
    return store.create(std::move(job));
  }
  static Result<void> put(Store& store, const LeaseKey& key, const std::string& name) {
    VACUFORM_TRY(file, store.upload(Use::artifact));
    VACUFORM_CHECK(file.write("of " + name));
    return store.put_artifact(key, name, std::move(file));
  }
  static Result<std::uint64_t> append(Uploads& uploads, const StoredUpload& upload, std::uint64_t offset,
                                      const std::string& bytes) {
    Text body(bytes);
    http::Request request;
    request.content_length = bytes.size();
    request.body = &body;
    return uploads.append(upload, offset, request, false);
  }

  // Everything that clients and workers do. `crashed` gets a copy of the files before the store is closed.
  Told use(const fs::path& data, const fs::path& crashed) {
    Told told;
    const auto opened = open_store(data, options());
    if (!done(opened)) return told;
    Store& store = **opened;
    const auto uploads = Uploads::open(store, data / "uploads", now);
    const auto first = create(store, "first");
    if (done(first)) told.jobs[first->id] = JobState::queued;
    if (const auto lease = store.lease("worker"); done(lease) && *lease) {
      const LeaseKey key{(*lease)->job.id, (*lease)->token};
      done(store.heartbeat(key, Stage::scan, 0.5));
      bool whole = true;
      for (const char* name : due_artifacts) whole = done(put(store, key, name)) && whole;
      if (whole && done(store.complete(key))) told.jobs[key.job] = JobState::succeeded;
    }
    if (const auto second = create(store, "second"); done(second)) {
      told.jobs[second->id] = JobState::queued;
      if (done(store.cancel(second->id))) told.jobs[second->id] = JobState::cancelled;
      if (told.jobs[second->id] == JobState::cancelled) {
        told.jobs.erase(
            second->id);  // a refused change that is complete on the disk may reappear after a crash
        if (done(store.remove(second->id))) told.removed.insert(second->id);
      }
    }
    if (const auto again = create(store, "first"); done(again)) told.jobs[again->id] = JobState::queued;
    if (done(uploads)) {
      const auto upload = (*uploads)->begin("station", *input_kind("temperature"), "", 8);
      if (done(upload)) {
        told.upload = *upload;
        for (const char* piece : {"half", "full"})
          if (const auto offset = append(**uploads, *upload, told.offset, piece); done(offset))
            told.offset = *offset;
          else
            break;
      }
    }
    if (auto file = store.upload(); done(file) && done(file->write("kept scan")))
      if (auto scan = store.add_scan("station", std::move(*file), "stl"); done(scan)) told.scan = *scan;
    done(store.expire());
    hit_ = empty_disk();
    fs::copy(data, crashed, fs::copy_options::recursive);
    if (!hit_ || mode_ == Full::from_then_on) fill_disk_at(1, mode_);  // closing meets the full disk, too
    return told;
  }

  static void expect_bytes(Store& store, const Blob& blob) {
    const auto file = store.open(blob);
    ASSERT_TRUE(file) << file.error().text();
    EXPECT_EQ((*file)->size().value(), blob.bytes);
  }

  static std::size_t files_in(const fs::path& folder) {
    std::size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      count += entry.is_regular_file() ? 1 : 0;
    return count;
  }

  // With space again: all confirmed changes are there, and everything can be done and deleted.
  static void expect_all(const fs::path& data, const Told& told) {
    auto opened = open_store(data, options());
    ASSERT_TRUE(opened) << opened.error().text();
    Store& store = **opened;
    auto opened_uploads = Uploads::open(store, data / "uploads", now);
    ASSERT_TRUE(opened_uploads);
    Uploads& uploads = **opened_uploads;
    const auto page = store.list(100, "");
    ASSERT_TRUE(page) << page.error().text();
    std::map<std::string, JobState> found;
    for (const Job& job : page->jobs) {
      found[job.id] = job.state;
      expect_bytes(store, job.input("scan")->blob);
      EXPECT_EQ(job.artifacts.size(), job.state == JobState::succeeded ? 3u : 0u);
      for (const auto& artifact : job.artifacts) expect_bytes(store, artifact.blob);
    }
    for (const auto& [id, state] : told.jobs) {
      ASSERT_EQ(found.count(id), 1u);
      EXPECT_TRUE(state == JobState::queued || found[id] == state) << name(found[id]);
    }
    for (const auto& id : told.removed) EXPECT_EQ(found.count(id), 0u);
    if (told.scan) {
      const auto scan = store.find_scan(told.scan->id);
      ASSERT_TRUE(scan);
      expect_bytes(store, scan->blob);
      EXPECT_TRUE(store.remove_scan(scan->id));
    }
    if (told.upload) {
      const auto row = store.find_upload(told.upload->id);
      ASSERT_TRUE(row) << row.error().text();
      const auto offset = uploads.offset(*row);
      ASSERT_TRUE(offset) << offset.error().text();
      EXPECT_GE(*offset, told.offset);
      if (*offset < 8) {
        ASSERT_TRUE(append(uploads, *row, *offset, std::string("halffull").substr(*offset)));
      }
      const auto whole = uploads.whole(*store.find_upload(row->id));
      ASSERT_TRUE(whole) << whole.error().text();
      expect_bytes(store, *whole->blob);
      EXPECT_EQ(whole->blob->sha256, text_hash("halffull"));
      EXPECT_TRUE(uploads.remove(told.upload->id));
    }
    const auto more = create(store, "more");
    ASSERT_TRUE(more) << more.error().text();
    found[more->id] = more->state;
    for (const auto& [id, state] : found) {
      EXPECT_TRUE(ended(state) || store.cancel(id));
      ASSERT_TRUE(store.end_leases_of("worker"));
      EXPECT_TRUE(store.remove(id));
    }
    const ScanPage scans = *store.list_scans(100, "", std::nullopt);
    for (const StoredScan& scan : scans.scans) {
      EXPECT_TRUE(store.remove_scan(scan.id));
    }
    ASSERT_TRUE(store.expire());
    opened_uploads->reset();
    opened->reset();
    auto last = open_store(data, options());
    ASSERT_TRUE(last);
    if (!told.upload) return;
    EXPECT_EQ(files_in(data / "incoming") + files_in(data / "uploads"), 0u);
    // What no client was told about, which is young.
    const auto left = files_in(data / "blobs");
    EXPECT_LE(left, 2u);
    EXPECT_EQ(static_cast<std::int64_t>(left), (*last)->status()->unnamed_files);
  }

  void meets_every_call(Full mode) {
    mode_ = mode;
    int call = 1;
    for (hit_ = true; hit_; ++call) {
      SCOPED_TRACE("full at call " + std::to_string(call));
      const fs::path data = folder_ / "data", crashed = folder_ / "crashed";
      fs::remove_all(data);
      fs::remove_all(crashed);
      fs::create_directories(data);
      fill_disk_at(call, mode);
      const Told told = use(data, crashed);
      if (!fs::exists(crashed)) hit_ = empty_disk();  // the store did not open
      empty_disk();
      if (fs::exists(crashed)) expect_all(crashed, told);
      expect_all(data, told);
      if (HasFatalFailure()) return;
    }
    EXPECT_GT(call, 80);
  }

  fs::path folder_;
  Full mode_ = Full::once;
  bool hit_ = false;
};

TEST_F(FullDisk, AMomentAtAnyCallLosesNothing) { meets_every_call(Full::once); }

TEST_F(FullDisk, LosesNothingAtAnyCall) { meets_every_call(Full::from_then_on); }

TEST_F(FullDisk, ATransactionThatFindsItFullIsTriedAgainWithTheReserve) {
  const auto store = std::move(*open_store(folder_ / "data", options()));
  const std::string id = create(*store, "a scan")->id;
  ASSERT_EQ(fs::file_size(folder_ / "data" / "reserve"), 1u << 20);
  fill_disk_at(1, Full::once);
  EXPECT_EQ(store->cancel(id)->state, JobState::cancelled);
  EXPECT_TRUE(empty_disk());
  EXPECT_EQ(fs::file_size(folder_ / "data" / "reserve"), 0u);
  ASSERT_TRUE(store->expire());
  EXPECT_EQ(fs::file_size(folder_ / "data" / "reserve"), 1u << 20);
}

// 4 MiB are reserved: 3 for submissions, 2 for jobs that start, 1 for their artifacts.
TEST_F(FullDisk, NewFilesLeaveRoomForTheRest) {
  const auto store = std::move(*open_store(folder_ / "data", options()));
  const std::string id = create(*store, "a scan")->id, other = create(*store, "a scan")->id;
  const auto lease = *store->lease("worker");
  const LeaseKey key{lease->job.id, lease->token};
  auto started = store->upload();
  ASSERT_TRUE(started);
  say_free((3 << 20) + 10);
  EXPECT_TRUE(started->write("ten bytes."));
  EXPECT_EQ(started->write("ten bytes and one").error().code, Code::disk_full);
  EXPECT_EQ(store->room_for(11).error().code, Code::disk_full);
  EXPECT_EQ(store->add_upload({"1", "station", "scan", "stl", "key", 11, now(), now() + 1, {}}).error().code,
            Code::disk_full);
  say_free((3 << 20) - 1);
  EXPECT_EQ(create(*store, "another").error().code, Code::disk_full);
  NewJob again{.settings = "{}", .derived_from = id};
  EXPECT_EQ(store->create(std::move(again)).error().code, Code::disk_full);
  const auto second = store->lease("worker");
  ASSERT_TRUE(second && *second);
  ASSERT_TRUE(store->release({(*second)->job.id, (*second)->token}));
  say_free((2 << 20) - 1);
  EXPECT_FALSE(*store->lease("worker"));  // the job waits: its artifacts could not be stored
  EXPECT_TRUE(put(*store, key, "mold.stl"));
  say_free((1 << 20) - 1);
  EXPECT_EQ(put(*store, key, "mold.stl").error().code, Code::disk_full);
  say_free(0);
  EXPECT_TRUE(store->heartbeat(key, Stage::scan, 0.5));
  EXPECT_TRUE(store->cancel(other));
  EXPECT_TRUE(store->remove(other));
  EXPECT_TRUE(store->cancel(key.job));
  EXPECT_TRUE(store->cancelled(key));
  say_free(std::nullopt);
  EXPECT_TRUE(create(*store, "another"));
}

TEST_F(FullDisk, TriesAgainToDeleteAFile) {
  const auto store = std::move(*open_store(folder_ / "data", options()));
  const Job job = *create(*store, "a scan");
  const std::string hash = job.input("scan")->blob.sha256;
  const fs::path file = folder_ / "data" / "blobs" / hash.substr(0, 2) / hash;
  ASSERT_TRUE(store->cancel(job.id));
  fs::remove(file);
  fs::create_directory(file);  // unlink() refuses folders
  ASSERT_TRUE(store->remove(job.id));
  EXPECT_FALSE(fs::exists(file));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "data" / "incoming"), {}), 1);
  const fs::path aside = *fs::directory_iterator(folder_ / "data" / "incoming");
  fs::remove(aside);
  { std::ofstream(aside) << "bytes"; }
  ASSERT_TRUE(store->expire());
  EXPECT_FALSE(fs::exists(aside));
}

}  // namespace
}  // namespace vacuform
