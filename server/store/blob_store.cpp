#include "server/store/blob_store.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

namespace vacuform {

Upload::Upload(Upload&& other) noexcept
    : file_(std::move(other.file_)),
      path_(std::move(other.path_)),
      room_(std::move(other.room_)),
      use_(other.use_),
      hash_(std::move(other.hash_)),
      blob_(std::move(other.blob_)),
      flushed_(other.flushed_) {
  other.path_.clear();
}

Upload::~Upload() {
  if (!path_.empty()) ::unlink(path_.c_str());
}

Upload Upload::of_file(std::filesystem::path path, Blob blob) {
  Upload upload({}, std::move(path), nullptr, Use::submission);
  upload.blob_ = std::move(blob);
  upload.flushed_ = true;
  return upload;
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

Result<void> Upload::move_to(const std::filesystem::path& path) {
  if (std::rename(path_.c_str(), path.c_str()) != 0)
    return fail(errno == ENOSPC || errno == EDQUOT ? Code::disk_full : Code::unavailable,
                "keeping an upload failed: " + std::generic_category().message(errno), {},
                "check that the server may write to its data folder, and that its disk has room");
  ::unlink(path_.c_str());  // still there when both names are of one file
  path_.clear();
  return {};
}

Pin& Pin::operator=(Pin&& other) noexcept {
  release();
  pins_ = std::move(other.pins_);
  sha256_ = std::move(other.sha256_);
  return *this;
}

void Pin::release() {
  if (const auto pins = std::move(pins_)) pins->unpin(sha256_);
}

Pin BlobPins::pin(const std::string& sha256) {
  std::unique_lock hold(mutex_);
  changed_.wait(hold, [&] { return deleting_.count(sha256) == 0; });
  ++pinned_[sha256];
  return {shared_from_this(), sha256};
}

void BlobPins::unpin(const std::string& sha256) {
  const std::lock_guard hold(mutex_);
  const auto found = pinned_.find(sha256);
  if (--found->second == 0) pinned_.erase(found);
}

bool BlobPins::begin_deletion(const std::string& sha256) {
  const std::lock_guard hold(mutex_);
  return pinned_.count(sha256) == 0 && deleting_.insert(sha256).second;
}

void BlobPins::deleted(const std::string& sha256) {
  const std::lock_guard hold(mutex_);
  deleting_.erase(sha256);
  changed_.notify_all();
}

}  // namespace vacuform
