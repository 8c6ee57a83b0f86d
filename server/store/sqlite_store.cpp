// The store on SQLite. One process and one connection own the database: SQLite before 3.51.3 can lose
// committed rows in WAL mode when one connection checkpoints while another writes. A file lock keeps a second
// server out with a plain message, exclusive locking keeps everything else out.
#include <fcntl.h>
#include <sys/file.h>

#include <algorithm>
#include <exception>
#include <mutex>

#include "server/secrets.hpp"
#include "server/store/group_commit.hpp"
#include "server/store/job_id.hpp"
#include "server/store/schema.hpp"
#include "server/store/sqlite.hpp"
#include "server/store/store.hpp"

namespace vacuform {

namespace {

class SqliteStore : public Store {
 public:
  SqliteStore(StoreOptions options, Blobs blobs, File lock)
      : options_(std::move(options)), lock_(std::move(lock)), blobs_(std::move(blobs)) {}

  Result<void> open(const std::filesystem::path& data) {
    VACUFORM_CHECK(db_.open((data / "jobs.sqlite").string()));
    VACUFORM_CHECK(
        db_.execute("PRAGMA locking_mode=EXCLUSIVE; PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;"
                    "PRAGMA foreign_keys=ON; PRAGMA trusted_schema=OFF"));
    VACUFORM_CHECK(bring_up_to_date(db_));
    VACUFORM_CHECK(sync_directory(data));
    {
      Query newest(db_, "SELECT max(created) FROM job");
      VACUFORM_TRY(found, newest.row());
      if (found) last_id_time_ = newest.integer(0);
    }
    VACUFORM_CHECK(Query(db_, "UPDATE job SET lease_ends=? WHERE state IN ('running','cancelling')",
                         options_.clock() + options_.lease)
                       .run());
    // A crash may have come between a file and the row that names it.
    return blobs_.sweep([&](const std::string& sha256) { return named(sha256).value_or(true); });
  }

  Result<Upload> upload() override { return blobs_.upload(); }
  std::filesystem::path temporary_path() override { return blobs_.temporary_path(); }

  Result<Job> create(NewJob job) override {
    std::vector<Blob> blobs;
    for (auto& input : job.inputs) {
      if (auto* upload = std::get_if<Upload>(&input.file)) {
        VACUFORM_CHECK(upload->seal());  // the slow flush of the bytes comes before the lock
      }
      blobs.push_back(blob_of(input));
    }
    return write([&]() -> Result<Job> {
      if (!job.client_key.empty()) {
        VACUFORM_TRY(earlier, made_before(job, blobs));
        if (earlier) return *earlier;
      }
      const Millis now = options_.clock();
      last_id_time_ = std::max(now, last_id_time_ + 1);
      const std::string id = make_job_id(last_id_time_);
      std::optional<std::string> client_key;
      if (!job.client_key.empty()) client_key = key_of(job);
      VACUFORM_CHECK(Query(db_,
                           "INSERT INTO job(id, client_key, state, created, settings, request, owner)"
                           " VALUES(?,?,'queued',?,?,?,?)",
                           id, client_key, now, job.settings, job.request, job.owner)
                         .run());
      for (std::size_t i = 0; i < blobs.size(); ++i) {
        VACUFORM_CHECK(keep(job.inputs[i], blobs[i]));
        VACUFORM_CHECK(Query(db_, "INSERT INTO input(job, name, blob, bytes, extension) VALUES(?,?,?,?,?)",
                             id, job.inputs[i].name, blobs[i].sha256, blobs[i].bytes, job.inputs[i].extension)
                           .run());
      }
      return find(id);
    });
  }

  Result<Job> job(const std::string& id) override {
    const std::lock_guard hold(commits_.lock());
    return find(id);
  }

  Result<JobPage> list(int limit, const std::string& cursor,
                       const std::optional<std::string>& owner) override {
    const std::lock_guard hold(commits_.lock());
    limit = std::clamp(limit, 1, 100);
    std::vector<std::string> ids;
    const std::string before = cursor.empty() ? "~" : cursor;
    const auto collect = [&](Query query) -> Result<void> {
      for (;;) {
        VACUFORM_TRY(more, query.row());
        if (!more) return {};
        ids.push_back(query.text(0));
      }
    };
    VACUFORM_CHECK(
        owner
            ? collect({db_, "SELECT id FROM job WHERE owner=? AND id < ? ORDER BY id DESC LIMIT ?", *owner,
                       before, limit + 1})
            : collect({db_, "SELECT id FROM job WHERE id < ? ORDER BY id DESC LIMIT ?", before, limit + 1}));
    JobPage page;
    if (ids.size() > static_cast<std::size_t>(limit)) {
      ids.pop_back();
      page.next = ids.back();
    }
    for (const auto& id : ids) {
      VACUFORM_TRY(job, find(id));
      page.jobs.push_back(std::move(job));
    }
    return page;
  }

