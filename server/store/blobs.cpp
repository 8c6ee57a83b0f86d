#include "server/store/blobs.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "api/base/log.hpp"

namespace vacuform {

namespace fs = std::filesystem;

Upload::Upload(Upload&& other) noexcept
    : file_(std::move(other.file_)),
      path_(std::move(other.path_)),
      room_(std::move(other.room_)),
      use_(other.use_),
      hash_(std::move(other.hash_)),
      blob_(std::move(other.blob_)),
      flushed_(other.flushed_),
      known_(other.known_) {
  other.path_.clear();
}

Upload::~Upload() {
  if (!path_.empty()) ::unlink(path_.c_str());
}

Result<void> Upload::write(std::string_view bytes) {
  if (room_) VACUFORM_CHECK(room_->check(use_, bytes.size()));
  VACUFORM_CHECK(file_.write(bytes));
  hash_.add(bytes);
  blob_.bytes += bytes.size();
  return {};
}

const Blob& Upload::digest() {
  if (blob_.sha256.empty()) blob_.sha256 = hash_.hex();
  return blob_;
}

Result<void> Upload::flush() {
  if (!flushed_) VACUFORM_CHECK(file_.sync());
  flushed_ = true;
  return {};
}

Result<Blobs> Blobs::open(const fs::path& data, std::chrono::milliseconds trust,
                          std::shared_ptr<const DiskRoom> room) {
  Blobs blobs(data, trust, std::move(room));
  VACUFORM_CHECK(make_directory(blobs.blobs_));
  VACUFORM_CHECK(make_directory(blobs.incoming_));
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(blobs.incoming_, error))
    if (const auto deleted = delete_aside(entry.path()); !deleted)
      log_event("file-not-deleted", {{"folder", "incoming"}, {"problem", deleted.error().what}});
  return blobs;
}

Result<Upload> Blobs::upload(Use use) const {
  if (room_) VACUFORM_CHECK(room_->check(use));
  fs::path path = temporary_path();
  VACUFORM_TRY(file, File::create(path));
  return Upload(std::move(file), std::move(path), room_, use);
}

Upload Blobs::adopt(fs::path path, Blob blob) {
  Upload upload({}, std::move(path), nullptr, Use::submission);
  upload.blob_ = std::move(blob);
  upload.flushed_ = true;
  return upload;
}

Result<Blob> Blobs::seal(Upload& upload) const {
  const Blob& blob = upload.digest();
  upload.known_ = upload.known_ || read(blob.sha256).has_value();
  if (!upload.known_) VACUFORM_CHECK(upload.flush());
  return blob;
}

Result<void> Blobs::keep(Upload& upload) const {
  const fs::path path = place(upload.digest().sha256);
  std::error_code error;
  // The upload's own file goes with it, or it was kept by a transaction that is tried again.
  if ((upload.known_ || upload.path_.empty()) && fs::exists(path, error)) return {};
  VACUFORM_CHECK(upload.flush());  // already done, unless the known file was deleted meanwhile
  const bool new_folder = !fs::exists(path.parent_path(), error);
  VACUFORM_CHECK(make_directory(path.parent_path()));
  if (new_folder) VACUFORM_CHECK(sync_directory(blobs_));
  if (std::rename(upload.path_.c_str(), path.c_str()) != 0)
    return fail(errno == ENOSPC || errno == EDQUOT ? Code::disk_full : Code::unavailable,
                "keeping an upload failed: " + std::generic_category().message(errno), {},
                "check that the server may write to its data folder, and that its disk has room");
  ::unlink(upload.path_.c_str());  // still there when both names are of one file
  upload.path_.clear();
  return sync_directory(path.parent_path());
}

Result<void> CheckedFiles::check(const File& file, const std::string& sha256) {
  struct stat status {};
  if (::fstat(file.descriptor(), &status) != 0)
    return fail(Code::unavailable, "a stored file cannot be read", sha256);
  const Seen now{status.st_ino, static_cast<std::uint64_t>(status.st_size), status.st_mtim.tv_sec,
                 status.st_mtim.tv_nsec};
  const auto time = std::chrono::steady_clock::now();
  {
    const std::lock_guard hold(mutex_);
    const auto known = good_.find(sha256);
    if (known != good_.end() && known->second.seen == now && time < known->second.until) return {};
  }
  Sha256 hash;
  std::vector<char> piece(256 * 1024);
  for (std::uint64_t at = 0;;) {
    VACUFORM_TRY(n, file.read_at(at, piece));
    if (n == 0) break;
    hash.add({piece.data(), n});
    at += n;
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

Result<File> Blobs::read(const std::string& sha256) const {
  VACUFORM_TRY(file, File::open(place(sha256)));
  VACUFORM_CHECK(checked_->check(file, sha256));
  return file;
}

Result<void> Blobs::copy(const std::string& sha256, const fs::path& blobs) const {
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

Result<fs::path> Blobs::set_aside(const std::string& sha256) const {
  fs::path aside = temporary_path();
  if (::rename(place(sha256).c_str(), aside.c_str()) == 0) return aside;
  if (errno == ENOENT) return fs::path();
  VACUFORM_CHECK(delete_aside(place(sha256)));  // a full disk may have no room for another name
  return fs::path();
}

Result<void> Blobs::delete_aside(const fs::path& file) {
  if (::unlink(file.c_str()) == 0 || errno == ENOENT) return {};
  return fail(Code::unavailable, "deleting a file failed: " + std::generic_category().message(errno),
              file.filename().string(), "check that the server may write to its data folder");
}

Result<void> Blobs::sweep(const std::function<bool(const std::string&)>& wanted) const {
  std::error_code error;
  std::vector<fs::path> unwanted;
  for (const auto& entry : fs::recursive_directory_iterator(blobs_, error))
    if (!entry.is_directory(error) && !wanted(entry.path().filename().string()))
      unwanted.push_back(entry.path());
  if (error) return fail(Code::unavailable, "reading the blobs' folder failed: " + error.message(), "blobs");
  for (const auto& path : unwanted)
    if (const auto deleted = delete_aside(path); !deleted)
      log_event("file-not-deleted", {{"blob", path.filename().string()}, {"problem", deleted.error().what}});
  return {};
}

}  // namespace vacuform
