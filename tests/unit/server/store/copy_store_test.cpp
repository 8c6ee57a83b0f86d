// Copies between all places of rows and blobs, with a real PostgreSQL and a real object store.
#include "server/store/sql/copy_store.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "api/base/secrets.hpp"
#include "server/store/postgres/postgres_schema.hpp"
#include "server/store/sql/sql_store.hpp"
#include "server/store/sqlite/sqlite.hpp"
#include "tests/unit/server/store/postgres_server.hpp"
#include "tests/unit/server/store/s3_server.hpp"
#include "tests/unit/server/store/store_fixture.hpp"

namespace vacuform {
namespace {

constexpr double odd_progress = 0.1 + 0.2;  // 0.30000000000000004

class CopyStore : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    folder_ = fs::temp_directory_path() / ("vacuform-copy-" + random_hex(8));
  }
  void TearDown() override { fs::remove_all(folder_); }

  StorePlace in_files(const std::string& name) const {
    StorePlace place{folder_ / name};
    place.options.clock = [this] { return now_; };
    place.options.kept_free = 1 << 20;
    return place;
  }
  StorePlace with_postgres(StorePlace place) const {
    std::string schema = folder_.filename().string() + "_" + place.data.filename().string();
    std::replace(schema.begin(), schema.end(), '-', '_');
    place.options.database = PostgresServer::get().url(schema);
    return place;
  }
  StorePlace with_objects(StorePlace place) const {
    place.options.blobs =
        S3Server::get().url(folder_.filename().string() + "-" + place.data.filename().string());
    place.options.blobs_credentials = S3Server::get().credentials_file();
    return place;
  }

  static std::unique_ptr<SqlStore> open(const StorePlace& place) {
    auto store = open_sql_store(place.data, place.options);
    EXPECT_TRUE(store) << store.error().text();
    return store ? std::move(*store) : nullptr;
  }
  static Upload upload(Store& store, const std::string& bytes) {
    auto upload = store.upload();
    EXPECT_TRUE(upload && upload->write(bytes));
    return std::move(*upload);
  }
  std::string create(Store& store, const std::string& scan) {
    NewJob job{"{\"print\":{\"dpi\":200}}", "key-of-" + scan.substr(0, 30)};
    job.owner = "station-3", job.reference = "CASE 12", job.note = "Größe \"M\"; it's new";
    job.rescan = true;  // every scan is another one
    job.add("scan", upload(store, scan), "stl");
    job.add("pattern", upload(store, "a pattern"), "svg");
    now_ += 1000;
    return store.create(std::move(job)).value().id;
  }
  static LeaseKey lease(Store& store) {
    const auto leased = store.lease("tester");
    return {(*leased)->job.id, (*leased)->token};
  }
  // A job in each state, a large blob, and a row in every other table. Gives the lease of the running job.
  LeaseKey fill(Store& store) {
    create(store, std::string(3'000'000, 'x'));
    const LeaseKey done = lease(store);
    for (const ArtifactKind& kind : artifact_kinds)
      if (due(JobKind::print, kind)) {
        EXPECT_TRUE(store.put_artifact(done, std::string(kind.name), upload(store, std::string(kind.name))));
      }
    EXPECT_TRUE(store.complete(done, 2));
    create(store, "a scan that fails");
    EXPECT_TRUE(store.fail_job(lease(store), {Code::unreadable, "no triangles", "scan.stl", "send another"},
                               Retry::never));
    create(store, "a scan that runs");
    const LeaseKey running = lease(store);
    EXPECT_TRUE(store.log(running, 0, {"read 12 triangles", "formed"}));
    EXPECT_TRUE(store.heartbeat(running, Stage{}, odd_progress));
    create(store, "a scan that waits");
    EXPECT_TRUE(store.cancel(create(store, "a scan that nobody wants"), {}));
    EXPECT_TRUE(
        store.add_token({"0123456789abcdef", "station-3", {Scope::read}, "hash", now_, now_ + 9, {}, "f"}));
    EXPECT_TRUE(store.put_profile({"head", "{}", now_}));
    EXPECT_TRUE(store.set_default_profile("head", true));
    EXPECT_TRUE(store.add_scan("station-3", upload(store, "a kept scan"), "stl"));
    for (const char* id : {"00000000000000000000000000000001", "00000000000000000000000000000002"})
      EXPECT_TRUE(store.add_upload({id, "station-3", "scan", "stl", "key", 8, now_, now_ + 1'000'000, {}}));
    EXPECT_TRUE(store.finish_upload("00000000000000000000000000000001", upload(store, "uploaded")));
    return running;
  }
  LeaseKey fill(const StorePlace& place) {
    const auto store = open(place);
    return fill(*store);
  }

