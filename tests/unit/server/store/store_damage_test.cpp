// Lost, foreign and damaged databases, and files without a job: nothing that a person stored is deleted, and nothing that is
// wrong stays unseen.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "server/store/blobs/files/file_blobs.hpp"
#include "server/store/sql/repair.hpp"
#include "server/store/sqlite/sqlite.hpp"
#include "server/store/store_watch.hpp"
#include "tests/unit/server/store/store_fixture.hpp"

namespace vacuform {
namespace {

using namespace std::chrono_literals;

class StoreDamage : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    folder_ = fs::temp_directory_path() / ("vacuform-damage-" + random_hex(8));
    fs::create_directories(data());
  }
  void TearDown() override {
    store_.reset();
    fs::remove_all(folder_);
  }
  fs::path data() const { return folder_ / "data"; }

  Result<std::unique_ptr<Store>> try_open(const fs::path& data, bool adopt = false) {
    StoreOptions options;
    options.kept_free = 0;
    options.adopt = adopt;
    options.quarantine_days = 5;
    return open_store(data, options);
  }
  void open(bool adopt = false) {
    auto store = try_open(data(), adopt);
    ASSERT_TRUE(store) << store.error().text();
    store_ = std::move(*store);
  }
  // Jobs with a scan and a pattern each, all different.
  void create(int from, int to) {
    for (int i = from; i < to; ++i) {
      NewJob job{R"({"a": 1})", ""};
      for (const char* name : {"scan", "pattern"}) {
        auto upload = store_->upload();
        ASSERT_TRUE(upload && upload->write(std::string(name) + std::to_string(i) + std::string(5000, 'x')));
        job.add(name, std::move(*upload), name == std::string("scan") ? "stl" : "svg");
      }
      job.note = "note " + std::to_string(i);
      const auto made = store_->create(std::move(job));
      ASSERT_TRUE(made) << made.error().text();
      ids_.push_back(made->id);
    }
  }
  void write_blob(const std::string& bytes, std::chrono::hours age) const {
    const std::string hash = text_hash(bytes);
    const fs::path file = data() / "blobs" / hash.substr(0, 2) / hash;
    fs::create_directories(file.parent_path());
    std::ofstream(file) << bytes;
    fs::last_write_time(file, fs::file_time_type::clock::now() - age);
  }
  void make_old(std::chrono::hours age) const {
    for (const auto& entry : fs::recursive_directory_iterator(data() / "blobs"))
      if (entry.is_regular_file()) fs::last_write_time(entry.path(), fs::file_time_type::clock::now() - age);
  }
  std::size_t in_quarantine() const {
    std::size_t files = 0;
    if (fs::exists(data() / "quarantine"))
      for (const auto& entry : fs::recursive_directory_iterator(data() / "quarantine"))
        files += entry.is_regular_file() ? 1 : 0;
    return files;
  }
  // A change of the database that no server makes.
  void run_sql(const std::string& sql) const {
    SqliteDatabase db;
    ASSERT_TRUE(db.open((data() / "jobs.sqlite").string()));
    const auto changed = db.execute(sql);
    ASSERT_TRUE(changed) << changed.error().text();
  }
  std::size_t listed() { return store_->list(100, "", {}, Detail::full).value().jobs.size(); }

  fs::path folder_;
  std::unique_ptr<Store> store_;
  std::vector<std::string> ids_;
};

