// The store on PostgreSQL: the promises that every store keeps (store_fixture.hpp), and what is special to a database that
// can be lost, restarted and shared.
#include "server/store/sql/postgres_store.hpp"

#include <gtest/gtest.h>

#include "server/store/postgres/postgres_schema.hpp"
#include "tests/unit/server/store/postgres_server.hpp"
#include "tests/unit/server/store/store_fixture.hpp"

namespace vacuform {
namespace {

using namespace std::chrono_literals;

// One schema for each data folder of a test.
Result<std::unique_ptr<Store>> open_in_postgres(const fs::path& data, StoreOptions options) {
  std::string schema = data.parent_path().filename().string();
  std::replace(schema.begin(), schema.end(), '-', '_');
  options.database = PostgresServer::get().url(schema);
  return open_store(data, std::move(options));
}

INSTANTIATE_TEST_SUITE_P(, StoreTest, testing::Values(Backend{"Postgres", open_in_postgres}),
                         [](const auto& backend) { return backend.param.name; });
INSTANTIATE_TEST_SUITE_P(, StoreInFilesTest, testing::Values(Backend{"Postgres", open_in_postgres}),
                         [](const auto& backend) { return backend.param.name; });

class PostgresStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    folder_ = fs::temp_directory_path() / ("vacuform-postgres-" + random_hex(8));
    url_ = PostgresServer::get().url(schema_);
  }
  void TearDown() override {
    PostgresServer::get().answer("DROP SCHEMA " + schema_ + " CASCADE");
    fs::remove_all(folder_);
  }

  // Each server has its own data folder, and all share the database.
  std::unique_ptr<Store> server(const std::string& name, StoreOptions options = {}) {
    options.database = url_;
    options.backoff = 0;
    auto store = open_store(folder_ / name, std::move(options));
    EXPECT_TRUE(store) << store.error().text();
    return store ? std::move(*store) : nullptr;
  }
  static Result<Job> submit(Store& store, const std::string& key = "", const std::string& owner = "a") {
    NewJob job{"{}", key};
    job.owner = owner;
    return store.create(std::move(job));
  }
  std::string psql(const std::string& sql) const {
    return PostgresServer::get().answer("SET search_path=" + schema_ + "; " + sql);
  }
  static bool hears(Store& store) {
    return eventually([&] { return dynamic_cast<PostgresStore&>(store).hears(); });
  }

  fs::path folder_;
  const std::string schema_ = std::string("test_").append(random_hex(8));
  std::string url_;
};

TEST(PostgresSql, NumbersArgumentsAndDropsWhatIsForSqliteAlone) {
  EXPECT_EQ(postgres_sql("SELECT id FROM job INDEXED BY job_raised WHERE a=? AND b=?"),
            "SELECT id FROM job WHERE a=$1 AND b=$2");
  EXPECT_EQ(postgres_sql("VALUES(?1, ?2, ?1)"), "VALUES($1, $2, $1)");
  EXPECT_EQ(postgres_sql("SELECT 1 FROM job INDEXED BY job_queue"), "SELECT 1 FROM job");
}

TEST(PostgresUrl, IsRefusedWithAPasswordOrWhenItCannotBeRead) {
  EXPECT_TRUE(check_database(""));
  EXPECT_TRUE(check_database("postgresql://vacuform@db.example.org,db2.example.org/vacuform"));
  for (const char* url : {"postgresql://vacuform:open-sesame@db.example.org/vacuform",
                          "postgresql://db.example.org/vacuform?password=open-sesame",
                          "postgresql://vacuform:open-sesame%zz@db/vacuform", "mysql://open-sesame"}) {
    const auto checked = check_database(url);
    ASSERT_FALSE(checked) << url;
    EXPECT_EQ(checked.error().code, Code::bad_usage);
    EXPECT_EQ(checked.error().text().find("open-sesame"), std::string::npos) << checked.error().text();
  }
}