  // All rows that a copy must have, as text.
  std::vector<std::string> rows(const StorePlace& place) const {
    const fs::path file = folder_ / "rows.sqlite";
    fs::remove(file);
    EXPECT_TRUE(open(place)->copy_rows(file, [] { return true; }));
    SqliteDatabase db;
    EXPECT_TRUE(db.open(file.string()));
    std::vector<std::string> found;
    std::vector<std::string> selects;  // outlive the statements
    for (const CopiedTable& table : copied_tables())
      selects.push_back(std::string("SELECT ") + table.columns + " FROM " + table.name + " WHERE " +
                        table.moved + " ORDER BY 1, 2");
    for (std::size_t i = 0; i < selects.size(); ++i) {
      const std::string columns = copied_tables()[i].columns;
      Query query(db, selects[i].c_str());
      while (query.row().value()) {
        std::string line = copied_tables()[i].name;
        for (int column = 0; column <= std::count(columns.begin(), columns.end(), ','); ++column)
          line.append(1, '|').append(query.null(column) ? std::string("NULL") : query.text(column));
        found.push_back(std::move(line));
      }
    }
    return found;
  }

  Result<CopyReport> copy(const StorePlace& from, const StorePlace& to) const {
    return copy_store(
        from, to, [] { return true; }, [](const CopyProgress&) {});
  }
  void expect_nothing_temporary(const StorePlace& place) const {
    EXPECT_TRUE(fs::is_empty(place.data / "incoming"));
    for (const auto& entry : fs::directory_iterator(place.data)) {
      const std::string name = entry.path().filename().string();
      EXPECT_TRUE(name == "blobs" || name == "incoming" || name == "lock" || name == "reserve" ||
                  name == "database-id" || name.starts_with("jobs.sqlite"))
          << name;
    }
  }
  void expect_round_trip(const StorePlace& from, const StorePlace& there, const StorePlace& back) {
    const LeaseKey running = fill(from);
    const auto before = rows(from);
    EXPECT_GT(before.size(), 40u);
    const auto report = copy(from, there);
    ASSERT_TRUE(report) << report.error().text();
    EXPECT_EQ(report->jobs, 5);
    EXPECT_GT(report->blobs, 20);
    EXPECT_GT(report->bytes, 3'000'000u);
    EXPECT_TRUE(report->damaged.empty());
    EXPECT_EQ(rows(there), before);
    expect_nothing_temporary(there);
    expect_works(there, running);

    const auto changed = rows(there);
    const auto returned = copy(there, back);
    ASSERT_TRUE(returned) << returned.error().text();
    EXPECT_EQ(rows(back), changed);
    expect_nothing_temporary(back);
    const auto store = open(back);
    EXPECT_EQ(store->job(running.job)->stage_progress, odd_progress);
  }
  // The copy is a store in use: the lease goes on, bytes are there, jobs go on.
  void expect_works(const StorePlace& place, const LeaseKey& running) {
    const auto store = open(place);
    EXPECT_EQ(store->job(running.job)->stage_progress, odd_progress);
    EXPECT_EQ(store->job(running.job)->state, JobState::running);
    EXPECT_EQ(store->status()->working.size(), 1u);
    EXPECT_TRUE(store->expire().value().empty());
    EXPECT_TRUE(store->log(running, 2, {"drawn"}));
    const JobPage page = store->list(10, "", {}, Detail::full).value();
    for (const Job& job : page.jobs) {
      for (const Input& input : job.inputs) EXPECT_TRUE(store->open(input.blob));
      for (const StoredArtifact& artifact : job.artifacts) EXPECT_TRUE(store->open(artifact.blob));
    }
    bool repeated = false;
    NewJob again{"{\"print\":{\"dpi\":200}}", "key-of-a scan that waits"};
    again.owner = "station-3", again.reference = "CASE 12", again.note = "Größe \"M\"; it's new";
    again.rescan = true;
    again.add("scan", upload(*store, "a scan that waits"), "stl");
    again.add("pattern", upload(*store, "a pattern"), "svg");
    EXPECT_TRUE(store->create(std::move(again), &repeated));
    EXPECT_TRUE(repeated);
    const std::string made = create(*store, "a scan after the copy");
    EXPECT_GT(made, running.job);
    EXPECT_NE(lease(*store).job, running.job);
  }

  fs::path folder_;
  Millis now_ = 1'800'000'000'000;
};

TEST_F(CopyStore, FromSqliteAndFilesToPostgresAndObjectsAndBack) {
  expect_round_trip(in_files("one"), with_objects(with_postgres(in_files("two"))), in_files("three"));
}