TEST_F(StoreDamage, ALostDatabaseDeletesNothing) {
  open();
  create(0, 15);
  store_.reset();
  make_old(48h);
  const auto files = blob_files(data());
  ASSERT_EQ(files.size(), 30u);
  for (const char* end : {"", "-wal", "-shm"}) fs::remove(data() / (std::string("jobs.sqlite") + end));
  for (int i = 0; i < 2; ++i) {
    const auto store = try_open(data());
    ASSERT_FALSE(store);
    EXPECT_EQ(store.error().code, Code::corrupt_file);
    for (const char* way : {"restore", "adopt"})
      EXPECT_NE(store.error().fix.find(std::string("vacuform-server ") + way), std::string::npos);
    EXPECT_FALSE(fs::exists(data() / "jobs.sqlite"));
  }
  fs::remove(data() / "database-id");  // the files alone are enough
  EXPECT_EQ(try_open(data()).error().code, Code::corrupt_file);
  EXPECT_EQ(blob_files(data()), files);
  open(true);
  EXPECT_EQ(listed(), 0u);
  EXPECT_EQ(blob_files(data()), files);
  EXPECT_EQ(store_->status()->unnamed_files, 30);
  store_.reset();
  open();  // they belong together from now on
  EXPECT_EQ(blob_files(data()), files);
}

TEST_F(StoreDamage, AnOlderDatabaseDeletesNothing) {
  open();
  create(0, 12);
  store_.reset();
  fs::copy(data() / "jobs.sqlite", folder_ / "older.sqlite");
  open();
  create(12, 25);
  store_.reset();
  make_old(48h);
  const auto files = blob_files(data());
  fs::copy(folder_ / "older.sqlite", data() / "jobs.sqlite", fs::copy_options::overwrite_existing);
  open();
  EXPECT_EQ(listed(), 12u);
  EXPECT_EQ(blob_files(data()), files);
  EXPECT_EQ(store_->status()->unnamed_files, 26);
  EXPECT_EQ(in_quarantine(), 0u);
}

TEST_F(StoreDamage, ADatabaseIsOfOneFolder) {
  open();
  create(0, 2);
  store_.reset();
  auto other = try_open(folder_ / "other");
  ASSERT_TRUE(other);
  other->reset();
  const auto files = blob_files(data());
  fs::copy(folder_ / "other" / "jobs.sqlite", data() / "jobs.sqlite", fs::copy_options::overwrite_existing);
  EXPECT_EQ(try_open(data()).error().what, "the data folder belongs to another database");
  EXPECT_EQ(blob_files(data()), files);
  std::ofstream(data() / "database-id") << "sqlite x";
  EXPECT_EQ(try_open(data()).error().code, Code::corrupt_file);
}

TEST_F(StoreDamage, FewOldFilesWithoutAJobGoToQuarantineForDays) {
  open();
  create(0, 3);
  store_.reset();
  write_blob("old", 48h);
  write_blob("young", 1h);
  open();
  EXPECT_EQ(blob_files(data()).count(text_hash("old")), 0u);
  EXPECT_EQ(blob_files(data()).count(text_hash("young")), 1u);
  EXPECT_EQ(store_->status()->unnamed_files, 1);
  const fs::path file = data() / "quarantine" / text_hash("old");
  ASSERT_TRUE(fs::exists(file));
  for (const auto& [age, stays] : {std::pair(4 * 24h, true), {6 * 24h, false}}) {
    store_.reset();
    fs::last_write_time(file, fs::file_time_type::clock::now() - age);
    open();
    EXPECT_EQ(fs::exists(file), stays) << age.count();
  }
}

// A crash between the commit of a deletion and that of its files.
TEST_F(StoreDamage, ADeletionThatBrokeOffIsEnded) {
  open();
  create(0, 30);
  store_.reset();
  std::string scans = "INSERT INTO pending_deletion SELECT blob FROM input WHERE job<>'" + ids_[0] + "'";
  run_sql("PRAGMA foreign_keys=ON; " + scans + "; DELETE FROM job WHERE id<>'" + ids_[0] + "'");
  open();
  EXPECT_EQ(blob_files(data()).size(), 2u);
  EXPECT_EQ(in_quarantine(), 0u);
  EXPECT_EQ(store_->status()->unnamed_files, 0);
  store_.reset();
  SqliteDatabase db;
  ASSERT_TRUE(db.open((data() / "jobs.sqlite").string()));
  Query left(db, "SELECT count(*) FROM pending_deletion");
  ASSERT_TRUE(left.row());
  EXPECT_EQ(left.integer(0), 0);
}