  Result<JobCounts> counts() override {
    const std::lock_guard hold(commits_.lock());
    JobCounts counts{};
    Query query(db_, "SELECT state, count(*) FROM job GROUP BY state");
    for (;;) {
      VACUFORM_TRY(more, query.row());
      if (!more) return counts;
      if (const auto state = job_state_from(query.text(0)))
        counts[static_cast<std::size_t>(*state)] = query.integer(1);
    }
  }

  Result<Job> cancel(const std::string& id) override {
    return write([&]() -> Result<Job> {
      VACUFORM_TRY(job, find(id));
      if (job.state == JobState::succeeded || job.state == JobState::failed)
        return fail(Code::conflict, "the job has " + std::string(name(job.state)) + " already", id,
                    "delete it if you do not need it");
      if (job.state == JobState::queued) {
        VACUFORM_CHECK(end(job, JobState::cancelled, {}));
      } else if (job.state == JobState::running) {
        VACUFORM_CHECK(Query(db_, "UPDATE job SET state='cancelling' WHERE id=?", id).run());
      }
      return find(id);
    });
  }

  Result<void> remove(const std::string& id) override {
    return write([&]() -> Result<void> {
      VACUFORM_TRY(job, find(id));
      if (!ended(job.state))
        return fail(Code::conflict, "the job is " + std::string(name(job.state)), id, "cancel it first");
      for (const auto& input : job.inputs) maybe_garbage(input.blob.sha256);
      for (const auto& artifact : job.artifacts) maybe_garbage(artifact.blob.sha256);
      return Query(db_, "DELETE FROM job WHERE id=?", id).run();
    });
  }

  Result<File> open(const Blob& blob) override { return blobs_.read(blob.sha256); }

  Result<void> add_token(const Token& token) override {
    return write([&]() -> Result<void> {
      if (find_token(token.id)) return fail(Code::conflict, "there is a token of this id", token.id);
      return Query(db_,
                   "INSERT INTO token(id, owner, scopes, hash, created, expires, revoked) "
                   "VALUES(?,?,?,?,?,?,?)",
                   token.id, token.owner, token.scopes.text(), token.hash, token.created, token.expires,
                   token.revoked)
          .run();
    });
  }

  Result<Token> token(const std::string& id) override {
    const std::lock_guard hold(commits_.lock());
    return find_token(id);
  }

  Result<std::vector<Token>> tokens() override {
    const std::lock_guard hold(commits_.lock());
    std::vector<std::string> ids;
    {
      Query query(db_, "SELECT id FROM token ORDER BY created, id");
      for (;;) {
        VACUFORM_TRY(more, query.row());
        if (!more) break;
        ids.push_back(query.text(0));
      }
    }
    std::vector<Token> found;
    for (const auto& id : ids) {
      VACUFORM_TRY(token, find_token(id));
      found.push_back(std::move(token));
    }
    return found;
  }

  Result<void> revoke_token(const std::string& id) override {
    return write([&]() -> Result<void> {
      VACUFORM_CHECK(find_token(id));
      return Query(db_, "UPDATE token SET revoked=coalesce(revoked, ?) WHERE id=?", options_.clock(), id)
          .run();
    });
  }

  Result<std::optional<LeasedJob>> lease(const std::string& worker) override {
    return write([&]() -> Result<std::optional<LeasedJob>> {
      VACUFORM_TRY(expired, expire_now());
      Query oldest(db_, "SELECT id FROM job WHERE state='queued' ORDER BY id LIMIT 1");
      VACUFORM_TRY(found, oldest.row());
      if (!found) return std::optional<LeasedJob>();
      const std::string id = oldest.text(0), token = random_hex(32);
      const Millis now = options_.clock();
      VACUFORM_CHECK(
          Query(db_,
                "UPDATE job SET state='running', attempt=attempt+1, started=?, stage=NULL, progress=0,"
                " worker=?, lease_hash=?, lease_ends=? WHERE id=?",
                now, worker, text_hash(token), now + options_.lease, id)
              .run());
      VACUFORM_TRY(job, find(id));
      return std::optional<LeasedJob>(LeasedJob{std::move(job), token});
    });
  }

  Result<Job> leased(const LeaseKey& key) override {
    return write([&] { return holder(key, false); });
  }