TEST_F(CopyStore, FromPostgresAndFilesToSqliteAndObjectsAndBack) {
  expect_round_trip(with_postgres(in_files("one")), with_objects(in_files("two")),
                    with_postgres(in_files("three")));
}

TEST_F(CopyStore, FromObjectsToObjectsOfAnotherBucket) {
  expect_round_trip(with_objects(with_postgres(in_files("one"))),
                    with_objects(with_postgres(in_files("two"))), in_files("three"));
}

TEST_F(CopyStore, RefusesATargetWithRowsATargetInUseAndTheSourceItself) {
  const StorePlace from = in_files("one"), to = with_postgres(in_files("two"));
  EXPECT_EQ(copy(from, to).error().code, Code::not_found);
  fill(from);
  const auto before = rows(from);
  EXPECT_EQ(copy(from, from).error().what, "source and target are the same folder");
  {
    const auto store = open(to);
    EXPECT_EQ(copy(from, to).error().what,
              "the target cannot be opened: another server uses this data folder");
    EXPECT_EQ(copy(from, to).error().fix, "stop it, or give another folder with --to");
    EXPECT_TRUE(store->put_profile({"head", "{}", now_}, {}));
  }
  const auto refused = copy(from, to);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::bad_usage);
  EXPECT_EQ(refused.error().what, "the target is not empty: it has rows in the table profile");
  EXPECT_EQ(open(to)->list_profiles(10, "")->profiles.size(), 1u);
  {
    const auto store = open(from);
    EXPECT_EQ(copy(from, in_files("three")).error().what, "another server uses this data folder");
  }
  EXPECT_EQ(rows(from), before);
}

// Cancelled once at every point where it asks.
TEST_F(CopyStore, ACopyThatWasCancelledAnywhereLeavesAnEmptyTargetAndCanBeRepeated) {
  for (const bool elsewhere : {false, true}) {
    StorePlace from = in_files(elsewhere ? "one" : "other"), to = in_files(elsewhere ? "two" : "target");
    if (elsewhere) to = with_objects(with_postgres(to));
    fill(from);
    const auto before = rows(from);
    int until = 0, cancelled = 0;
    for (bool done = false; !done; until += elsewhere ? 61 : 7) {
      int asked = 0;
      const auto copied = copy_store(
          from, to, [&] { return asked++ < until; }, [](const CopyProgress&) {});
      done = copied.has_value();
      if (done) break;
      ++cancelled;
      ASSERT_EQ(copied.error().code, Code::cancelled) << copied.error().text();
      EXPECT_EQ(copied.error().what, "the copy was cancelled; nothing was changed at the target");
      expect_nothing_temporary(to);
      EXPECT_FALSE(open(to)->table_with_rows().value()) << "after " << until;
    }
    EXPECT_GT(cancelled, 5);
    EXPECT_EQ(rows(to), before);
  }
}

TEST_F(CopyStore, LeavesOutDamagedBlobsAndNamesThem) {
  const StorePlace from = in_files("one"), to = with_objects(in_files("two"));
  fill(from);
  const std::string changed = text_hash(std::string(3'000'000, 'x')), lost = text_hash("a kept scan");
  change_blob_file(from.data, changed, "other bytes");
  fs::remove(from.data / "blobs" / lost.substr(0, 2) / lost);
  auto report = copy(from, to);
  ASSERT_TRUE(report) << report.error().text();
  std::sort(report->damaged.begin(), report->damaged.end());
  std::vector<std::string> expected{changed, lost};
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(report->damaged, expected);
  EXPECT_EQ(rows(to), rows(from));
}

// As if the disk of the target lost bytes between writing and comparing.
TEST_F(CopyStore, ACopyThatDiffersIsAnErrorAndLeavesAnEmptyTarget) {
  const StorePlace from = in_files("one"), to = in_files("two");
  fill(from);
  bool changed = false;
  const auto change_last_blob = [&](const CopyProgress& progress) {
    if (changed || std::string(progress.step) != "compared") return;
    change_blob_file(to.data, *blob_files(to.data).rbegin(), "other bytes");
    changed = true;
  };
  const auto differs = copy_store(
      from, to, [] { return true; }, change_last_blob);
  ASSERT_FALSE(differs);
  EXPECT_EQ(differs.error().code, Code::internal);
  EXPECT_EQ(differs.error().what, "a file differs from that of the source");
  EXPECT_FALSE(open(to)->table_with_rows().value());
  EXPECT_TRUE(copy(from, to));
}

}  // namespace
}  // namespace vacuform