// A backup keeps the files of a job that is deleted meanwhile; a crash at that moment does not keep them for ever.
TEST_F(StoreDamage, ADeletionDuringABackupIsEndedAfterACrash) {
  open();
  create(0, 4);
  ASSERT_TRUE(store_->cancel(ids_[1], {}));
  const fs::path backup = folder_ / "backup", crashed = folder_ / "crashed";
  fs::create_directory(backup);
  fs::permissions(backup, fs::perms::owner_all);
  int asked = 0;
  ASSERT_TRUE(store_->backup(backup, [&] {
    if (++asked == 2) {  // the rows are copied, the files not yet
      EXPECT_TRUE(store_->remove(ids_[1], {}));
      fs::copy(data(), crashed, fs::copy_options::recursive);
    }
    return true;
  }));
  EXPECT_EQ(blob_files(data()).size(), 6u);
  EXPECT_EQ(blob_files(crashed).size(), 8u);
  store_.reset();
  const auto again = try_open(crashed);
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(blob_files(crashed).size(), 6u);
  EXPECT_EQ((*again)->status()->unnamed_files, 0);
}

// Every page of the database, in two ways.
TEST_F(StoreDamage, EveryDamagedPageIsNoticedOrHarmless) {
  open();
  create(0, 40);
  ASSERT_TRUE(store_->cancel(ids_[7], {}));
  ASSERT_TRUE(store_->remove(ids_[7], {}));
  store_.reset();
  std::stringstream all;
  all << std::ifstream(data() / "jobs.sqlite").rdbuf();
  const std::string good = all.str();
  constexpr std::size_t page = 4096;
  int refused = 0, served = 0;
  for (const bool whole : {true, false})
    for (std::size_t at = 0; at + page <= good.size(); at += page) {
      SCOPED_TRACE("page " + std::to_string(at / page) + (whole ? ", whole" : ", 64 bytes"));
      std::string bad = good;
      const std::size_t from = at + (whole ? 0 : 100 + 37 * (at / page) % 3800);
      for (std::size_t i = from; i < from + (whole ? page : 64); ++i)
        bad[i] = static_cast<char>(bad[i] ^ (0x5a + i % 7));
      const fs::path copy = folder_ / "copy";
      fs::remove_all(copy);
      fs::create_directories(copy);
      fs::create_directory_symlink(data() / "blobs", copy / "blobs");
      fs::copy(data() / "database-id", copy / "database-id");
      std::ofstream(copy / "jobs.sqlite") << bad;
      const auto opened = try_open(copy);
      if (!opened) {
        ++refused;
        EXPECT_EQ(opened.error().code, Code::corrupt_file) << opened.error().text();
        continue;
      }
      ++served;
      const auto list = (*opened)->list(100, "", {}, Detail::full);
      ASSERT_TRUE(list) << list.error().text();
      std::size_t right = 0;
      for (const Job& job : list->jobs)
        right += job.settings == R"({"a": 1})" && job.note.starts_with("note ") && job.inputs.size() == 2;
      const auto found = (*opened)->check(false, [](std::uint64_t) { return true; });
      ASSERT_TRUE(found) << found.error().text();
      const bool texts_alone =
          found->good() && list->jobs.size() == 39;  // a note or a setting reads another way
      EXPECT_TRUE(right == 39 || !found->good() || texts_alone);
      (void)(*opened)->job(ids_[0]);
      (void)(*opened)->tokens();
      (void)(*opened)->status();
    }
  EXPECT_GT(refused, 40);
  EXPECT_GT(served, 5);  // free pages and bytes within a text
  EXPECT_EQ(blob_files(data()).size(), 78u);
}