TEST_F(PostgresStoreTest, SaysWhenTheDatabaseCannotBeReached) {
  StoreOptions options;
  options.database = "postgresql://vacuform@/postgres?host=/nowhere";
  const auto store = open_store(folder_ / "one", options);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, Code::unavailable);
  EXPECT_EQ(store.error().what, "the database cannot be reached");
}

// Statements without rows are sent together with the next one that has rows, or with the commit.
TEST_F(PostgresStoreTest, AStatementThatFailsWhileOthersAreSentUndoesTheWholeTransaction) {
  const auto opened = PostgresConnection::open(url_);
  ASSERT_TRUE(opened);
  PostgresConnection& db = **opened;
  ASSERT_TRUE(db.execute("CREATE TABLE number(n integer PRIMARY KEY)"));
  const auto insert = [&](int n) { return Query(db, "INSERT INTO number(n) VALUES(?)", n).run(); };
  const auto count = [&] { return *db.rows_of("SELECT count(*) FROM number")->at(0).at(0); };

  db.begin();
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(insert(i));
  {
    Query query(db, "SELECT count(*) FROM number");
    ASSERT_TRUE(query.row());
    EXPECT_EQ(query.integer(0), 200);
  }
  ASSERT_TRUE(db.commit());
  EXPECT_EQ(count(), "200");

  db.start_over();
  db.begin();
  ASSERT_TRUE(insert(200));
  ASSERT_TRUE(insert(0));  // is there already, which the commit finds out
  ASSERT_TRUE(insert(201));
  EXPECT_FALSE(db.commit());
  EXPECT_TRUE(db.failed() && db.may_try_again() && !db.lost());
  db.roll_back();
  EXPECT_EQ(count(), "200");

  db.start_over();
  db.begin();
  ASSERT_TRUE(insert(0));
  EXPECT_FALSE(Query(db, "SELECT count(*) FROM number").row());  // so does the next statement with rows
  db.roll_back();
  db.begin();
  ASSERT_TRUE(insert(200));
  db.roll_back();  // before anything was answered
  EXPECT_EQ(count(), "200");
}

// Between transactions, statements that travel together share one.
TEST_F(PostgresStoreTest, RowsThatAreWantedTogetherComeInOneTrip) {
  const auto opened = PostgresConnection::open(url_);
  ASSERT_TRUE(opened);
  PostgresConnection& db = **opened;
  const auto transactions = [&](bool together) {
    Query one(db, "SELECT txid_current()"), two(db, "SELECT txid_current() + 0");
    if (together) one.send(), two.send();
    EXPECT_TRUE(*one.row() && *two.row());
    return one.text(0) == two.text(0) ? 1 : 2;
  };
  EXPECT_EQ(transactions(false), 2);  // and prepares the statements, which is a trip for each
  EXPECT_EQ(transactions(true), 1);
}

TEST_F(PostgresStoreTest, RowsThatComeTogetherReachTheirOwnQueries) {
  const auto opened = PostgresConnection::open(url_);
  ASSERT_TRUE(opened);
  PostgresConnection& db = **opened;
  for (const bool in_transaction : {false, true}) {
    if (in_transaction) db.begin();
    {
      Query one(db, "SELECT ?", "one"), none(db, "SELECT 1 WHERE ?='x'", "y"), three(db, "SELECT 3");
      for (Query* query : {&one, &none, &three}) query->send();
      { Query(db, "SELECT 4").send(); }  // nobody reads it
      ASSERT_TRUE(*three.row());
      ASSERT_TRUE(*one.row());
      EXPECT_EQ(three.integer(0), 3);
      EXPECT_EQ(one.text(0), "one");
      EXPECT_FALSE(*one.row());
      EXPECT_FALSE(*none.row());
    }
    if (in_transaction) {
      ASSERT_TRUE(db.commit());
    }
  }
  for (const int divisor : {1, 0}) {
    db.begin();
    Query good(db, "SELECT 5"), perhaps(db, "SELECT 1/CAST(? AS integer)", divisor), later(db, "SELECT 6");
    for (Query* query : {&good, &perhaps, &later}) query->send();
    EXPECT_EQ(later.row().has_value(), divisor != 0);
    EXPECT_EQ(perhaps.row().has_value(), divisor != 0);
    EXPECT_EQ(db.failed(), divisor == 0);
    EXPECT_FALSE(db.lost() || db.may_try_again());
    db.roll_back();
  }
  EXPECT_EQ(db.rows_of("SELECT 7")->at(0).at(0), "7");
}

