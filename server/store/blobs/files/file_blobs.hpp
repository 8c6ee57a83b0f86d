// Blobs as files: DATA/blobs/ab/<sha256>. Uploads are written to DATA/incoming; put() flushes them, gives them their
// final names on the same disk and flushes the folder. Files that a crash left in incoming are deleted at the next start.
// Blobs without a job go to DATA/quarantine.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "api/base/file.hpp"
#include "server/store/blob_store.hpp"
#include "server/store/incoming.hpp"

namespace vacuform {

// The bytes of an open file.
std::unique_ptr<BlobReader> reader_of(File file);

// Files whose bytes were verified within the last `trust`, identified by data that changes with every write. From any
// thread.
class CheckedFiles {
 public:
  explicit CheckedFiles(std::chrono::milliseconds trust) : trust_(trust) {}
  // Errors: gone: the bytes do not have that hash. Reads the whole file unless it is known, and always with a `going`,
  // which gives cancelled.
  Result<void> check(const File& file, const std::string& sha256, const BlobStore::CheckGoing& going = {});

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

class FileBlobs : public BlobStore {
 public:
  // Creates the folders; deletes the files of unfinished uploads. `trust` is the time for which a verified file counts
  // as intact, unless it was written to. Errors: unavailable.
  static Result<std::unique_ptr<BlobStore>> open(const std::filesystem::path& data,
                                                 std::shared_ptr<const DiskRoom> room = nullptr,
                                                 std::chrono::milliseconds trust = std::chrono::hours(1));
  // The files of a folder without a server: nothing is made or emptied. For check(), copy() and set_in_quarantine().
  static std::unique_ptr<BlobStore> existing(const std::filesystem::path& data) {
    return std::unique_ptr<BlobStore>(new FileBlobs(data, nullptr, std::chrono::milliseconds(0)));
  }

  Result<void> begin(ObjectTable& objects) override;
  Result<Upload> upload(Use use = Use::submission) override { return incoming_.upload(use); }
  std::filesystem::path temporary_path() const override { return incoming_.temporary_path(); }
  Result<Pin> put(Upload& upload) override;
  Pin pin(const std::string& sha256) override { return pins_->pin(sha256); }
  Result<std::unique_ptr<BlobReader>> open(const std::string& sha256) override;
  // A hard link, or a copy if the folder is on another disk.
  Result<void> copy(const std::string& sha256, const std::filesystem::path& blobs) override;
  void collect(const std::string& sha256, const Named& named) override { collect(sha256, named, false); }
  void collect_again(const Named& named) override;
  Result<void> check(const std::string& sha256, bool read, const CheckGoing& going) override;
  Result<Unnamed> sweep(const Named& named, int quarantine_days) override;
  Result<Unnamed> unnamed(const Named& named) override;
  Result<void> set_in_quarantine(const std::string& sha256) override;

 private:
  struct Trash {
    std::filesystem::path file;  // may be empty
    std::string sha256;          // for the log, once; empty: it is there
  };
  FileBlobs(const std::filesystem::path& data, std::shared_ptr<const DiskRoom> room,
            std::chrono::milliseconds trust)
      : blobs_(data / "blobs"),
        quarantine_(data / "quarantine"),
        incoming_(data, std::move(room)),
        checked_(trust) {}
  std::filesystem::path place(const std::string& sha256) const {
    return blobs_ / sha256.substr(0, 2) / sha256;
  }
  Result<File> read(const std::string& sha256) const;
  Result<std::filesystem::path> set_aside(const std::string& sha256) const;
  void delete_trash(Trash trash);
  // `logged`: that it could not be deleted.
  void collect(const std::string& sha256, const Named& named, bool logged);
  void try_later(const std::string& sha256, bool logged);

  struct Found {
    std::filesystem::path path;
    std::uint64_t bytes;
    bool young;
  };
  // All files that no row names, out of `all`.
  Result<std::vector<Found>> find_unnamed(const Named& named, std::size_t& all) const;
  void empty_quarantine(int days) const;

  const std::filesystem::path blobs_, quarantine_;
  const Incoming incoming_;
  const std::shared_ptr<BlobPins> pins_ = std::make_shared<BlobPins>();
  mutable CheckedFiles checked_;
  std::mutex mutex_;
  std::vector<Trash> trash_;           // moved aside and not yet deleted
  std::map<std::string, bool> later_;  // blobs to collect again, and whether that was logged
};

}  // namespace vacuform
