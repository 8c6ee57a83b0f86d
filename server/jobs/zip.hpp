// All artifacts of a job in one zip file, the same bytes for the same artifacts. It is never on the disk: the
// artifacts are stored in it as they are, so its length, and what stands at each place of it, is known
// beforehand, and it is made while it is sent. What that needs in advance is the CRC-32 of each artifact,
// which is remembered.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>

#include "server/messages/message.hpp"
#include "server/store/store.hpp"

namespace vacuform {

// Identifies the zip of these artifacts: the hash of their names and hashes, without making it.
std::string zip_etag(const Job& job);

class Zip : public http::Source {
 public:
  struct Entry {
    std::string name;
    Blob blob;
    std::uint32_t crc = 0;
  };
  using Open = std::function<Result<std::unique_ptr<BlobReader>>(const Blob&)>;

  // `open` gives the bytes of an entry when its turn comes. With its zip64 records where a place or the
  // length needs more than 32 bits; an entry has less than 4 GiB.
  Zip(std::vector<Entry> entries, Open open);

  std::uint64_t bytes() const { return pieces_.back().end; }
  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const override;

 private:
  struct Piece {
    std::uint64_t begin = 0, end = 0;
    std::string text;              // what stands there,
    const Entry* entry = nullptr;  // or whose bytes
  };
  void add(std::string text);
  Result<const BlobReader*> opened(const Entry* entry) const;

  const std::vector<Entry> entries_;
  const Open open_;
  std::vector<Piece> pieces_;  // in their order, without gaps
  mutable const Entry* open_entry_ = nullptr;
  mutable std::unique_ptr<BlobReader> reader_;  // of open_entry_
};

// The CRC-32 of blobs by their hashes, computed once by this process. From any thread.
class Checksums {
 public:
  // In the order of the job's artifacts. Reads those that are not known yet, one caller at a time. Errors:
  // those of the store.
  Result<std::vector<std::uint32_t>> of(Store& store, const Job& job);

 private:
  std::optional<std::vector<std::uint32_t>> known(const Job& job);

  std::mutex mutex_;  // of what follows
  std::map<std::string, std::uint32_t> crc_;
  std::mutex reading_;  // held by the one that reads
};

}  // namespace vacuform
