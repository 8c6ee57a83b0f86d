// The promises of server/store/store.hpp, held against the interface alone: every store
// must pass all of it, here and in store_*_test.cpp; sqlite_store_test.cpp and postgres_store_test.cpp name the stores. A crash is played by copying the files under a running store and opening
// the copy.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "api/base/secrets.hpp"
#include "server/store/store.hpp"
#include "tests/unit/server/eventually.hpp"

namespace vacuform {

namespace fs = std::filesystem;

// The hashes of the blobs that lie in a data folder.
inline std::set<std::string> blob_files(const fs::path& data) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(data / "blobs"))
    if (entry.is_regular_file()) names.insert(entry.path().filename().string());
  return names;
}

inline void change_blob_file(const fs::path& data, const std::string& sha256, const std::string& bytes) {
  std::ofstream(data / "blobs" / sha256.substr(0, 2) / sha256) << bytes;
}

// A store by its name and the way to open it; and what others see of its blobs, and do to them.
struct Backend {
  const char* name;
  Result<std::unique_ptr<Store>> (*open)(const std::filesystem::path& data, StoreOptions options);
  std::set<std::string> (*blobs)(const fs::path& data) = blob_files;
  void (*change_blob)(const fs::path& data, const std::string& sha256,
                      const std::string& bytes) = change_blob_file;
  Millis grace = 0;  // after which unwanted blobs are deleted
};

inline void PrintTo(const Backend& backend, std::ostream* out) { *out << backend.name; }

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
  // A backup is a store in SQLite and files, whatever keeps the rows of the store that made it.
  void open_backup(const fs::path& backup) {
    store_.reset();
    auto store = open_store(backup, options());
    ASSERT_TRUE(store) << store.error().text();
    store_ = std::move(*store);
  }
  void reopen() {
    store_.reset();
    auto store = GetParam().open(data(), options());
    ASSERT_TRUE(store) << store.error().text();
    store_ = std::move(*store);
  }
  StoreOptions options() {
    StoreOptions options;
    options.clock = [this] { return now_ + clock_set_; };
    options.elapsed = [this] { return now_; };
    options.kept_free = 1 << 20;
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
  // Completes a job with all the artifacts that it must have; those that it has already stay.
  Result<Job> complete(const LeaseKey& key, std::set<std::string> there = {}) {
    const auto leased = store_->leased(key);
    if (leased)
      for (const ArtifactKind& kind : artifact_kinds)
        if (due(leased->kind, kind) && there.count(std::string(kind.name)) == 0) {
          EXPECT_TRUE(store_->put_artifact(key, std::string(kind.name), upload("an artifact")));
        }
    return store_->complete(key);
  }
  Job job(const std::string& id) { return store_->job(id).value(); }
  // The hashes of the blobs that are stored, once what is unwanted had its time to go.
  std::set<std::string> blobs() {
    auto found = GetParam().blobs(data());
    if (GetParam().grace == 0) return found;
    for (int i = 0; i < 2; ++i) {  // a crashed server's are found unwanted first
      clock_set_ += GetParam().grace;
      for (std::size_t before = found.size() + 1; found.size() < before; found = GetParam().blobs(data())) {
        before = found.size();
        EXPECT_TRUE(store_->expire());
      }
    }
    clock_set_ -= 2 * GetParam().grace;
    return found;
  }
  void change_blob(const std::string& sha256, const std::string& bytes) const {
    GetParam().change_blob(data(), sha256, bytes);
  }
  std::string bytes_of(const Blob& blob) {
    auto file = store_->open(blob);
    if (!file) return "no file";
    std::string text(blob.bytes, '\0');
    EXPECT_EQ((*file)->read_at(0, text).value(), blob.bytes);
    return text;
  }

  fs::path folder_;
  Millis now_ = 1'800'000'000'000;
  Millis clock_set_ = 0;  // by how much the wall clock was set forward
  std::unique_ptr<Store> store_;
};

// What holds for blobs in files alone.
using StoreInFilesTest = StoreTest;

}  // namespace vacuform