  Result<bool> heartbeat(const LeaseKey& key, std::optional<Stage> stage, double progress) override {
    return write([&]() -> Result<bool> {
      VACUFORM_TRY(job, holder(key, false));
      std::optional<std::string_view> stage_name;
      if (stage) stage_name = name(*stage);
      VACUFORM_CHECK(Query(db_, "UPDATE job SET lease_ends=?, stage=?, progress=? WHERE id=?",
                           options_.clock() + options_.lease, stage_name, std::clamp(progress, 0.0, 1.0),
                           job.id)
                         .run());
      return job.state == JobState::cancelling;
    });
  }

  Result<void> put_artifact(const LeaseKey& key, const std::string& name, Upload upload) override {
    VACUFORM_TRY(blob, upload.seal());
    return write([&]() -> Result<void> {
      VACUFORM_TRY(job, holder(key, false));
      maybe_garbage(blob.sha256);
      for (const auto& old : job.artifacts)
        if (old.name == name) maybe_garbage(old.blob.sha256);
      VACUFORM_CHECK(blobs_.keep(upload));
      return Query(db_, "INSERT OR REPLACE INTO artifact(job, name, blob, bytes) VALUES(?,?,?,?)", job.id,
                   name, blob.sha256, blob.bytes)
          .run();
    });
  }

  Result<Job> complete(const LeaseKey& key) override { return finish(key, JobState::succeeded, {}, false); }
  Result<Job> fail_job(const LeaseKey& key, const Error& error, bool retry) override {
    return finish(key, JobState::failed, error, retry);
  }
  Result<Job> cancelled(const LeaseKey& key) override { return finish(key, JobState::cancelled, {}, false); }

  Result<Job> release(const LeaseKey& key) override {
    return write([&]() -> Result<Job> {
      VACUFORM_TRY(job, holder(key, false));
      if (job.state == JobState::cancelling) {
        VACUFORM_CHECK(end(job, JobState::cancelled, {}));
      } else {
        VACUFORM_CHECK(queue_again(job, 0));
      }
      return find(job.id);
    });
  }

  Result<std::vector<Expired>> expire() override {
    return write([&] { return expire_now(); });
  }

  Result<std::vector<Expired>> bury(const std::string& worker) override {
    return write([&]() -> Result<std::vector<Expired>> {
      VACUFORM_CHECK(Query(db_,
                           "UPDATE job SET lease_ends=0 WHERE worker=? AND state IN ('running','cancelling')",
                           worker)
                         .run());
      return expire_now();
    });
  }

 private:
  // Runs `change` in a transaction and returns when that is on the disk; an error of `change` undoes it.
  template <class Change>
  auto write(Change change) -> decltype(change()) {
    decltype(change()) result = fail(Code::internal, "the store met a fault of its own", {}, "try again");
    const auto committed = commits_.run([&] {
      try {
        result = change();
      } catch (const std::exception& fault) {  // a bug or no memory: one change fails, the others go on
        result = fail(Code::internal, std::string("the store met a fault of its own: ") + fault.what());
      }
      return result.has_value();
    });
    if (!committed) result = tl::make_unexpected(committed.error());
    return result;
  }

  // After the transaction, the file goes unless a row names it by then.
  void maybe_garbage(const std::string& sha256) { garbage_.push_back(sha256); }
  void remove_garbage() {
    for (const auto& sha256 : garbage_)
      if (const auto used = named(sha256); used && !*used) blobs_.remove(sha256);
    garbage_.clear();
  }

  // Whether any row names the blob.
  Result<bool> named(const std::string& sha256) {
    Query query(db_,
                "SELECT 1 FROM input WHERE blob=?1 UNION ALL SELECT 1 FROM artifact WHERE blob=?1 LIMIT 1",
                sha256);
    return query.row();
  }

  Result<Token> find_token(const std::string& id) {
    Query query(db_, "SELECT id, owner, scopes, hash, created, expires, revoked FROM token WHERE id=?", id);
    VACUFORM_TRY(found, query.row());
    if (!found) return fail(Code::not_found, "there is no such token", id, "see the list of tokens");
    Token token{query.text(0), query.text(1),    Scopes::from(query.text(2)).value_or(Scopes()),
                query.text(3), query.integer(4), std::nullopt,
                std::nullopt};
    if (!query.null(5)) token.expires = query.integer(5);
    if (!query.null(6)) token.revoked = query.integer(6);
    return token;
  }

  // Each owner has keys of his own: nobody learns of another's jobs, or is refused, because both chose the same.
  static std::string key_of(const NewJob& job) {
    return job.owner.empty() ? job.client_key : job.owner + "/" + job.client_key;
  }

