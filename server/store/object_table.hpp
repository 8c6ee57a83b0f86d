// The rows of objects in an object store. A blob that is written gets an object with a key of its own, so no key is ever
// written again: a late deletion cannot hit bytes that were stored since, and nothing is written on a condition.
//
// A row is there before its object. It is "uploading" until all bytes are stored, then "live"; a blob has at most one live
// object. When nobody wants it, or its bytes never came, it is "deleting": nothing new refers to it, readers under way
// go on, and after a time of grace the object is deleted, and then the row.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "api/base/clock.hpp"
#include "api/base/error.hpp"

namespace vacuform {

struct StoredObject {
  std::string sha256, generation;  // random, so that a restored database repeats none
  std::uint64_t bytes = 0;

  std::string key() const { return sha256 + "." + generation; }
};

// From any thread. Errors: those of the database.
class ObjectTable {
 public:
  virtual ~ObjectTable() = default;
  virtual Result<std::optional<StoredObject>> live_object(const std::string& sha256) = 0;
  virtual Result<void> add_uploading(const StoredObject& object) = 0;
  // Makes it live, and marks the one that was.
  virtual Result<void> object_arrived(const StoredObject& object) = 0;
  virtual Result<void> mark_for_deletion(const StoredObject& object) = 0;
  // The live object of a blob that no other row names. A row that begins to name it comes before this or finds it
  // marked.
  virtual Result<void> mark_if_unnamed(const std::string& sha256) = 0;
  // All that have been uploading for a time, or have been live for it without another row that names them.
  virtual Result<void> mark_unnamed(Millis age) = 0;
  // Those that were marked up to a time, the oldest first.
  virtual Result<std::vector<StoredObject>> marked_until(Millis time, int limit) = 0;
  virtual Result<void> forget(const StoredObject& object) = 0;
  // The keys of all rows of blobs whose hashes are from `first` to `last`.
  virtual Result<std::set<std::string>> keys_between(const std::string& first, const std::string& last) = 0;

  // The number that the bucket and the rows share, and whether any row names a blob. None: there is no bucket yet.
  struct Bucket {
    std::optional<std::int64_t> number;
    bool named_blobs = false, objects = false;
  };
  virtual Result<Bucket> bucket() = 0;
  virtual Result<void> remember_bucket(std::int64_t number) = 0;
};

}  // namespace vacuform
