// What a store keeps: jobs, files, tokens, keys; copies of it.
#include "tests/unit/server/store/store_fixture.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <future>
#include <nlohmann/json.hpp>

namespace {
// Called before this program deletes a file, by the thread that does; null: nothing is.
std::atomic<const std::function<void()>*> before_unlink{nullptr};
}  // namespace

extern "C" int unlink(const char* path) noexcept {
  if (const auto* hook = before_unlink.load()) (*hook)();
  return static_cast<int>(::syscall(SYS_unlink, path));
}

namespace vacuform {
namespace {

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
      const JobPage page = store_->list(2, cursor, {.owner = owner}).value();
      for (const Job& job : page.jobs) found.push_back(job.id);
      if (!page.next) return found;
      cursor = *page.next;
    }
  };
  EXPECT_EQ(ids("first"), first);
  EXPECT_EQ(ids(std::nullopt), all);
  EXPECT_TRUE(ids("third").empty());
}

TEST_P(StoreTest, ListsByStateKindAndTime) {
  struct Made {
    std::string id, owner;
    JobKind kind;
    Millis created;
  };
  std::vector<Made> made;
  for (int i = 0; i < 24; ++i) {
    NewJob wanted = submission("a", "b");
    wanted.owner = i % 3 == 0 ? "first" : "second";
    wanted.kind = i % 4 == 0 ? JobKind::inspection : JobKind::print;
    const Job job = *store_->create(std::move(wanted));
    made.insert(made.begin(), {job.id, job.owner, job.kind, job.created});
    if (i % 5 == 0) {
      ASSERT_TRUE(store_->cancel(job.id));
    }
    now_ += i % 2 == 0 ? 1000 : -500;  // the clock may step back
  }
  const auto ids = [&](const JobFilter& filter) {
    std::vector<std::string> found;
    std::string cursor;
    for (;;) {
      const JobPage page = store_->list(3, cursor, filter, Detail::brief).value();
      for (const Job& job : page.jobs) found.push_back(job.id);
      if (!page.next) return found;
      cursor = *page.next;
    }
  };
  std::vector<JobFilter> filters;
  const Millis middle = made[12].created;
  for (const auto& owner : {std::optional<std::string>(), std::optional<std::string>("first")})
    for (const auto& states : {std::vector<JobState>(),
                               {JobState::queued},
                               {JobState::queued, JobState::cancelled},
                               {JobState::succeeded}})
      for (const auto& kind : {std::optional<JobKind>(), std::optional(JobKind::inspection)})
        for (const auto& after : {std::optional<Millis>(), std::optional(middle)})
          for (const auto& before : {std::optional<Millis>(), std::optional(middle + 2000)})
            filters.push_back({owner, states, kind, after, before});
  for (const JobFilter& f : filters) {
    std::vector<std::string> expected;
    for (const Made& m : made) {
      const JobState state = job(m.id).state;
      if ((!f.owner || m.owner == *f.owner) && (!f.kind || m.kind == *f.kind) &&
          (f.states.empty() || std::find(f.states.begin(), f.states.end(), state) != f.states.end()) &&
          (!f.created_after || m.created > *f.created_after) &&
          (!f.created_before || m.created < *f.created_before))
        expected.push_back(m.id);
    }
    EXPECT_EQ(ids(f), expected);
  }
  const Job brief = store_->list(1, "", {}, Detail::brief)->jobs.at(0);
  EXPECT_TRUE(brief.settings.empty() && brief.inputs.empty());
  EXPECT_EQ(store_->list(1, "")->jobs.at(0).inputs.size(), 2u);
}