  static Blob blob_of(NewInput& input) {
    const auto* blob = std::get_if<Blob>(&input.file);
    return blob ? *blob : *std::get<Upload>(input.file).seal();  // which has been sealed before
  }

  // Under the lock, so that a job deleted at the same time does not take the file away again.
  Result<void> keep(NewInput& input, const Blob& blob) {
    maybe_garbage(blob.sha256);
    if (auto* upload = std::get_if<Upload>(&input.file)) return blobs_.keep(*upload);
    VACUFORM_TRY(there, named(blob.sha256));
    if (there) return {};
    return fail(Code::gone, "the file was deleted meanwhile", input.name, "send it again");
  }

  // The job that an earlier submission under the same key made.
  Result<std::optional<Job>> made_before(const NewJob& job, const std::vector<Blob>& blobs) {
    Query query(db_, "SELECT id FROM job WHERE client_key=?", key_of(job));
    VACUFORM_TRY(found, query.row());
    if (!found) return std::optional<Job>();
    VACUFORM_TRY(earlier, find(query.text(0)));
    bool same = earlier.settings == job.settings && earlier.inputs.size() == blobs.size();
    for (std::size_t i = 0; same && i < blobs.size(); ++i) {
      const Input* input = earlier.input(job.inputs[i].name);
      same = input && input->blob.sha256 == blobs[i].sha256;
    }
    if (!same)
      return fail(Code::conflict, "the idempotency key was used for another submission", earlier.id,
                  "take a new key");
    return std::optional<Job>(std::move(earlier));
  }

  Result<Job> find(const std::string& id) {
    Query query(db_,
                "SELECT id, state, stage, progress, attempt, created, started, ended, error_code, error_what,"
                " error_where, error_mend, settings, request, owner FROM job WHERE id=?",
                id);
    VACUFORM_TRY(found, query.row());
    if (!found) return fail(Code::not_found, "there is no such job", id, "see the list of jobs");
    const auto state = job_state_from(query.text(1));
    if (!state) return fail(Code::corrupt_file, "the job store is damaged: unknown state", id);
    Job job;
    job.id = query.text(0);
    job.state = *state;
    job.stage = stage_from(query.text(2));
    job.stage_progress = query.real(3);
    job.attempt = static_cast<int>(query.integer(4));
    job.created = query.integer(5);
    if (!query.null(6)) job.started = query.integer(6);
    if (!query.null(7)) job.ended = query.integer(7);
    if (!query.null(8))
      job.error = Error{code_from(query.text(8)).value_or(Code::internal), query.text(9), query.text(10),
                        query.text(11)};
    job.settings = query.text(12);
    job.request = query.text(13);
    job.owner = query.text(14);
    Query inputs(db_, "SELECT name, blob, bytes, extension FROM input WHERE job=?", id);
    for (;;) {
      VACUFORM_TRY(more, inputs.row());
      if (!more) break;
      job.inputs.push_back(
          {inputs.text(0), {inputs.text(1), static_cast<std::uint64_t>(inputs.integer(2))}, inputs.text(3)});
    }
    std::sort(job.inputs.begin(), job.inputs.end(), [](const Input& a, const Input& b) {
      return input_kind(a.name) < input_kind(b.name);  // places in one table
    });
    Query artifacts(db_, "SELECT name, blob, bytes FROM artifact WHERE job=?", id);
    for (;;) {
      VACUFORM_TRY(more, artifacts.row());
      if (!more) break;
      job.artifacts.push_back(
          {artifacts.text(0), {artifacts.text(1), static_cast<std::uint64_t>(artifacts.integer(2))}});
    }
    std::sort(job.artifacts.begin(), job.artifacts.end(),
              [](const StoredArtifact& a, const StoredArtifact& b) {
                return artifact_kind(a.name) < artifact_kind(b.name);  // places in one table
              });
    return job;
  }

  // The job that the key's lease holds. Ended jobs count only when `even_ended`.
  Result<Job> holder(const LeaseKey& key, bool even_ended) {
    VACUFORM_TRY(expired, expire_now());
    Query query(db_, "SELECT lease_hash FROM job WHERE id=? AND lease_hash IS NOT NULL", key.job);
    VACUFORM_TRY(found, query.row());
    if (found && equal_secrets(query.text(0), text_hash(key.token))) {
      VACUFORM_TRY(job, find(key.job));
      if (even_ended || !ended(job.state)) return job;
    }
    return fail(Code::lease_lost, "the lease of this job has ended", key.job,
                "stop working on this job and ask for another");
  }