// The counts of an owner are a row that many transactions change.
TEST_F(PostgresStoreTest, ALeaseDoesNotWaitForAnOwnerWhoseCountsAreBeingChanged) {
  const auto store = server("one");
  for (const char* owner : {"a", "a", "b"}) ASSERT_TRUE(submit(*store, "", owner));
  const auto opened = PostgresConnection::open(url_);
  ASSERT_TRUE(opened);
  PostgresConnection& other = **opened;
  ASSERT_TRUE(other.execute("BEGIN; UPDATE submitter SET served=served WHERE owner='a'"));
  const auto first = store->lease("w");
  ASSERT_TRUE(first && *first);
  EXPECT_EQ((*first)->job.owner, "b");
  std::atomic<bool> leased{false};
  std::thread next([&] {  // only jobs of that owner are left, so it waits
    const auto second = store->lease("w");
    leased = second && *second && (*second)->job.owner == "a";
  });
  std::this_thread::sleep_for(200ms);
  EXPECT_FALSE(leased);
  ASSERT_TRUE(other.execute("COMMIT"));
  next.join();
  EXPECT_TRUE(leased);
}

// PostgreSQL ends the wait for a standby at the time limit of a statement, with a warning and a commit on this machine alone.
TEST_F(PostgresStoreTest, ACommitThatNoStandbyConfirmsIsNotAcknowledged) {
  const auto store = server("one");
  PostgresServer& postgres = PostgresServer::get();
  postgres.answer("ALTER SYSTEM SET synchronous_standby_names='nobody'");
  postgres.answer("SELECT pg_reload_conf()");
  std::atomic<bool> refused = false;
  std::thread limit([&] {
    while (!refused)
      postgres.answer("SELECT pg_cancel_backend(pid) FROM pg_stat_activity WHERE wait_event='SyncRep'");
  });
  int number = 0;
  Result<Job> made = submit(*store, "key-0");
  EXPECT_TRUE(eventually([&] {  // the setting is in force a moment later
    if (made) made = submit(*store, "key-" + std::to_string(++number));
    return !made;
  }));
  refused = true;
  limit.join();
  postgres.answer("ALTER SYSTEM RESET synchronous_standby_names");
  postgres.answer("SELECT pg_reload_conf()");
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, Code::unavailable);
  EXPECT_NE(made.error().text().find("may be made all the same"), std::string::npos) << made.error().text();
  EXPECT_TRUE(submit(*store, "key-" + std::to_string(number)));
  EXPECT_EQ(psql("SELECT count(*) FROM job"), std::to_string(number + 1) + "\n");
}

TEST_F(PostgresStoreTest, TheStatusTellsHowLongATransactionOfAnybodyIsOpen) {
  const auto store = server("one");
  const auto report = PostgresConnection::open(url_);
  ASSERT_TRUE(report);
  ASSERT_TRUE((*report)->execute("BEGIN ISOLATION LEVEL REPEATABLE READ"));
  ASSERT_TRUE((*report)->rows_of("SELECT count(*) FROM job"));
  const auto oldest = [&] { return store->status()->oldest_transaction_seconds.value_or(-1); };
  EXPECT_TRUE(eventually([&] { return oldest() > 0.5; }));
  ASSERT_TRUE((*report)->execute("COMMIT"));
  EXPECT_TRUE(eventually([&] { return oldest() < 0.5; }));
}

TEST_F(PostgresStoreTest, ServersThatStartTogetherMakeTheTablesOnce) {
  std::vector<std::thread> starts;
  for (int i = 0; i < 4; ++i)
    starts.emplace_back([&, i] { EXPECT_TRUE(server("server-" + std::to_string(i))); });
  for (auto& start : starts) start.join();
  EXPECT_EQ(psql("SELECT count(*), max(version) FROM vacuform_tables"),
            std::string("1|").append(std::to_string(newest_postgres_schema)).append("\n"));
}