TEST_F(StoreDamage, EveryDamagedFileOfTheFolderIsNoticedOrHarmless) {
  open();
  create(0, 3);
  store_.reset();
  std::vector<fs::path> names;
  for (const auto& entry : fs::recursive_directory_iterator(data()))
    if (entry.is_regular_file()) names.push_back(fs::relative(entry.path(), data()));
  ASSERT_GT(names.size(), 8u);
  for (const auto& name : names)
    for (const bool emptied : {false, true}) {
      SCOPED_TRACE(name.string());
      const fs::path copy = folder_ / "copy";
      fs::remove_all(copy);
      fs::copy(data(), copy, fs::copy_options::recursive);
      if (emptied)
        fs::resize_file(copy / name, 0);
      else
        std::fstream(copy / name, std::ios::in | std::ios::out) << "damaged";
      const auto opened = try_open(copy);
      const bool is_blob = name.begin()->string() == "blobs";
      const bool is_the_database = name == "jobs.sqlite" || name == "database-id";
      EXPECT_EQ(opened.has_value(), !is_the_database);
      if (!opened) continue;
      const auto found = (*opened)->check(true, [](std::uint64_t) { return true; });
      ASSERT_TRUE(found);
      EXPECT_EQ(found->damaged_files.size(), is_blob ? 1u : 0u);
      EXPECT_EQ((*opened)->list(100, "", {}, Detail::full)->jobs.size(), 3u);
    }
}

TEST_F(StoreDamage, ABadRowIsLeftOutOfListsAndMovedByARepair) {
  open();
  create(0, 5);
  store_.reset();
  run_sql("UPDATE job SET state='shattered' WHERE id='" + ids_[1] +
          "';"
          "UPDATE job SET note=CAST(X'6e6f7465ff' AS TEXT) WHERE id='" +
          ids_[2] +
          "';"
          "UPDATE job SET settings='{' WHERE id='" +
          ids_[3] + "'");
  open();
  EXPECT_EQ(listed(), 2u);
  EXPECT_EQ(store_->list(100, "", {}, Detail::brief)->jobs.size(), 3u);  // no list shows settings
  for (int i : {1, 2, 3})
    EXPECT_EQ(store_->job(ids_[static_cast<std::size_t>(i)]).error().code, Code::internal);
  EXPECT_EQ(store_->status()->damaged_jobs, 3);
  const auto found = store_->check(false, [](std::uint64_t) { return true; });
  ASSERT_TRUE(found);
  EXPECT_EQ(found->damaged_jobs.size(), 3u);
  EXPECT_FALSE(found->good());
  const auto moved = set_damage_in_quarantine(data(), *store_, *found);
  ASSERT_TRUE(moved) << moved.error().text();
  EXPECT_EQ(in_quarantine(), 3u);
  EXPECT_EQ(listed(), 2u);
  EXPECT_EQ(blob_files(data()).size(), 10u);  // their files stay
  std::string texts;
  for (const auto& entry : fs::directory_iterator(data() / "quarantine")) {
    std::stringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    texts += text.str();
  }
  EXPECT_NE(texts.find("shattered"), std::string::npos);
  EXPECT_NE(texts.find("note 1"), std::string::npos);
}

TEST_F(StoreDamage, ADamagedIndexIsWrittenAnew) {
  open();
  create(0, 10);
  store_.reset();
  std::int64_t page = 0;
  {
    SqliteDatabase db;
    ASSERT_TRUE(db.open((data() / "jobs.sqlite").string()));
    Query root(db, "SELECT rootpage FROM sqlite_schema WHERE name='input_by_blob'");
    ASSERT_TRUE(root.row());
    page = root.integer(0);
  }
  std::fstream(data() / "jobs.sqlite", std::ios::in | std::ios::out).seekp(4096 * page - 40).put('!');
  const auto repaired = repair_pages(data());
  ASSERT_TRUE(repaired) << repaired.error().text();
  EXPECT_TRUE(*repaired);
  EXPECT_GE(in_quarantine(), 1u);
  open();
  EXPECT_EQ(listed(), 10u);
  store_.reset();
  EXPECT_FALSE(*repair_pages(data()));
}