// Two writers who saw the same: one of them wins.
TEST_P(StoreTest, AGuardSeesWhatTheChangeChanges) {
  for (int round = 0; round < 20; ++round) {
    std::atomic<int> won{0}, refused{0};
    const std::string seen = "{\"round\":" + std::to_string(round) + "}";
    ASSERT_TRUE(store_->put_profile({"shared", seen, 1}));
    std::vector<std::thread> writers;
    for (int i = 0; i < 4; ++i)
      writers.emplace_back([&, i] {
        const auto put = store_->put_profile(
            {"shared", std::to_string(i), 2},
            [&](const std::optional<Profile>& now) { return now && now->settings == seen; });
        if (put)
          ++won;
        else if (put.error().code == Code::conflict)
          ++refused;
      });
    for (auto& writer : writers) writer.join();
    EXPECT_EQ(won, 1);
    EXPECT_EQ(refused, 3);
  }
  EXPECT_EQ(store_->remove_profile("shared", [](const auto&) { return false; }).error().code, Code::conflict);
  EXPECT_TRUE(store_->find_profile("shared"));
  const Job made = create();
  const auto same = [&](const Job& now) { return now.version == made.version; };
  EXPECT_TRUE(store_->cancel(made.id, same));
  EXPECT_EQ(store_->cancel(made.id, same).error().code, Code::conflict);
  EXPECT_EQ(store_->remove(made.id, same).error().code, Code::conflict);
  EXPECT_TRUE(store_->remove(made.id));
}

TEST_P(StoreTest, CountsItsJobsByState) {
  EXPECT_EQ(store_->status()->counts, JobCounts{});
  create();
  create();
  store_->cancel(create().id).value();
  lease();
  JobCounts expected{};
  expected[static_cast<std::size_t>(JobState::queued)] = 1;
  expected[static_cast<std::size_t>(JobState::running)] = 1;
  expected[static_cast<std::size_t>(JobState::cancelled)] = 1;
  EXPECT_EQ(store_->status()->counts, expected);
}