TEST_F(PostgresStoreTest, RefusesTablesOfANewerVersion) {
  ASSERT_TRUE(server("one"));
  psql("UPDATE vacuform_tables SET version=version+1");
  StoreOptions options;
  options.database = url_;
  const auto store = open_store(folder_ / "one", options);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, Code::corrupt_file);
  EXPECT_NE(store.error().what.find("this server knows"), std::string::npos) << store.error().what;
}

TEST_F(PostgresStoreTest, ASessionOfOneServerIsKnownToAnotherUntilEitherEndsIt) {
  const auto one = server("one"), two = server("two");
  ASSERT_TRUE(one->add_token({"0001", "station-1", {Scope::read}, std::string(64, 'a'), 5, {}, {}}));
  ASSERT_TRUE(one->add_session({"b", "0001", wall_clock() + 60'000}));
  EXPECT_EQ(two->find_session("b")->token.id, "0001");
  ASSERT_TRUE(two->end_session("b"));
  EXPECT_EQ(one->find_session("b").error().code, Code::not_found);
}

TEST_F(PostgresStoreTest, OfManyWhoOpenALinkOneSignsIn) {
  const auto one = server("one"), two = server("two");
  ASSERT_TRUE(one->add_token({"0001", "station-1", {Scope::read}, std::string(64, 'a'), 5, {}, {}}));
  ASSERT_TRUE(one->add_link({"b", "0001", wall_clock() + 60'000}));
  std::atomic<int> got = 0, refused = 0;
  std::vector<std::thread> clients;
  for (int i = 0; i < 16; ++i)
    clients.emplace_back([&, i] {
      const auto token = (i % 2 == 0 ? one : two)->use_link("b");
      if (token)
        ++got;
      else if (token.error().code == Code::not_found)
        ++refused;
    });
  for (auto& client : clients) client.join();
  EXPECT_EQ(got, 1);
  EXPECT_EQ(refused, 15);
}

TEST_F(PostgresStoreTest, TwoServersThatSignInAtOnceKeepTheLimits) {
  const auto one = server("one"), two = server("two");
  // There is room for ten, and no token has more than 45.
  psql("INSERT INTO session SELECT i, 'old-'||(i % 22), 9000000000000+i FROM generate_series(1, 990) i");
  const auto sign_in = [&](int client, const std::string& token, int count) {
    for (int i = 0; i < count; ++i) {
      const auto added =
          (client % 2 == 0 ? one : two)->add_session({random_hex(32), token, 9'100'000'000'000});
      ASSERT_TRUE(added) << added.error().text();
    }
  };
  const auto all_sign_in = [&](const auto& token_of, int count) {
    std::vector<std::thread> clients;
    for (int i = 0; i < 16; ++i) clients.emplace_back([&, i] { sign_in(i, token_of(i), count); });
    for (auto& client : clients) client.join();
  };
  all_sign_in([](int i) { return "new-" + std::to_string(i); }, 2);
  EXPECT_EQ(psql("SELECT count(*), sum((token LIKE 'new-%')::int) FROM session"), "1000|32\n");
  psql("DELETE FROM session");
  all_sign_in([](int) { return std::string("same"); }, 5);
  EXPECT_EQ(psql("SELECT count(*) FROM session"), "50\n");
}

TEST_F(PostgresStoreTest, ThirtyTwoThreadsOfTwoServersLeaseEachJobOnce) {
  const auto one = server("one"), two = server("two");
  constexpr int jobs = 200;
  for (int i = 0; i < jobs; ++i) ASSERT_TRUE(submit(*one, "", "owner-" + std::to_string(i % 5)));
  std::mutex mutex;
  std::multiset<std::string> leased;
  std::vector<std::thread> workers;
  for (int i = 0; i < 32; ++i)
    workers.emplace_back([&, i] {
      Store& store = i % 2 == 0 ? *one : *two;
      for (;;) {
        const auto lease = store.lease("worker");
        ASSERT_TRUE(lease) << lease.error().text();
        if (!*lease) return;  // every queued job is taken, or is being taken
        const auto ended = store.fail_job({(*lease)->job.id, (*lease)->token}, {}, Retry::never);
        ASSERT_TRUE(ended) << ended.error().text();
        const std::lock_guard hold(mutex);
        leased.insert((*lease)->job.id);
      }
    });
  for (auto& worker : workers) worker.join();
  EXPECT_EQ(leased.size(), static_cast<std::size_t>(jobs));
  EXPECT_EQ(std::set<std::string>(leased.begin(), leased.end()).size(), static_cast<std::size_t>(jobs));
  EXPECT_EQ(psql("SELECT sum(queued), sum(running) FROM submitter"), "0|0\n");
  EXPECT_EQ(psql("SELECT count(*) FROM lease"), "0\n");
}

TEST_F(PostgresStoreTest, OneKeySentToTwoServersAtOnceMakesOneJob) {
  const auto one = server("one"), two = server("two");
  std::mutex mutex;
  std::set<std::string> ids;
  std::vector<std::thread> clients;
  for (int i = 0; i < 16; ++i)
    clients.emplace_back([&, i] {
      const auto job = submit(i % 2 == 0 ? *one : *two, "key-0001");
      ASSERT_TRUE(job) << job.error().text();
      const std::lock_guard hold(mutex);
      ids.insert(job->id);
    });
  for (auto& client : clients) client.join();
  EXPECT_EQ(ids.size(), 1u);
}

// Two servers write lines into one job's log; a client that has read up to a number misses none.
TEST_F(PostgresStoreTest, TheLinesOfALogAreNumberedWithoutGaps) {
  const auto one = server("one"), two = server("two");
  const std::string id = submit(*one)->id;
  std::atomic<bool> done{false};
  std::vector<std::int64_t> seen;
  std::thread reader([&] {
    while (!done || seen.size() < 81) {
      const auto lines = two->log_after(id, seen.empty() ? 0 : seen.back(), 100);
      ASSERT_TRUE(lines);
      for (const LogLine& line : *lines) seen.push_back(line.number);
    }
  });
  std::vector<std::thread> writers;
  for (int i = 0; i < 4; ++i)
    writers.emplace_back([&, i] {
      Store& store = i % 2 == 0 ? *one : *two;
      for (int k = 0; k < 10;) {
        const auto lease = store.lease("worker");
        ASSERT_TRUE(lease) << lease.error().text();
        if (!*lease) continue;
        ASSERT_TRUE(store.release({(*lease)->job.id, (*lease)->token}));
        ++k;
      }
    });
  for (auto& writer : writers) writer.join();
  done = true;
  reader.join();
  ASSERT_EQ(seen.size(), 81u);  // queued, and two lines for each of forty leases
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i], static_cast<std::int64_t>(i) + 1);
}

TEST_F(PostgresStoreTest, AWaiterHearsOfAChangeThatAnotherServerMakes) {
  const auto one = server("one"), two = server("two");
  ASSERT_TRUE(hears(*one) && hears(*two));
  for (int i = 0; i < 3; ++i) {
    const Job made = *submit(*one);
    std::thread other([&] {
      std::this_thread::sleep_for(100ms);
      EXPECT_TRUE(two->cancel(made.id));
    });
    const auto started = std::chrono::steady_clock::now();
    EXPECT_EQ(one->wait_for_change(made.id, made.version, 1h)->state, JobState::cancelled);
    EXPECT_LT(std::chrono::steady_clock::now() - started,
              1500ms);  // sooner than it looks without a notification
    other.join();
  }
}

TEST_F(PostgresStoreTest, AWaiterFindsAChangeWithoutANotification) {
  const auto one = server("one");
  const Job made = *submit(*one);
  std::thread other([&] {
    std::this_thread::sleep_for(100ms);
    psql("UPDATE job SET version=version+1");
  });
  EXPECT_GT(one->wait_for_change(made.id, made.version, 1h)->version, made.version);
  other.join();
}

// A machine whose clock is wrong by an hour neither ends leases nor extends them.
TEST_F(PostgresStoreTest, LeasesEndByTheClockOfTheDatabase) {
  for (const Millis wrong : {3'600'000, -3'600'000}) {
    StoreOptions options;
    options.lease = 2500;
    options.clock = [wrong] { return wall_clock() + wrong; };
    const auto good = server("good"), bad = server("bad", options);
    const std::string id = submit(*good)->id;
    const auto lease = *bad->lease("worker");
    ASSERT_TRUE(lease);
    const LeaseKey key{id, lease->token};
    for (int i = 0; i < 4; ++i) {
      std::this_thread::sleep_for(900ms);
      EXPECT_TRUE(bad->heartbeat(key, Stage::scan, 0.1 * i));
      EXPECT_TRUE(bad->expire()->empty());
    }
    EXPECT_TRUE(eventually([&] { return !bad->expire()->empty(); }));
    EXPECT_EQ(bad->heartbeat(key, Stage::scan, 1).error().code, Code::lease_lost);
    ASSERT_TRUE(bad->cancel(id) && bad->remove(id));
  }
}

TEST_F(PostgresStoreTest, AServerWithoutItsDatabaseSaysSoAndRecovers) {
  const auto store = server("one");
  const Job before = *submit(*store, "key-0001");
  const auto lease = *store->lease("worker");
  PostgresServer::get().kill();
  const auto started = std::chrono::steady_clock::now();
  EXPECT_EQ(store->status().error().code, Code::unavailable);
  EXPECT_EQ(submit(*store, "key-0002").error().code, Code::unavailable);
  EXPECT_EQ(store->heartbeat({lease->job.id, lease->token}, Stage::scan, 0).error().code, Code::unavailable);
  EXPECT_LT(std::chrono::steady_clock::now() - started, 20s);
  PostgresServer::get().start();
  EXPECT_EQ(submit(*store, "key-0001")->id, before.id);
  EXPECT_TRUE(submit(*store, "key-0002"));
  EXPECT_TRUE(store->heartbeat({lease->job.id, lease->token}, Stage::scan, 0));
  EXPECT_TRUE(hears(*store));
}

// After an outage longer than a lease, every lease looks as if it had ended.
TEST_F(PostgresStoreTest, NoLeaseEndsRightAfterAnOutage) {
  StoreOptions options;
  options.lease = 3000;
  const auto store = server("one", options);
  ASSERT_TRUE(submit(*store));
  const auto lease = *store->lease("worker");
  PostgresServer::get().kill();
  EXPECT_FALSE(store->status());
  std::this_thread::sleep_for(3500ms);
  PostgresServer::get().start();
  EXPECT_TRUE(store->expire()->empty());
  EXPECT_TRUE(store->heartbeat({lease->job.id, lease->token}, Stage::scan, 0));
}

TEST_F(PostgresStoreTest, KeepsAcknowledgedJobsWhenTheDatabaseIsKilled) {
  StoreOptions options;
  options.most_queued = options.most_queued_by_owner = 1'000'000;  // the clients submit as fast as they can
  const auto store = server("one", options);
  for (int round = 0; round < 3; ++round) {
    const auto owner_of = [round](const std::string& key) {
      return "owner-" + std::to_string(round) + "-" + key.substr(0, key.find('-'));
    };
    std::mutex mutex;
    std::map<std::string, std::string> acknowledged;  // id by key
    std::set<std::string> sent;
    std::atomic<bool> killed{false};
    std::vector<std::thread> clients;
    for (int i = 0; i < 8; ++i)
      clients.emplace_back([&, i] {
        for (int k = 0; !killed; ++k) {
          const std::string key = std::to_string(i) + "-" + std::to_string(k) + "-key";
          {
            const std::lock_guard hold(mutex);
            sent.insert(key);
          }
          const auto job = submit(*store, key, owner_of(key));
          const std::lock_guard hold(mutex);
          if (job) acknowledged[key] = job->id;
        }
      });
    EXPECT_TRUE(eventually([&] {
      const std::lock_guard hold(mutex);
      return acknowledged.size() > 8;
    }));
    std::this_thread::sleep_for(100ms);
    PostgresServer::get().kill();
    killed = true;
    for (auto& client : clients) client.join();
    PostgresServer::get().start();
    for (const std::string& key : sent) {
      const auto again = submit(*store, key, owner_of(key));  // what a client does that got no answer
      ASSERT_TRUE(again) << again.error().text();
      if (acknowledged.count(key) > 0) {
        EXPECT_EQ(again->id, acknowledged[key]);
      }
    }
    EXPECT_EQ(psql("SELECT count(*) FROM job WHERE client_key LIKE 'owner-" + std::to_string(round) + "-%'"),
              std::to_string(sent.size()) + "\n");
  }
}

// The connection is lost in the commit: nobody knows whether the change is made.
TEST_F(PostgresStoreTest, AnUnansweredCommitIsNotRepeatedButTheClientMayRepeatIt) {
  const auto store = server("one");
  psql(
      "CREATE SEQUENCE commits;"
      "CREATE FUNCTION lose() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN"
      " IF nextval('commits')=1 THEN PERFORM pg_terminate_backend(pg_backend_pid()); END IF; RETURN NULL; "
      "END $$;"
      "CREATE CONSTRAINT TRIGGER lose AFTER INSERT ON job DEFERRABLE INITIALLY DEFERRED FOR EACH ROW"
      " EXECUTE FUNCTION lose()");
  const auto unknown = submit(*store, "key-0001");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, Code::unavailable);
  EXPECT_NE(unknown.error().what.find("may be made"), std::string::npos) << unknown.error().what;
  EXPECT_TRUE(submit(*store, "key-0001"));
  EXPECT_EQ(psql("SELECT count(*) FROM job"), "1\n");
}

TEST_F(PostgresStoreTest, AConnectionLostBeforeTheCommitIsReplaced) {
  const auto store = server("one");
  ASSERT_TRUE(submit(*store));
  psql("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name='vacuform-server'");
  EXPECT_TRUE(submit(*store));
  EXPECT_TRUE(hears(*store));
}

// The start deletes files that no job names: it must not see the wrong jobs.
TEST_F(PostgresStoreTest, ADataFolderOpensOnlyWithItsOwnDatabase) {
  const auto refusal = [&](const std::string& folder, const std::string& database) {
    StoreOptions options;
    options.database = database;
    const auto store = open_store(folder_ / folder, options);
    return store ? std::string("none") : store.error().what;
  };
  ASSERT_TRUE(open_store(folder_ / "sqlite"));
  auto in_postgres = server("one");
  NewJob job{"{}"};
  auto upload = *in_postgres->upload();
  ASSERT_TRUE(upload.write("a scan"));
  job.add("scan", std::move(upload), "stl");
  const Blob blob = in_postgres->create(std::move(job))->inputs.at(0).blob;
  in_postgres.reset();
  EXPECT_EQ(refusal("one", ""), "the jobs of this data folder are in PostgreSQL");
  EXPECT_EQ(refusal("sqlite", url_), "the jobs of this data folder are in SQLite");
  EXPECT_EQ(refusal("new", url_), "the files of the jobs in the database are in another data folder");
  const std::string other = PostgresServer::get().url(schema_ + "_other");
  EXPECT_EQ(refusal("other", other), "none");
  EXPECT_EQ(refusal("other", url_), "the data folder belongs to another database");
  PostgresServer::get().answer("DROP SCHEMA " + schema_ + "_other CASCADE");
  EXPECT_TRUE(server("one")->open(blob));
}

TEST_F(PostgresStoreTest, SaysThatACommitIsOnOneMachineAlone) {
  EXPECT_EQ(server("one")->status()->durability, "local");
}

}  // namespace
}  // namespace vacuform
