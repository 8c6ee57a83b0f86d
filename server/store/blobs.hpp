// Files named by the hash of their bytes: DATA/blobs/ab/<sha256>. A blob never changes; the store records which rows
// name it.
//
// An upload is written to DATA/incoming while it arrives and hashed meanwhile, so memory does not grow with its size.
// seal() flushes it; keep() gives it its final name and flushes the folder, after which it survives a power cut. Bytes
// that are already stored need no flush, and sending a damaged file again repairs it. Files without keep() disappear
// with the Upload, and files that a crash left in incoming are deleted at the next start.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "api/base/file.hpp"
#include "api/base/secrets.hpp"
#include "api/base/sha256.hpp"
#include "server/store/disk_room.hpp"

namespace vacuform {

struct Blob {
  std::string sha256;  // 64 lower-case hexadecimal digits
  std::uint64_t bytes = 0;
};

class Upload {
 public:
  Upload(Upload&& other) noexcept;
  Upload& operator=(Upload&&) = delete;
  ~Upload();

  // Errors: disk_full, if too little space would stay free on the disk for this use.
  Result<void> write(std::string_view bytes);
  std::uint64_t bytes() const { return blob_.bytes; }
  const File& file() const { return file_; }  // the written bytes, for reading
  // Fixes the hash; no writes afterwards.
  const Blob& digest();

 private:
  friend class Blobs;
  Upload(File file, std::filesystem::path path, std::shared_ptr<const DiskRoom> room, Use use)
      : file_(std::move(file)), path_(std::move(path)), room_(std::move(room)), use_(use) {}

  File file_;
  std::filesystem::path path_;  // empty after the file has moved
  std::shared_ptr<const DiskRoom> room_;
  Use use_;
  Result<void> flush();

  Sha256 hash_;
  Blob blob_;
  bool flushed_ = false;
  bool known_ = false;  // at seal() its bytes were stored already, complete and under their name
};

// Files whose bytes were verified within the last `trust`, identified by data that changes with every write. From any
// thread.
class CheckedFiles {
 public:
  explicit CheckedFiles(std::chrono::milliseconds trust) : trust_(trust) {}
  // Errors: gone: the bytes do not have that hash. Reads the whole file unless it is known.
  Result<void> check(const File& file, const std::string& sha256);

 private:
  struct Seen {
    std::uint64_t inode, bytes;
    std::int64_t modified_s, modified_ns;
    bool operator==(const Seen&) const = default;
  };
  struct Good {
    Seen seen;
    std::chrono::steady_clock::time_point until;
  };
  const std::chrono::milliseconds trust_;
  std::mutex mutex_;
  std::map<std::string, Good> good_;  // by hash; cleared when it is too large
};

class Blobs {
 public:
  // Creates the folders; deletes the files of unfinished uploads. `trust` is the time for which a verified file counts
  // as intact, unless it was written to. Errors: unavailable.
  static Result<Blobs> open(const std::filesystem::path& data,
                            std::chrono::milliseconds trust = std::chrono::hours(1),
                            std::shared_ptr<const DiskRoom> room = nullptr);

  // Errors: disk_full, unavailable.
  Result<Upload> upload(Use use = Use::submission) const;
  // Takes over a complete file on the same disk that is already flushed.
  static Upload adopt(std::filesystem::path path, Blob blob);
  std::filesystem::path temporary_path() const { return incoming_ / random_hex(16); }
  // Fixes the hash, and flushes the bytes to the disk unless they are already stored. The slow part of keep(), without
  // a lock.
  Result<Blob> seal(Upload& upload) const;
  // Gives a sealed upload its final name. Keeping the same bytes, or the same upload, twice leaves one file.
  Result<void> keep(Upload& upload) const;
  // The file, whose bytes are checked if it was written to, or if this process has not read it completely within the
  // last hour. Errors: not_found; gone: the bytes have changed.
  Result<File> read(const std::string& sha256) const;
  // The same into a file of that hash in another folder: a hard link, or a copy if that folder is on another disk. The
  // bytes are checked in any case.
  Result<void> copy(const std::string& sha256, const std::filesystem::path& blobs) const;
  // Moves the file away at once, which is quick; delete_aside() then frees its space, which is slow for a large file.
  // Files left by a crash in between are deleted at the next start. Returns an empty path if there is no such file.
  // Errors: disk_full, unavailable.
  Result<std::filesystem::path> set_aside(const std::string& sha256) const;
  static Result<void> delete_aside(const std::filesystem::path& file);
  // Deletes every blob for which `wanted` is false.
  Result<void> sweep(const std::function<bool(const std::string& sha256)>& wanted) const;

 private:
  Blobs(const std::filesystem::path& data, std::chrono::milliseconds trust,
        std::shared_ptr<const DiskRoom> room)
      : blobs_(data / "blobs"),
        incoming_(data / "incoming"),
        room_(std::move(room)),
        checked_(std::make_shared<CheckedFiles>(trust)) {}
  std::filesystem::path place(const std::string& sha256) const {
    return blobs_ / sha256.substr(0, 2) / sha256;
  }

  std::filesystem::path blobs_, incoming_;
  std::shared_ptr<const DiskRoom> room_;
  std::shared_ptr<CheckedFiles> checked_;
};

}  // namespace vacuform
