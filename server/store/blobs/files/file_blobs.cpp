#include "server/store/blobs/files/file_blobs.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <vector>

#include "api/base/log.hpp"
#include "server/store/object_table.hpp"

namespace vacuform {

namespace fs = std::filesystem;

namespace {

class FileReader : public BlobReader {
 public:
  explicit FileReader(File file) : file_(std::move(file)) {}
  Result<std::uint64_t> size() const override { return file_.size(); }
  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const override {
    return file_.read_at(offset, into);
  }
  void invalidate() const override { file_.invalidate(); }

 private:
  File file_;
};

}  // namespace

std::unique_ptr<BlobReader> reader_of(File file) { return std::make_unique<FileReader>(std::move(file)); }

Result<std::unique_ptr<BlobStore>> FileBlobs::open(const fs::path& data, std::shared_ptr<const DiskRoom> room,
                                                   std::chrono::milliseconds trust) {
  std::unique_ptr<FileBlobs> blobs(new FileBlobs(data, std::move(room), trust));
  VACUFORM_CHECK(make_directory(blobs->blobs_));
  VACUFORM_CHECK(blobs->incoming_.open());
  return std::unique_ptr<BlobStore>(std::move(blobs));
}

Result<void> FileBlobs::begin(ObjectTable& objects) {
  VACUFORM_TRY(rows, objects.bucket());
  if (!rows.number) return {};
  return fail(Code::corrupt_file, "the files of the jobs are in an object store", "--blobs",
              "give its address with --blobs, or another data folder with --data");
}

Result<Pin> FileBlobs::put(Upload& upload) {
  const std::string& sha256 = upload.digest().sha256;
  Pin pin = pins_->pin(sha256);
  if (read(sha256)) return pin;
  VACUFORM_CHECK(upload.flush());
  const fs::path path = place(sha256);
  std::error_code error;
  const bool new_folder = !fs::exists(path.parent_path(), error);
  VACUFORM_CHECK(make_directory(path.parent_path()));
  if (new_folder) VACUFORM_CHECK(sync_directory(blobs_));
  VACUFORM_CHECK(upload.move_to(path));
  VACUFORM_CHECK(sync_directory(path.parent_path()));
  return pin;
}

Result<void> CheckedFiles::check(const File& file, const std::string& sha256,
                                 const BlobStore::CheckGoing& going) {
  struct stat status {};
  if (::fstat(file.descriptor(), &status) != 0)
    return fail(Code::unavailable, "a stored file cannot be read", sha256);
  const Seen now{status.st_ino, static_cast<std::uint64_t>(status.st_size), status.st_mtim.tv_sec,
                 status.st_mtim.tv_nsec};
  const auto time = std::chrono::steady_clock::now();
  {
    const std::lock_guard hold(mutex_);
    const auto known = good_.find(sha256);
    if (!going && known != good_.end() && known->second.seen == now && time < known->second.until) return {};
  }
  Sha256 hash;
  std::vector<char> piece(256 * 1024);
  for (std::uint64_t at = 0;;) {
    VACUFORM_TRY(n, file.read_at(at, piece));
    if (n == 0) break;
    hash.add({piece.data(), n});
    at += n;
    if (going && !going(n)) return fail(Code::cancelled, "the check was cancelled");
  }
  if (hash.hex() != sha256) {
    log_event("blob-damaged", {{"blob", sha256}});
    return fail(Code::gone, "a stored file is damaged: its bytes are no longer those that were kept", sha256,
                "restore the server's data from a backup, or send the file again");
  }
  constexpr std::size_t most = 100'000;
  const std::lock_guard hold(mutex_);
  if (good_.size() >= most) good_.clear();
  good_[sha256] = {now, time + trust_};
  return {};
}

Result<File> FileBlobs::read(const std::string& sha256) const {
  VACUFORM_TRY(file, File::open(place(sha256)));
  VACUFORM_CHECK(checked_.check(file, sha256));
  return file;
}

Result<std::unique_ptr<BlobReader>> FileBlobs::open(const std::string& sha256) {
  VACUFORM_TRY(file, read(sha256));
  return reader_of(std::move(file));
}

Result<void> FileBlobs::copy(const std::string& sha256, const fs::path& blobs) {
  VACUFORM_TRY(file, File::open(place(sha256)));
  VACUFORM_CHECK(CheckedFiles(std::chrono::milliseconds(0)).check(file, sha256));
  const fs::path to = blobs / sha256.substr(0, 2) / sha256;
  VACUFORM_CHECK(make_directory(to.parent_path()));
  std::error_code error;
  fs::create_hard_link(place(sha256), to, error);
  if (!error) return sync_directory(to.parent_path());
  if (!fs::copy_file(place(sha256), to, error))
    return fail(Code::unavailable, "copying a stored file failed: " + error.message(), to.string(),
                "check that there is room on the disk");
  File copied(::open(to.c_str(), O_RDWR | O_CLOEXEC));
  VACUFORM_CHECK(CheckedFiles(std::chrono::milliseconds(0)).check(copied, sha256));
  VACUFORM_CHECK(copied.sync());
  return sync_directory(to.parent_path());
}

void FileBlobs::collect(const std::string& sha256, const Named& named, bool logged) {
  if (!pins_->begin_deletion(sha256)) return try_later(sha256, logged);
  const auto used = named(sha256);
  std::optional<Result<fs::path>> aside;
  if (used && !*used) aside = set_aside(sha256);
  pins_->deleted(sha256);
  if (!used) return try_later(sha256, logged);
  if (!aside) return;
  if (*aside) return delete_trash({std::move(**aside), sha256});
  if (!logged) log_event("file-not-deleted", {{"blob", sha256}, {"problem", aside->error().what}});
  try_later(sha256, true);
}

void FileBlobs::try_later(const std::string& sha256, bool logged) {
  const std::lock_guard hold(mutex_);
  later_[sha256] = logged;
}

// Frees the space of a file that was moved aside, which is slow for a large one.
void FileBlobs::delete_trash(Trash trash) {
  const auto deleted = trash.file.empty() ? Result<void>() : delete_file(trash.file);
  if (deleted) return;
  if (!trash.sha256.empty())
    log_event("file-not-deleted", {{"blob", trash.sha256}, {"problem", deleted.error().what}});
  trash.sha256.clear();
  const std::lock_guard hold(mutex_);
  trash_.push_back(std::move(trash));
}

void FileBlobs::collect_again(const Named& named) {
  std::vector<Trash> trash;
  std::map<std::string, bool> later;
  {
    const std::lock_guard hold(mutex_);
    trash.swap(trash_);
    later.swap(later_);
  }
  for (Trash& item : trash) delete_trash(std::move(item));
  for (const auto& [sha256, logged] : later) collect(sha256, named, logged);
}

// Quick, unlike the deletion of a large file. Files left by a crash in between are deleted at the next start. Gives an
// empty path if there is no such file.
Result<fs::path> FileBlobs::set_aside(const std::string& sha256) const {
  fs::path aside = temporary_path();
  if (::rename(place(sha256).c_str(), aside.c_str()) == 0) return aside;
  if (errno == ENOENT) return fs::path();
  VACUFORM_CHECK(delete_file(place(sha256)));  // a full disk may have no room for another name
  return fs::path();
}

Result<void> FileBlobs::check(const std::string& sha256, bool read, const CheckGoing& going) {
  VACUFORM_TRY(file, File::open(place(sha256)));
  if (!read) return {};
  return checked_.check(file, sha256, going);
}

Result<std::vector<FileBlobs::Found>> FileBlobs::find_unnamed(const Named& named, std::size_t& all) const {
  constexpr auto young = std::chrono::hours(24);
  std::error_code error;
  std::vector<Found> found;
  const auto now = fs::file_time_type::clock::now();
  for (const auto& entry : fs::recursive_directory_iterator(blobs_, error)) {
    std::error_code gone;
    if (entry.is_directory(gone)) continue;
    ++all;
    if (named(entry.path().filename().string()).value_or(true)) continue;
    const auto bytes = entry.file_size(gone);
    const auto written = entry.last_write_time(gone);
    if (!gone) found.push_back({entry.path(), bytes, written > now - young});
  }
  if (error) return fail(Code::unavailable, "reading the blobs' folder failed: " + error.message(), "blobs");
  return found;
}

Result<BlobStore::Unnamed> FileBlobs::unnamed(const Named& named) {
  std::size_t all = 0;
  VACUFORM_TRY(found, find_unnamed(named, all));
  Unnamed sum;
  for (const Found& file : found) {
    ++sum.files, sum.bytes += static_cast<std::int64_t>(file.bytes);
    sum.hashes.push_back(file.path.filename().string());
  }
  return sum;
}

Result<BlobStore::Unnamed> FileBlobs::sweep(const Named& named, int quarantine_days) {
  empty_quarantine(quarantine_days);
  std::size_t all = 0;
  VACUFORM_TRY(found, find_unnamed(named, all));
  const bool move = left_by_a_crash(found.size(), all);
  Unnamed left, moved;
  for (const Found& file : found) {
    const std::string name = file.path.filename().string();
    const auto done = move && !file.young ? set_in_quarantine(name) : Result<void>();
    if (!done) log_event("file-not-moved", {{"blob", name}, {"problem", done.error().what}});
    Unnamed& sum = move && !file.young && done ? moved : left;
    ++sum.files, sum.bytes += static_cast<std::int64_t>(file.bytes);
  }
  if (!found.empty())
    log_event("files-without-job", {{"files", left.files},
                                    {"bytes", left.bytes},
                                    {"quarantined_files", moved.files},
                                    {"quarantined_bytes", moved.bytes},
                                    {"too_many_to_move", !move}});
  return left;
}

// The days in quarantine count from the time of the file.
Result<void> FileBlobs::set_in_quarantine(const std::string& sha256) {
  VACUFORM_CHECK(make_directory(quarantine_));
  std::error_code error;
  fs::last_write_time(place(sha256), fs::file_time_type::clock::now(), error);
  fs::rename(place(sha256), quarantine_ / sha256, error);
  if (error)
    return fail(Code::unavailable, "a file cannot be moved into quarantine: " + error.message(), sha256,
                "check that the server may write to its data folder");
  return sync_directory(quarantine_);
}

void FileBlobs::empty_quarantine(int days) const {
  std::error_code error;
  Unnamed deleted;
  const auto until = fs::file_time_type::clock::now() - std::chrono::hours(24 * days);
  if (!fs::exists(quarantine_, error)) return;
  for (const auto& entry : fs::directory_iterator(quarantine_, error)) {
    std::error_code gone;
    const auto bytes = entry.file_size(gone);
    if (gone || entry.last_write_time(gone) > until || gone || !delete_file(entry.path())) continue;
    ++deleted.files, deleted.bytes += static_cast<std::int64_t>(bytes);
  }
  if (deleted.files > 0)
    log_event("quarantine-emptied", {{"files", deleted.files}, {"bytes", deleted.bytes}});
}

}  // namespace vacuform
