#include "server/store/sql/sql_store.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "api/base/secrets.hpp"
#include "server/store/blobs/files/file_blobs.hpp"
#include "server/store/blobs/s3/s3_blobs.hpp"
#include "server/store/folder_mark.hpp"
#include "server/store/job_id.hpp"
#include "server/store/sql/backup.hpp"

namespace vacuform {

void SqlStore::follow(const std::vector<std::string>& garbage, const std::vector<std::string>& changed,
                      const std::vector<Job>& ended) {
  if (options_.job_ended)
    for (const Job& job : ended) options_.job_ended(job);
  add_garbage(garbage);
  if (changed.empty()) return;
  notifications_.tell(changed);
  announce(changed);
}

std::string SqlStore::next_id() {
  const Millis now = options_.clock();
  Millis last = last_id_time_.load(), next = 0;
  do next = std::max(now, last + 1);
  while (!last_id_time_.compare_exchange_weak(last, next));
  return make_job_id(next);
}

void SqlStore::add_garbage(const std::vector<std::string>& hashes) {
  if (hashes.empty()) return;
  const std::lock_guard hold(garbage_mutex_);
  garbage_.insert(garbage_.end(), hashes.begin(), hashes.end());
}

void SqlStore::collect_garbage() {
  std::vector<std::string> garbage;
  {
    const std::lock_guard hold(garbage_mutex_);
    if (backups_ == 0) garbage.swap(garbage_);
  }
  if (garbage.empty()) return;
  for (const std::string& sha256 : garbage)
    blobs_->collect(sha256, [this](const std::string& blob) { return wanted(blob); });
  {
    const std::lock_guard hold(garbage_mutex_);  // what a backup still holds is pending on
    std::erase_if(garbage, [&](const std::string& sha256) {
      return std::ranges::find(garbage_, sha256) != garbage_.end();
    });
  }
  (void)transaction([&](Database& db) {
    return std::ranges::all_of(garbage, [&](const std::string& sha256) {
      return Query(db, "DELETE FROM pending_deletion WHERE blob=?", sha256).run().has_value();
    });
  });
  forget_deleted();
}

Result<void> SqlStore::add_pending(Database& db, const std::vector<std::string>& hashes) {
  for (const std::string& sha256 : hashes)
    VACUFORM_CHECK(
        Query(db, "INSERT INTO pending_deletion(blob) VALUES(?) ON CONFLICT(blob) DO NOTHING", sha256).run());
  return {};
}

Result<bool> SqlStore::wanted(const std::string& sha256) {
  bool stays = false;
  {
    const std::lock_guard hold(garbage_mutex_);
    stays = backups_ > 0;
  }
  Result<bool> found = true;
  if (!stays) {
    found = read([&](Database& db) -> Result<bool> {
      stays = !settled();
      return stays ? Result<bool>(true) : named(db, sha256);
    });
  }
  if (stays) add_garbage({sha256});
  return found;
}

Result<bool> SqlStore::named(Database& db, const std::string& sha256) {
  Query query(
      db,
      "SELECT 1 FROM input WHERE blob=?1 UNION ALL SELECT 1 FROM artifact WHERE blob=?1"
      " UNION ALL SELECT 1 FROM upload WHERE blob=?1 UNION ALL SELECT 1 FROM upload_piece WHERE blob=?1"
      " UNION ALL SELECT 1 FROM scan WHERE blob=?1 LIMIT 1",
      sha256);
  return query.row();
}

Result<void> SqlStore::begin_blobs() {
  VACUFORM_CHECK(blobs_->begin(*this));
  auto pending = read([](Database& db) -> Result<std::vector<std::string>> {
    std::vector<std::string> hashes;
    Query query(db, "SELECT blob FROM pending_deletion");
    for (;;) {
      VACUFORM_TRY(more, query.row());
      if (!more) return hashes;
      hashes.push_back(query.text(0));
    }
  });
  if (!pending) return tl::make_unexpected(pending.error());
  add_garbage(*pending);
  collect_garbage();
  const auto swept = blobs_->sweep(
      [this](const std::string& sha256) { return read([&](Database& db) { return named(db, sha256); }); },
      options_.quarantine_days);
  if (!swept) return tl::make_unexpected(swept.error());
  const std::lock_guard hold(damage_mutex_);
  unnamed_files_ = swept->files, unnamed_bytes_ = swept->bytes;
  return {};
}

Result<void> SqlStore::match_folder(const std::filesystem::path& data, const char* database) {
  FolderMark mark;
  if (const auto read = read_folder_mark(data); read)
    mark = *read;
  else if (!options_.adopt)
    return tl::make_unexpected(read.error());
  FolderMark ours{database, ""};
  bool jobs = false;
  const auto looked = transaction([&](Database& db) {
    if (options_.adopt && !Query(db, "DELETE FROM remembered WHERE name='database'").run()) return false;
    const auto number = random_number() & 0x7fffffff;
    if (!Query(db, "INSERT INTO remembered(name, value) VALUES('database', ?) ON CONFLICT(name) DO NOTHING",
               number)
             .run())
      return false;
    Query query(db,
                "SELECT value, CASE WHEN EXISTS(SELECT 1 FROM job) THEN 1 ELSE 0 END FROM remembered"
                " WHERE name='database'");
    if (!query.row().value_or(false)) return false;
    ours.number = std::to_string(query.integer(0));
    jobs = query.integer(1) != 0;
    return true;
  });
  VACUFORM_CHECK(looked);
  if (ours.number.empty()) return fail(Code::unavailable, "the database cannot be used", {}, "see its log");
  if (mark == ours) return {};
  const std::string adopt = ", or, if this database is the right one, bind both with vacuform-server adopt";
  const bool files = blobs_in_files(options_.blobs);
  if (options_.adopt) return write_folder_mark(data, ours);
  std::error_code error;
  if (ours.database == postgresql_name &&
      (mark.database == sqlite_name || std::filesystem::exists(data / "jobs.sqlite", error)))
    return fail(Code::corrupt_file, "the jobs of this data folder are in SQLite", data.string(),
                "leave --store out, or give an empty folder with --data");
  if (!mark.database.empty())
    return fail(Code::corrupt_file, "the data folder belongs to another database", data.string(),
                "put its database back" + adopt);
  if (files && has_blobs(data))
    return fail(Code::corrupt_file, "the data folder does not say which database its files belong to",
                data.string(), "give another folder with --data" + adopt);
  if (files && jobs)
    return fail(Code::corrupt_file, "the files of the jobs in the database are in another data folder",
                data.string(), "give that folder with --data" + adopt);
  return write_folder_mark(data, ours);
}

Result<Blob> SqlStore::Stored::add(std::variant<Upload, Blob>& file) {
  if (const auto* blob = std::get_if<Blob>(&file)) {
    pins.emplace_back(store.blobs_->pin(blob->sha256), blob->sha256);
    return *blob;
  }
  auto& upload = std::get<Upload>(file);
  VACUFORM_TRY(pin, store.blobs_->put(upload));
  pins.emplace_back(std::move(pin), upload.digest().sha256);
  return upload.digest();
}

SqlStore::Stored::~Stored() {
  if (stay) return;
  for (auto& [pin, sha256] : pins) {
    pin.release();
    store.add_garbage({sha256});
  }
}

Result<BackupReport> SqlStore::backup(const std::filesystem::path& to, const std::function<bool()>& going) {
  // Keeps every blob that a row names while this object exists.
  struct Hold {
    explicit Hold(SqlStore& s) : store(s) {
      const std::lock_guard lock(store.garbage_mutex_);
      ++store.backups_;
    }
    ~Hold() {
      {
        const std::lock_guard lock(store.garbage_mutex_);
        --store.backups_;
      }
      store.collect_garbage();
    }
    SqlStore& store;
  } const hold(*this);
  return make_backup(
      to, *blobs_, [&](const std::filesystem::path& file) { return copy_rows(file, going); }, going,
      [&] { return remember("last_backup"); });
}

Result<File> lock_data_folder(const std::filesystem::path& data) {
  VACUFORM_CHECK(make_directory(data));
  File lock(::open((data / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600));
  if (!lock.is_open())
    return fail(errno == ENOSPC ? Code::disk_full : Code::unavailable, "the data folder cannot be written to",
                data.string(), "check that the server may write there, and that its disk has room");
  if (::flock(lock.descriptor(), LOCK_EX | LOCK_NB) != 0)
    return fail(Code::unavailable, "another server uses this data folder", data.string(),
                "stop it, or give another folder with --data");
  return lock;
}

Result<std::unique_ptr<BlobStore>> open_blobs(const std::filesystem::path& data, const StoreOptions& options,
                                              std::shared_ptr<const DiskRoom> room) {
  if (blobs_in_files(options.blobs)) return FileBlobs::open(data, std::move(room));
  VACUFORM_TRY(address, s3_address(options.blobs));
  VACUFORM_TRY(credentials, s3_credentials(options.blobs_credentials));
  S3Options s3;
  s3.clock = options.clock;
  s3.alone = options.database.empty();
  s3.going = options.going;
  return std::make_unique<S3Blobs>(data, std::move(room), std::move(address), std::move(credentials),
                                   std::move(s3));
}

}  // namespace vacuform
