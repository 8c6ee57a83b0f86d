// DATA/incoming: the local files of uploads, until their bytes are stored. Files that a crash left there are deleted at
// the next start.
#pragma once

#include <filesystem>
#include <memory>

#include "api/base/secrets.hpp"
#include "server/store/blob_store.hpp"
#include "server/store/disk_room.hpp"

namespace vacuform {

// Deletes a file; one that does not exist is fine. Errors: unavailable.
Result<void> delete_file(const std::filesystem::path& file);

// From any thread.
class Incoming {
 public:
  Incoming(const std::filesystem::path& data, std::shared_ptr<const DiskRoom> room)
      : folder_(data / "incoming"), room_(std::move(room)) {}
  // Makes the folder and empties it. Errors: unavailable.
  Result<void> open() const;
  // Errors: disk_full, unavailable.
  Result<Upload> upload(Use use) const;
  std::filesystem::path temporary_path() const { return folder_ / random_hex(16); }

 private:
  const std::filesystem::path folder_;
  const std::shared_ptr<const DiskRoom> room_;
};

}  // namespace vacuform