TEST_P(StoreTest, KeepsCreatedJobsAfterACrashAndNothingOfOthers) {
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

TEST_P(StoreInFilesTest, AnOldBlobWithoutARowGoesToQuarantineAtTheNextStart) {
  create("kept", "kept too");
  const std::string orphan = text_hash("orphan");
  fs::create_directories(data() / "blobs" / orphan.substr(0, 2));
  change_blob(orphan, "orphan");
  const auto age = [&](std::chrono::hours hours) {
    fs::last_write_time(data() / "blobs" / orphan.substr(0, 2) / orphan,
                        fs::file_time_type::clock::now() - hours);
  };
  age(std::chrono::hours(1));
  reopen();
  EXPECT_EQ(blobs().count(orphan), 1u);
  age(std::chrono::hours(30));
  reopen();
  EXPECT_EQ(blobs().count(orphan), 0u);
  EXPECT_TRUE(fs::exists(data() / "quarantine" / orphan));
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

TEST_P(StoreTest, ADamagedFileIsNotGiven) {
  const Job made = create("a scan", "a pattern");
  reopen();
  const std::string hash = made.input("scan")->blob.sha256;
  change_blob(hash, "a scar");
  EXPECT_EQ(store_->open(made.input("scan")->blob).error().code, Code::gone);
  EXPECT_EQ(bytes_of(made.input("pattern")->blob), "a pattern");
}

TEST_P(StoreTest, SendingADamagedFileAgainRepairsIt) {
  const Job made = create("a scan", "a pattern");
  const std::string hash = made.input("scan")->blob.sha256;
  change_blob(hash, "a scar");
  create("a scan", "another pattern");
  EXPECT_EQ(bytes_of(made.input("scan")->blob), "a scan");
}

TEST_P(StoreTest, ABlobGoesWithTheLastJobThatNamesIt) {
  const Job first = create("a scan", "one"), second = create("a scan", "two");
  const auto kept = [&](const char* text) { return blobs().count(text_hash(text)) > 0; };
  ASSERT_TRUE(store_->cancel(first.id) && store_->remove(first.id));
  EXPECT_FALSE(kept("one"));
  EXPECT_TRUE(kept("a scan") && kept("two"));
  ASSERT_TRUE(store_->cancel(second.id) && store_->remove(second.id));
  EXPECT_FALSE(kept("a scan") || kept("two"));
}

// A deletion may take long, as that of a large file does.
TEST_P(StoreInFilesTest, TheStoreWorksWhileADeletionGoesOn) {
  const std::string id = create().id;
  std::future<bool> worked;
  std::atomic<bool> started{false};
  const std::function<void()> slow = [&] {
    if (started.exchange(true)) return;
    worked = std::async(std::launch::async, [&] {
      return store_->create(submission("another", "one")).has_value() && store_->expire().has_value();
    });
    EXPECT_EQ(worked.wait_for(std::chrono::seconds(60)), std::future_status::ready);
  };
  before_unlink = &slow;
  const bool removed = store_->cancel(id) && store_->remove(id);
  before_unlink = nullptr;
  EXPECT_TRUE(removed);
  ASSERT_TRUE(worked.valid());
  EXPECT_TRUE(worked.get());
}

TEST_P(StoreTest, ABackupOpensAsTheStoreWas) {
  const Job made = create("a scan", "a pattern"), ended = create("a scan", "another");
  const LeaseKey key = lease();
  ASSERT_TRUE(store_->put_artifact(key, "print.png", upload("ink")));
  ASSERT_TRUE(complete(key, {"print.png"}));
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
  EXPECT_EQ(report->blobs, 5);
  EXPECT_TRUE(report->damaged.empty());
  EXPECT_EQ(store_->backup(to, go_on).error().code, Code::bad_usage);  // not empty any more
  ASSERT_TRUE(store_->remove(made.id));
  open_backup(to);
  EXPECT_EQ(job(made.id).state, JobState::succeeded);
  EXPECT_EQ(bytes_of(job(made.id).artifacts.at(0).blob), "ink");
  EXPECT_EQ(bytes_of(job(ended.id).input("pattern")->blob), "another");
}

TEST_P(StoreTest, ABackupKeepsWhatIsDeletedMeanwhileAndLeavesOutWhatIsDamaged) {
  const Job made = create("a scan", "a pattern");
  ASSERT_TRUE(store_->cancel(made.id));
  const std::string damaged = create("damaged", "whole").input("scan")->blob.sha256;
  reopen();
  change_blob(damaged, "other");
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
  open_backup(to);
  EXPECT_EQ(bytes_of(job(made.id).input("scan")->blob), "a scan");
}

TEST_P(StoreTest, OnlyEndedJobsAreDeleted) {
  const std::string id = create().id;
  EXPECT_EQ(store_->remove(id).error().code, Code::conflict);
  const LeaseKey key = lease();
  EXPECT_EQ(store_->remove(id).error().code, Code::conflict);
  ASSERT_TRUE(complete(key));
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
  ASSERT_TRUE(complete(key, {"report.json"}));
  auto reading = store_->open(job(first).input("pattern")->blob).value();
  ASSERT_TRUE(store_->remove(first));
  EXPECT_EQ(blobs(), (std::set<std::string>{text_hash("same scan"), text_hash("two")}));
  EXPECT_EQ(bytes_of(job(second).input("scan")->blob), "same scan");
  std::string text(3, '\0');
  EXPECT_EQ(reading->read_at(0, text).value(), 3u);  // a download under way ends well
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
  EXPECT_EQ(complete(done, {"print.png"}).value().artifacts.size(), 21u);
  EXPECT_EQ(blobs().count(text_hash("of the failed")) + blobs().count(text_hash("of the cancelled")), 0u);
  EXPECT_EQ(blobs().count(text_hash("of the done")), 1u);
}

TEST_P(StoreTest, ARefusedPrintKeepsWhatExplainsIt) {
  const auto ends_with = [&](Retry retry) {
    create();
    const LeaseKey key = lease();
    for (const char* name : {"print.png", "mold.stl", "findings.json"})
      EXPECT_TRUE(store_->put_artifact(key, name, upload(std::string(name) + " of a refused print")));
    std::vector<std::string> names;
    const Job job = store_->fail_job(key, {Code::forming_failed, "the sheet tears", "", ""}, retry).value();
    for (const auto& artifact : job.artifacts) names.push_back(artifact.name);
    return names;
  };
  EXPECT_EQ(ends_with(Retry::after_fault), std::vector<std::string>{});  // it runs again
  ASSERT_TRUE(store_->cancel(lease().job));
  EXPECT_EQ(ends_with(Retry::never), (std::vector<std::string>{"mold.stl", "findings.json"}));
  EXPECT_EQ(blobs().count(text_hash("print.png of a refused print")), 0u);
}

TEST_P(StoreTest, AtMostOneProfileIsTheDefault) {
  for (const char* name : {"one", "two"}) ASSERT_TRUE(store_->put_profile({name, "{}", 1}));
  const auto defaults = [&] {
    std::string names;
    const ProfilePage page = store_->list_profiles(10, "").value();
    for (const Profile& profile : page.profiles)
      if (profile.is_default) names += profile.name + " ";
    return names;
  };
  EXPECT_EQ(defaults(), "");
  ASSERT_TRUE(store_->set_default_profile("one", true));
  ASSERT_TRUE(store_->set_default_profile("two", true));
  EXPECT_EQ(defaults(), "two ");
  ASSERT_TRUE(store_->put_profile({"two", R"({"print":{"dpi":300}})", 2}));
  EXPECT_EQ(defaults(), "two ");  // a change leaves it the default
  ASSERT_TRUE(store_->set_default_profile("one", false));
  EXPECT_EQ(defaults(), "two ");
  ASSERT_TRUE(store_->set_default_profile("two", false));
  EXPECT_EQ(defaults(), "");
  EXPECT_EQ(store_->set_default_profile("none", true).error().code, Code::not_found);
}

TEST_P(StoreTest, ASecondArtifactOfTheSameNameReplacesTheFirst) {
  const std::string id = create().id;
  const LeaseKey key = lease();
  ASSERT_TRUE(store_->put_artifact(key, "report.json", upload("first")));
  ASSERT_TRUE(store_->put_artifact(key, "print.png", upload("ink")));
  ASSERT_TRUE(store_->put_artifact(key, "report.json", upload("second")));
  ASSERT_TRUE(complete(key, {"report.json", "print.png"}));
  const Job found = job(id);
  ASSERT_EQ(found.artifacts.size(), 21u);
  EXPECT_EQ(found.artifacts[0].name, "print.png");  // the order of api/job.hpp
  EXPECT_EQ(found.artifacts[19].name, "report.json");
  EXPECT_EQ(bytes_of(found.artifacts[19].blob), "second");
  EXPECT_EQ(blobs().count(text_hash("first")), 0u);
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

TEST_P(StoreTest, KeepsReferenceAndNoteAsPartOfASubmission) {
  const auto submit = [&](const std::string& reference, const std::string& note,
                          const std::string& key = "key-0001") {
    NewJob job = submission("a scan", "a pattern", key);
    job.reference = reference;
    job.note = note;
    return store_->create(std::move(job));
  };
  const auto made = submit("CASE-12 ä", "two\nlines");
  ASSERT_TRUE(made);
  EXPECT_EQ(made->reference, "CASE-12 ä");
  reopen();
  EXPECT_EQ(job(made->id).note, "two\nlines");
  EXPECT_EQ(submit("CASE-12 ä", "two\nlines")->id, made->id);
  EXPECT_EQ(submit("CASE-13", "two\nlines").error().code, Code::conflict);
  EXPECT_EQ(submit("CASE-12 ä", "").error().code, Code::conflict);
  const Job listed = store_->list(1, "", {}, Detail::brief)->jobs.at(0);
  EXPECT_EQ(listed.reference + "/" + listed.note, "CASE-12 ä/two\nlines");
}

TEST_P(StoreTest, GivesAReferenceToOneHead) {
  const auto submit = [&](const std::string& scan, const std::string& reference, bool rescan = false,
                          const std::string& owner = "a") {
    NewJob job = submission(scan, "a pattern");
    job.reference = reference;
    job.rescan = rescan;
    job.owner = owner;
    return store_->create(std::move(job));
  };
  const auto first = submit("head one", "CASE-2000");
  ASSERT_TRUE(first);
  EXPECT_TRUE(submit("head one", "CASE-2000"));
  const auto other = submit("head two", "CASE-2000");
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, Code::conflict);
  EXPECT_EQ(other.error().where, "reference");
  EXPECT_EQ(store_->list(10, "")->jobs.size(), 2u);
  EXPECT_TRUE(submit("head two", ""));
  EXPECT_TRUE(submit("head two", "case-2000"));
  EXPECT_TRUE(submit("head two", "CASE-2000", false, "b"));  // of another owner
  const auto again = submit("head three", "CASE-2000", true);
  ASSERT_TRUE(again);
  EXPECT_EQ(store_->log_after(again->id, 0, 10)->back().text,
            "confirmed as another scan of the same patient");
  EXPECT_TRUE(submit("head three", "CASE-2000"));  // it is known now
  // A job that is cancelled makes no print.
  const auto wrong = submit("wrong file", "CASE-7");
  ASSERT_TRUE(wrong && store_->cancel(wrong->id));
  EXPECT_TRUE(submit("right file", "CASE-7"));
}

TEST_P(StoreTest, ChangesAReferenceAndRecordsWhoDidIt) {
  NewJob made = submission("head one", "a pattern", "key-0001");
  made.reference = "CASE-2000";
  made.owner = "a";
  const Job before = store_->create(std::move(made)).value();
  ASSERT_TRUE(store_->lease("w"));
  const Millis started = *job(before.id).started;
  const auto changed = store_->set_reference(before.id, {"CASE-2001", false, "a", "token-7"});
  ASSERT_TRUE(changed) << changed.error().text();
  EXPECT_GT(changed->version, before.version);
  EXPECT_EQ(store_->set_reference(before.id, {"CASE-2001", false, "a", "token-8"})->version,
            changed->version);
  reopen();
  const Job now = job(before.id);
  EXPECT_EQ(now.reference, "CASE-2001");
  EXPECT_EQ(now.state, JobState::running);
  EXPECT_EQ(reference_at(now, started), "CASE-2000");
  EXPECT_EQ(first_reference(now), "CASE-2000");
  const auto changes = nlohmann::json::parse(now.reference_changes);
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_GE(changes[0]["time"].get<Millis>(), started);
  EXPECT_EQ(changes[0]["owner"], "a");
  EXPECT_EQ(changes[0]["token"], "token-7");
  EXPECT_EQ(changes[0]["old"], "CASE-2000");
  EXPECT_EQ(changes[0]["new"], "CASE-2001");
  // The first submission again is still the same one.
  NewJob again = submission("head one", "a pattern", "key-0001");
  again.reference = "CASE-2000";
  again.owner = "a";
  EXPECT_EQ(store_->create(std::move(again))->id, before.id);

  NewJob second = submission("head two", "a pattern");
  second.reference = "CASE-3000";
  second.owner = "a";
  const std::string other = store_->create(std::move(second))->id;
  const auto taken = store_->set_reference(other, {"CASE-2001", false, "a", "t"});
  ASSERT_FALSE(taken);
  EXPECT_EQ(taken.error().where, "reference");
  EXPECT_EQ(job(other).reference, "CASE-3000");
  EXPECT_TRUE(store_->set_reference(other, {"CASE-2001", true, "a", "t"}));
  EXPECT_TRUE(store_->set_reference(other, {"", false, "a", "t"}));
  for (int i = 2; i < most_reference_changes; ++i)
    ASSERT_TRUE(store_->set_reference(other, {"C-" + std::to_string(i), false, "a", "t"}));
  EXPECT_EQ(store_->set_reference(other, {"one too many", false, "a", "t"}).error().code, Code::conflict);
  EXPECT_EQ(store_->set_reference("0nobody", {"x", false, "a", "t"}).error().code, Code::not_found);
}

TEST_P(StoreTest, ListsJobsByTheirText) {
  // Ids have no i, l, o or u: the texts below are in none of them.
  const auto make = [&](const std::string& reference, const std::string& note,
                        const std::string& owner = "a") {
    NewJob job = submission();
    job.reference = reference;
    job.note = note;
    job.owner = owner;
    return store_->create(std::move(job))->id;
  };
  const std::string koeln = make("KÖLN 100%", ""), under = make("LOU_1", "second scan\nurgent"),
                    plain = make("lou-1", "", "b");
  const auto found = [&](const std::string& text, JobFilter filter = {}) {
    filter.text = text;
    std::vector<std::string> ids;
    const JobPage page = store_->list(10, "", filter).value();
    for (const Job& job : page.jobs) ids.push_back(job.id);
    return ids;
  };
  using Ids = std::vector<std::string>;
  EXPECT_EQ(found("köln"), Ids{koeln});
  EXPECT_EQ(found("KOLN"), Ids{});
  EXPECT_EQ(found("%"), Ids{koeln});
  EXPECT_EQ(found("_"), Ids{under});
  EXPECT_EQ(found("*"), Ids{});
  EXPECT_EQ(found("lou"), (Ids{plain, under}));
  EXPECT_EQ(found("SCAN\nUrg"), Ids{under});
  EXPECT_EQ(found("Lou", {.owner = "b"}), Ids{plain});
  EXPECT_EQ(found("lou", {.states = {JobState::failed}}), Ids{});
  EXPECT_EQ(found("lou", {.kind = JobKind::print}), (Ids{plain, under}));
  std::string end = koeln.substr(18);
  for (char& c : end) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  EXPECT_EQ(found(end), Ids{koeln});
  // In pages: the cursor stands between two that are found.
  const JobPage first = store_->list(1, "", {.text = "lou"}).value();
  ASSERT_EQ(first.jobs.size(), 1u);
  EXPECT_EQ(first.jobs[0].id, plain);
  const JobPage second = store_->list(1, first.next.value(), {.text = "lou"}).value();
  ASSERT_EQ(second.jobs.size(), 1u);
  EXPECT_EQ(second.jobs[0].id, under);
  EXPECT_FALSE(second.next);
}

TEST_P(StoreTest, TellsAdministratorsHowItDoes) {
  const StoreStatus empty = store_->status().value();
  EXPECT_FALSE(empty.oldest_queued || empty.last_backup);
  EXPECT_GT(empty.disk.total, empty.disk.free);
  EXPECT_EQ(empty.disk.kept_free, 3u << 18);  // three quarters of what the test keeps free

  create();
  const LeaseKey key = lease();
  const Millis first = now_ += 1000;
  create();
  now_ += 5000;
  create();
  ASSERT_TRUE(store_->heartbeat(key, std::nullopt, 0));
  now_ += 2000;
  const StoreStatus status = store_->status().value();
  EXPECT_EQ(status.counts[static_cast<std::size_t>(JobState::queued)], 2);
  EXPECT_EQ(status.oldest_queued, first);
  ASSERT_EQ(status.working.size(), 1u);
  EXPECT_EQ(status.working[0].name, "tester");
  EXPECT_EQ(status.working[0].job, key.job);
  EXPECT_EQ(status.working[0].heard, now_ - 2000);
  now_ += 60'000;  // the lease is over
  EXPECT_TRUE(store_->status()->working.empty());

  const fs::path copy = folder_ / "copy";
  fs::create_directory(copy);
  fs::permissions(copy, fs::perms::owner_all);
  ASSERT_TRUE(store_->backup(copy, [] { return true; }));
  EXPECT_EQ(store_->status()->last_backup, now_);
  ASSERT_FALSE(store_->backup(copy, [] { return true; }));  // not empty
  reopen();
  EXPECT_EQ(store_->status()->last_backup, now_);
}

}  // namespace
}  // namespace vacuform
