// Blobs as objects of an object store that speaks S3: PREFIX/<sha256>.<generation>. Uploads are written to DATA/incoming
// while they arrive, and sent when they are complete. Which object has the bytes of a blob is in the rows of
// object_table.hpp; the bucket is never listed to find that out.
//
// Memory: a blob up to 1 MiB is read whole, with one request. A larger one is read 4 MiB at a time, with one such piece
// for each reader.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "api/base/clock.hpp"
#include "server/store/blob_store.hpp"
#include "server/store/blobs/s3/s3_client.hpp"
#include "server/store/incoming.hpp"
#include "server/store/object_table.hpp"

namespace vacuform {

struct S3Options {
  Clock clock = wall_clock;
  // From marking an object to deleting it. No download takes more than an hour, and the clocks of two servers may
  // differ by one.
  Millis grace = 3 * 3'600'000;
  // No other server uses the rows. Otherwise an object that no row names may be that of a request to another server,
  // unless it is older than any request.
  bool alone = true;
  std::uint64_t parts_above = 100 << 20;  // larger blobs are sent in parts
  std::uint64_t part = 64 << 20;          // of that size, or larger for the 10,000 parts that S3 allows
  std::chrono::milliseconds trust = std::chrono::hours(1);  // in bytes that were found to be right
  std::function<bool()> going = {};                         // as in StoreOptions
};

// Objects whose bytes were verified within the last `trust`, by their entity tags. From any thread.
class CheckedObjects {
 public:
  explicit CheckedObjects(std::chrono::milliseconds trust) : trust_(trust) {}
  bool good(const std::string& key, const std::string& etag) const;
  void add(const std::string& key, const std::string& etag);
  void forget(const std::string& key);

 private:
  struct Good {
    std::string etag;
    std::chrono::steady_clock::time_point until;
  };
  const std::chrono::milliseconds trust_;
  mutable std::mutex mutex_;
  std::map<std::string, Good> good_;  // by key; cleared when it is too large
};

class S3Blobs : public BlobStore {
 public:
  S3Blobs(const std::filesystem::path& data, std::shared_ptr<const DiskRoom> room, S3Address address,
          S3Credentials credentials, S3Options options = {})
      : options_(std::move(options)),
        incoming_(data, std::move(room)),
        client_(std::make_shared<S3Client>(std::move(address), std::move(credentials), options_.going)),
        checked_(std::make_shared<CheckedObjects>(options_.trust)) {}

  Result<void> begin(ObjectTable& objects) override;
  bool shared() const override { return true; }
  Result<Upload> upload(Use use = Use::submission) override { return incoming_.upload(use); }
  std::filesystem::path temporary_path() const override { return incoming_.temporary_path(); }
  Result<Pin> put(Upload& upload) override;
  Pin pin(const std::string& sha256) override { return pins_->pin(sha256); }
  Result<std::unique_ptr<BlobReader>> open(const std::string& sha256) override;
  Result<void> copy(const std::string& sha256, const std::filesystem::path& blobs) override;
  // Condemns the object; collect_again() deletes it after the time of grace.
  void collect(const std::string& sha256, const Named& named) override;
  void collect_again(const Named& named) override;
  Result<void> check(const std::string& sha256, bool read, const CheckGoing& going) override;
  // Condemns the objects of blobs that no row names, if they are few.
  Result<Unnamed> sweep(const Named&, int) override;
  Result<void> set_in_quarantine(const std::string& sha256) override;
  Result<OrphanReport> orphans(const OrphanSearch& search, const std::function<bool()>& going) override;

 private:
  Result<void> match_bucket();
  Result<std::unique_ptr<BlobReader>> reader_of(const StoredObject& object);
  Result<std::string> read_small(const StoredObject& object);
  // Reads a large object whole, unless it is known. Gives its entity tag. Errors: gone.
  Result<std::string> verified(const StoredObject& object);
  Result<void> send(const StoredObject& object, const std::filesystem::path& file);
  Result<void> mark_if_unwanted(const std::string& sha256, const Named& named);
  Result<std::string> read_whole(const StoredObject& object, const std::string& etag,
                                 const CheckGoing& going);
  void sweep_again();
  void delete_marked();

  const S3Options options_;
  const Incoming incoming_;
  const std::shared_ptr<S3Client> client_;  // shared with the readers
  const std::shared_ptr<CheckedObjects> checked_;
  const std::shared_ptr<BlobPins> pins_ = std::make_shared<BlobPins>();
  ObjectTable* objects_ = nullptr;
  std::mutex mutex_;
  std::set<std::string> later_;  // blobs to collect again
  std::chrono::steady_clock::time_point no_deletion_until_{};
  Millis swept_ = 0;  // when mark_unnamed() was called last
};

}  // namespace vacuform
