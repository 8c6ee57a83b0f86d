// Where the bytes of files are stored, named by their SHA-256. A blob never changes. Which blobs are wanted is in the
// rows of the store: bytes are stored first, then the row that names them commits, so that no transaction waits for
// bytes. A Pin covers the time in between.
//
// An upload is written to a local file while it arrives and hashed meanwhile, so memory does not grow with its size.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/byte_source.hpp"
#include "api/base/file.hpp"
#include "api/base/sha256.hpp"
#include "server/store/disk_room.hpp"
#include "server/store/orphans.hpp"

namespace vacuform {

struct Blob {
  std::string sha256;  // 64 lower-case hexadecimal digits
  std::uint64_t bytes = 0;
};

// A local file that becomes a blob. It is deleted with this object unless it was stored. One thread at a time.
class Upload {
 public:
  Upload(File file, std::filesystem::path path, std::shared_ptr<const DiskRoom> room, Use use)
      : file_(std::move(file)), path_(std::move(path)), room_(std::move(room)), use_(use) {}
  // Takes over a complete file that is already flushed.
  static Upload of_file(std::filesystem::path path, Blob blob);
  Upload(Upload&& other) noexcept;
  Upload& operator=(Upload&&) = delete;
  ~Upload();

  // Errors: disk_full, if too little space would stay free on the disk for this use.
  Result<void> write(std::string_view bytes);
  std::uint64_t bytes() const { return blob_.bytes; }
  const File& file() const { return file_; }  // the written bytes, for reading
  const std::filesystem::path& path() const { return path_; }
  // Fixes the hash; no writes afterwards.
  const Blob& digest();
  // Returns when the bytes are on the disk. Errors: disk_full, unavailable.
  Result<void> flush();
  // Gives the file its final name on the same disk. The caller flushes the folder. Errors: disk_full, unavailable.
  Result<void> move_to(const std::filesystem::path& path);

 private:
  File file_;
  std::filesystem::path path_;  // empty after the file has moved
  std::shared_ptr<const DiskRoom> room_;
  Use use_;
  Sha256 hash_;
  Blob blob_;
  bool flushed_ = false;
};

// The bytes of one blob, which stay readable if it is deleted meanwhile. From any thread.
class BlobReader : public ByteSource {
 public:
  // Called if the bytes are not the expected ones: the next open() checks them again.
  virtual void invalidate() const {}
};

class BlobPins;

// Keeps a blob from being deleted while this object exists. Movable, not copyable.
class Pin {
 public:
  Pin() = default;
  Pin(std::shared_ptr<BlobPins> pins, std::string sha256)
      : pins_(std::move(pins)), sha256_(std::move(sha256)) {}
  Pin(Pin&&) noexcept = default;
  Pin& operator=(Pin&& other) noexcept;
  ~Pin() { release(); }
  void release();

 private:
  std::shared_ptr<BlobPins> pins_;
  std::string sha256_;
};

// Who may touch a blob: any number of pins, or one deletion. From any thread.
class BlobPins : public std::enable_shared_from_this<BlobPins> {
 public:
  // Waits while a deletion of the blob is under way, which lasts one look at the rows and one change of a name.
  Pin pin(const std::string& sha256);
  // Begins a deletion; false if the blob is pinned, or is being deleted. After true, call deleted().
  bool begin_deletion(const std::string& sha256);
  void deleted(const std::string& sha256);

 private:
  friend class Pin;
  void unpin(const std::string& sha256);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, int> pinned_;
  std::set<std::string> deleting_;
};

class ObjectTable;

// From any thread.
class BlobStore {
 public:
  // Whether a row names the blob.
  using Named = std::function<Result<bool>(const std::string& sha256)>;

  virtual ~BlobStore() = default;
  // Called once before anything else, when the rows can be read and written. Errors: unavailable; corrupt_file: the blobs
  // of these rows are somewhere else; bad_usage.
  virtual Result<void> begin(ObjectTable& objects) = 0;
  // Whether another server may delete a blob, as the rows of object_table.hpp say.
  virtual bool shared() const { return false; }
  // Starts a local file. Errors: disk_full, unavailable.
  virtual Result<Upload> upload(Use use = Use::submission) = 0;
  // A new name for a local file; a file left there is deleted at the next start.
  virtual std::filesystem::path temporary_path() const = 0;
  // Stores the bytes. When this returns they survive a power cut, and nothing deletes them before the pin is released;
  // by then a row must name them. Bytes that are stored already cost no flush; a damaged blob is repaired. Errors:
  // disk_full, unavailable.
  virtual Result<Pin> put(Upload& upload) = 0;
  // Of a blob that a row should name already: look for that row while the pin exists.
  virtual Pin pin(const std::string& sha256) = 0;
  // Has read the whole blob since it was last written and within the last hour, and found its hash to be right. Errors:
  // not_found; gone: the bytes have changed, which is logged.
  virtual Result<std::unique_ptr<BlobReader>> open(const std::string& sha256) = 0;
  // Copies a blob into a folder of files named like FileBlobs, and checks its bytes in any case. Errors: not_found, gone,
  // unavailable (the folder's disk is full).
  virtual Result<void> copy(const std::string& sha256, const std::filesystem::path& blobs) = 0;
  // Deletes the blob unless it is named, which is asked while nobody can pin it. If it is pinned, or cannot be deleted,
  // collect_again() tries again; the latter is logged.
  virtual void collect(const std::string& sha256, const Named& named) = 0;
  virtual void collect_again(const Named& named) = 0;
  // Whether the blob is there and, if `read`, whether its bytes have its hash, whatever is known of them. `going` is told
  // the bytes read since the last call. Errors: not_found, gone, unavailable, cancelled.
  using CheckGoing = std::function<bool(std::uint64_t bytes)>;
  virtual Result<void> check(const std::string& sha256, bool read, const CheckGoing& going) = 0;
  // What no row names, as Store promises: few old ones go into quarantine, others are counted. Files that were in
  // quarantine for so many days are deleted. Only before anything is put. Errors: unavailable.
  struct Unnamed {
    std::int64_t files = 0, bytes = 0;
    std::vector<std::string> hashes = {};  // of unnamed() alone
  };
  // Of so many blobs, how many without a row a crash may leave. More are those of rows that are lost, or older than the
  // files.
  static bool left_by_a_crash(std::size_t unnamed, std::size_t all) {
    return (unnamed <= 20 && 2 * unnamed <= all) || 100 * unnamed <= all;
  }
  virtual Result<Unnamed> sweep(const Named& named, int quarantine_days) = 0;
  // The same without moving anything; from any thread at any time.
  virtual Result<Unnamed> unnamed(const Named&) { return Unnamed(); }
  // Moves a blob out of the way: into quarantine, where a person finds it. Errors: unavailable, bad_usage (an object store).
  virtual Result<void> set_in_quarantine(const std::string& sha256) = 0;
  // As Store::orphans().
  virtual Result<OrphanReport> orphans(const OrphanSearch& search, const std::function<bool()>& going);
};

}  // namespace vacuform