TEST_F(StoreDamage, ABackupIsRestoredOverALostDatabase) {
  open();
  create(0, 10);
  fs::create_directory(folder_ / "backup");
  fs::permissions(folder_ / "backup", fs::perms::owner_all);
  ASSERT_TRUE(store_->backup(folder_ / "backup", [] { return true; }));
  create(10, 12);
  store_.reset();
  fs::resize_file(data() / "jobs.sqlite", 5000);
  const std::string lost = *blob_files(data()).begin();
  fs::remove(data() / "blobs" / lost.substr(0, 2) / lost);
  EXPECT_FALSE(try_open(data()));
  const auto restored = restore_backup(folder_ / "backup", data());
  ASSERT_TRUE(restored) << restored.error().text();
  EXPECT_EQ(restored->jobs, 10);
  EXPECT_EQ(restored->files, 20);
  EXPECT_TRUE(restored->damaged.empty());
  EXPECT_GE(in_quarantine(), 1u);  // the damaged database
  open();
  EXPECT_EQ(listed(), 10u);
  const auto found = store_->check(true, [](std::uint64_t) { return true; });
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->good());
  EXPECT_EQ(found->files, 20);
  store_.reset();
  EXPECT_TRUE(try_open(folder_ / "backup"));  // itself a data folder, still
  EXPECT_EQ(restore_backup(folder_, data()).error().code, Code::bad_usage);
}

TEST_F(StoreDamage, TheWatchFindsAFlippedBitAndReadsSlowly) {
  open();
  create(0, 4);
  const auto files = blob_files(data());
  for (const char* what : {"flipped", "lost"}) {
    const std::string hash = what == std::string("lost") ? *files.rbegin() : *files.begin();
    const fs::path file = data() / "blobs" / hash.substr(0, 2) / hash;
    if (what == std::string("lost"))
      fs::remove(file);
    else
      std::fstream(file, std::ios::in | std::ios::out).seekp(100).put('!');
  }
  const auto began = std::chrono::steady_clock::now();
  {
    const StoreWatch watch(*store_, 100ms, 80'000);  // 8 files of 5 kB
    ASSERT_TRUE(eventually([&] { return store_->status()->damaged_files == 2; }));
  }
  EXPECT_GE(std::chrono::steady_clock::now() - began, 300ms);
  EXPECT_TRUE(store_->status()->last_check);
}

TEST_F(StoreDamage, APipeInPlaceOfAFileDoesNotStopReaders) {
  open();
  create(0, 1);
  const Job job = store_->job(ids_[0]).value();
  const std::string hash = job.inputs[0].blob.sha256;
  const fs::path file = data() / "blobs" / hash.substr(0, 2) / hash;
  fs::remove(file);
  ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
  EXPECT_EQ(store_->open(job.inputs[0].blob).error().code, Code::unreadable);
}

// What was deleted is in no file of the database any more.
TEST_F(StoreDamage, DeletedRowsAreOverwritten) {
  open();
  NewJob job{"{}", ""};
  job.note = "MARKER-OF-A-PATIENT";
  const auto made = store_->create(std::move(job));
  ASSERT_TRUE(made);
  create(0, 3);
  std::string where;
  const auto hits = [&] {
    std::size_t found = 0;
    for (const auto& entry : fs::directory_iterator(data())) {
      if (!entry.is_regular_file()) continue;
      std::stringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      const bool here = text.str().find("MARKER-OF-A-PATIENT") != std::string::npos;
      if (here) where = entry.path().filename().string();
      found += here;
    }
    return found;
  };
  ASSERT_GE(hits(), 1u);
  ASSERT_TRUE(store_->cancel(made->id, {}));
  ASSERT_TRUE(store_->remove(made->id, {}));
  EXPECT_EQ(hits(), 0u) << where;
}

}  // namespace
}  // namespace vacuform
