// What is the store's on SQLite alone: files that are not its own, damage, and the work of long lists.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "api/base/secrets.hpp"
#include "server/store/sql/sqlite_store.hpp"
#include "server/store/sqlite/sqlite_schema.hpp"
#include "tests/unit/server/store/store_fixture.hpp"

namespace vacuform {
namespace {

INSTANTIATE_TEST_SUITE_P(, StoreTest, testing::Values(Backend{"Sqlite", open_store}),
                         [](const auto& backend) { return backend.param.name; });
INSTANTIATE_TEST_SUITE_P(, StoreInFilesTest, testing::Values(Backend{"Sqlite", open_store}),
                         [](const auto& backend) { return backend.param.name; });

class SqliteStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    data_ = fs::temp_directory_path() / ("vacuform-sqlite-" + random_hex(8));
    fs::create_directories(data_);
  }
  void TearDown() override { fs::remove_all(data_); }

  // A blob as the store leaves it; gives its hash.
  std::string blob(const std::string& bytes) const {
    const std::string hash = text_hash(bytes);
    fs::create_directories(data_ / "blobs" / hash.substr(0, 2));
    std::ofstream(data_ / "blobs" / hash.substr(0, 2) / hash) << bytes;
    return hash;
  }
  // A store with rows that were not made by requests.
  void store_with(const std::string& rows) const {
    SqliteDatabase database;
    ASSERT_TRUE(database.open((data_ / "jobs.sqlite").string()));
    ASSERT_TRUE(bring_up_to_date(database));
    const auto added = database.execute(rows);
    ASSERT_TRUE(added) << added.error().text();
  }
  std::string bytes_of(Store& store, const Input& input) const {
    const auto file = store.open(input.blob);
    std::string text(input.blob.bytes, '\0');
    return file && (*file)->read_at(0, text).value_or(0) == text.size() ? text : "no file";
  }

  fs::path data_;
};

TEST_F(SqliteStoreTest, RefusesAStoreThatIsNotItsOwn) {
  std::ofstream(data_ / "jobs.sqlite") << std::string(8192, 'x');
  const auto store = open_store(data_);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, Code::corrupt_file);
}

// Jobs that ended every twenty seconds; two owners wait.
TEST_F(SqliteStoreTest, TellsWhenThereWillBeRoom) {
  Millis now = 1'000'000'000;
  StoreOptions options;
  options.clock = [&now] { return now; };
  options.most_queued_by_owner = 2;
  const auto store = std::move(*open_store(data_, options));
  const auto submit = [&](const std::string& owner) {
    NewJob job;
    job.settings = "{}";
    job.owner = owner;
    return store->create(std::move(job));
  };
  EXPECT_EQ(*store->seconds_until_room("a"), 60);  // nothing has ended yet
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(submit("a"));
    const auto lease = *store->lease("worker");
    now += 20'000;
    ASSERT_TRUE(store->fail_job({lease->job.id, lease->token}, {}, Retry::never));
  }
  EXPECT_EQ(*store->seconds_until_room("a"), 20);
  for (const char* owner : {"a", "a", "b"}) ASSERT_TRUE(submit(owner));
  EXPECT_EQ(submit("a").error().code, Code::busy);
  EXPECT_EQ(*store->seconds_until_room("a"), 40);  // the owners take turns
  EXPECT_EQ(*store->seconds_until_room("b"), 20);
  now += 16 * 60'000;  // nobody works any more
  EXPECT_EQ(*store->seconds_until_room("a"), 60);
}

TEST_F(SqliteStoreTest, RefusesAStoreOfANewerVersion) {
  store_with("PRAGMA user_version=" + std::to_string(newest_schema + 1));
  const auto store = open_store(data_);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, Code::corrupt_file);
  EXPECT_NE(store.error().what.find("version " + std::to_string(newest_schema + 1)), std::string::npos);
}

// A search looks at a part of the jobs for each page, and goes on with the next.
TEST_F(SqliteStoreTest, ASearchThroughManyJobsIsDoneInPages) {
  store_with(
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<5000)"
      " INSERT INTO job(id, kind, state, created, settings, owner, reference)"
      " SELECT printf('%026d', i), 'print', iif(i % 2, 'failed', 'succeeded'), i, '{}', 'a', iif(i=10, "
      "'needle', 'hay')"
      " FROM n");
  StoreOptions own;
  own.adopt = true;
  const auto opened = open_store(data_, own);
  auto& store = dynamic_cast<SqliteStore&>(**opened);
  const std::int64_t before = store.steps();
  JobPage page = store.list(20, "", {.text = "Needle"}, Detail::brief).value();
  EXPECT_TRUE(page.jobs.empty());
  const std::int64_t steps = store.steps() - before;
  EXPECT_LT(steps, 40 * most_searched);
  int pages = 1;
  for (; page.jobs.empty() && page.next; ++pages)
    page = store.list(20, *page.next, {.text = "Needle"}, Detail::brief).value();
  ASSERT_EQ(page.jobs.size(), 1u);
  EXPECT_EQ(page.jobs[0].reference, "needle");
  EXPECT_EQ(pages, 3);
  EXPECT_FALSE(page.next);
  const JobPage full = store.list(100, "", {.text = "HAY"}, Detail::brief).value();
  EXPECT_EQ(full.jobs.size(), 100u);
  EXPECT_EQ(full.next, full.jobs.back().id);
}

// The work of a request does not grow with the queue: counted in steps of SQLite, since seconds differ from run to run.
TEST_F(SqliteStoreTest, ALongQueueSlowsNothingDown) {
  const std::string hash = blob("a scan");
  const auto steps_with = [&](int first, int last) {
    const std::string jobs =
        std::string("BEGIN; WITH RECURSIVE n(i) AS (SELECT ") + std::to_string(first) +
        " UNION ALL SELECT i+1 FROM n WHERE i<" + std::to_string(last) +
        ") INSERT INTO job(id, kind, state, created, settings, owner, priority)"
        " SELECT printf('%026d', i), 'print', 'queued', i, '{}', 'station-' || (i % 7), -(i % 3) FROM n;"
        "INSERT OR IGNORE INTO input SELECT id, 'scan', '" +
        hash + "', 6, 'stl' FROM job; COMMIT";
    store_with(jobs);
    StoreOptions roomy;
    roomy.adopt = true;
    roomy.most_queued = roomy.most_queued_by_owner = 100'000;
    auto opened = open_store(data_, roomy);
    EXPECT_TRUE(opened) << opened.error().text();
    auto& store = dynamic_cast<SqliteStore&>(**opened);
    const std::int64_t before = store.steps();
    for (int i = 0; i < 20; ++i) {
      NewJob job{"{}"};
      job.owner = "station-3";
      EXPECT_TRUE(store.create(std::move(job)));
      const auto leased = store.lease("worker").value();
      EXPECT_TRUE(store.fail_job({leased->job.id, leased->token}, {}, Retry::never));
      const JobPage page = store.list(5, "", {.owner = "station-1"}, Detail::full).value();
      EXPECT_EQ(page.jobs.size(), 5u);
      EXPECT_TRUE(store.list(5, *page.next, {}, Detail::full));
    }
    return store.steps() - before;
  };
  const std::int64_t few = steps_with(1, 100), many = steps_with(101, 10'000);
  EXPECT_LT(many, few + few / 4);
}

}  // namespace
}  // namespace vacuform
