// What the store knows of an upload that arrives in pieces (sealed_file.hpp): whose it is, what it will be, until when
// it is kept, and, once it is whole, its blob, which jobs and scans may then share.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/base/clock.hpp"
#include "api/base/error.hpp"
#include "server/store/blob_store.hpp"

namespace vacuform {

struct StoredUpload {
  std::string id;  // 32 hexadecimal digits
  std::string owner;
  std::string input;      // one of input_kinds
  std::string extension;  // as of an Input
  std::string key;        // of the file and its pieces; empty once it is whole
  std::uint64_t length = 0;
  Millis created = 0, expires = 0;
  std::optional<Blob> blob = {};  // once it is whole
  // What add_piece() kept: how many bytes of the file have come, in how many pieces.
  std::uint64_t received = 0;
  int pieces = 0;
};

// Of one owner, whole or not, until they expire or are given up.
inline constexpr int most_uploads = 32;
inline constexpr std::uint64_t most_upload_bytes = 8ull << 30;  // as announced

class UploadTable {
 public:
  virtual ~UploadTable() = default;
  // Errors: busy, when the owner would have more than the bounds above.
  virtual Result<void> add_upload(const StoredUpload& upload) = 0;
  // Errors: not_found; gone, for a week after it has expired.
  virtual Result<StoredUpload> find_upload(const std::string& id) = 0;
  // Keeps the blob. Errors: as above.
  virtual Result<StoredUpload> finish_upload(const std::string& id, Upload file) = 0;
  virtual Result<void> remove_upload(const std::string& id) = 0;
  // For an upload that another server may continue: keeps what has come since piece `number` - 1; `received` bytes of the
  // file have come then. The bytes of a piece are for the caller to read. Errors: locked: another server has kept this
  // piece; those of find_upload().
  virtual Result<void> add_piece(const std::string& id, int number, Upload piece, std::uint64_t received) = 0;
  // In their order, until the upload is whole.
  virtual Result<std::vector<Blob>> pieces(const std::string& id) = 0;
  // Forgets those that have expired since the last call; gives their ids.
  virtual Result<std::vector<std::string>> expire_uploads() = 0;
};

}  // namespace vacuform