  Result<Job> finish(const LeaseKey& key, JobState wanted, const std::optional<Error>& error, bool retry) {
    return write([&]() -> Result<Job> {
      VACUFORM_TRY(job, holder(key, true));
      if (ended(job.state)) return job;
      if (job.state == JobState::cancelling) wanted = JobState::cancelled;
      if (wanted == JobState::failed && retry) {
        Query losses(db_, "SELECT losses FROM job WHERE id=?", job.id);
        VACUFORM_TRY(found, losses.row());
        if (found && losses.integer(0) + 1 < options_.losses) {
          VACUFORM_CHECK(queue_again(job, 1));
          return find(job.id);
        }
      }
      VACUFORM_CHECK(end(job, wanted, wanted == JobState::failed ? error : std::nullopt));
      return find(job.id);
    });
  }

  // The hash of the lease stays, so that the same ending under the same token can be answered again.
  // Only a job that has succeeded keeps artifacts: half a set helps nobody.
  Result<void> end(const Job& job, JobState state, const std::optional<Error>& error) {
    if (state != JobState::succeeded) {
      VACUFORM_CHECK(drop_artifacts(job));
    }
    std::optional<std::string_view> code, what, where, mend;
    if (error) code = meaning(error->code).slug, what = error->what, where = error->where, mend = error->mend;
    return Query(
               db_,
               "UPDATE job SET state=?, ended=?, lease_ends=NULL, error_code=?, error_what=?, error_where=?,"
               " error_mend=? WHERE id=?",
               name(state), options_.clock(), code, what, where, mend, job.id)
        .run();
  }

  Result<void> drop_artifacts(const Job& job) {
    for (const auto& artifact : job.artifacts) maybe_garbage(artifact.blob.sha256);
    return Query(db_, "DELETE FROM artifact WHERE job=?", job.id).run();
  }

  // Back to the queue; what the attempt left behind is dropped.
  Result<void> queue_again(const Job& job, int losses) {
    VACUFORM_CHECK(drop_artifacts(job));
    return Query(db_,
                 "UPDATE job SET state='queued', stage=NULL, progress=0, started=NULL, worker=NULL,"
                 " lease_hash=NULL, lease_ends=NULL, losses=losses+? WHERE id=?",
                 losses, job.id)
        .run();
  }

  Result<std::vector<Expired>> expire_now() {
    std::vector<std::pair<std::string, std::int64_t>> over;  // id, losses before this one
    {
      Query query(db_,
                  "SELECT id, losses FROM job WHERE state IN ('running','cancelling') AND lease_ends <= ?"
                  " ORDER BY id",
                  options_.clock());
      for (;;) {
        VACUFORM_TRY(more, query.row());
        if (!more) break;
        over.emplace_back(query.text(0), query.integer(1));
      }
    }
    std::vector<Expired> expired;
    for (const auto& [id, losses] : over) {
      VACUFORM_TRY(job, find(id));
      JobState state = JobState::queued;
      if (job.state == JobState::cancelling) {
        state = JobState::cancelled;
        VACUFORM_CHECK(end(job, state, {}));
      } else if (losses + 1 >= options_.losses) {
        state = JobState::failed;
        VACUFORM_CHECK(end(
            job, state,
            Error{Code::internal, std::to_string(losses + 1) + " workers were lost while they ran this job",
                  id, "look at the workers' logs; a coarser sheet.resolution_mm needs less memory"}));
      } else {
        VACUFORM_CHECK(queue_again(job, 1));
      }
      // The lost worker must not hear that its lease was good.
      VACUFORM_CHECK(Query(db_, "UPDATE job SET lease_hash=NULL WHERE id=?", id).run());
      expired.push_back({id, state});
    }
    return expired;
  }

  StoreOptions options_;
  File lock_;  // released last
  Blobs blobs_;
  // Everything below is touched under commits_.lock() alone.
  Database db_;
  GroupCommit commits_{db_, [this] { remove_garbage(); }};
  Millis last_id_time_ = 0;
  std::vector<std::string> garbage_;
};

}  // namespace

Result<std::unique_ptr<Store>> open_store(const std::filesystem::path& data, StoreOptions options) {
  VACUFORM_CHECK(make_directory(data));
  File lock(::open((data / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600));
  if (!lock.is_open() || ::flock(lock.descriptor(), LOCK_EX | LOCK_NB) != 0)
    return fail(Code::unavailable, "another server uses this data folder", data.string(),
                "stop it, or give another folder with --data");
  VACUFORM_TRY(blobs, Blobs::open(data));
  auto store = std::make_unique<SqliteStore>(std::move(options), std::move(blobs), std::move(lock));
  VACUFORM_CHECK(store->open(data));
  return std::unique_ptr<Store>(std::move(store));
}

}  // namespace vacuform
