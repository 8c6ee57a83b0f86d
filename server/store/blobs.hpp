// Files under the hash of their bytes: DATA/blobs/ab/<sha256>. A blob never changes; who names it is the
// store's affair.
//
// An upload is written to DATA/incoming while it arrives and hashed on the way, so memory does not grow with
// its size. seal() flushes it; keep() gives it its final name and flushes the folder, after which it survives
// a power cut. What is never kept disappears with the Upload, and what a crash left in incoming is deleted at
// the next start.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "api/sha256.hpp"
#include "server/file.hpp"
#include "server/secrets.hpp"

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

  Result<void> write(std::string_view bytes);
  std::uint64_t bytes() const { return blob_.bytes; }
  const File& file() const { return file_; }  // what was written, to be looked at
  // Flushes to the disk and fixes the hash; no writes afterwards.
  Result<Blob> seal();

 private:
  friend class Blobs;
  Upload(File file, std::filesystem::path path) : file_(std::move(file)), path_(std::move(path)) {}

  File file_;
  std::filesystem::path path_;  // empty when the file has moved on
  Sha256 hash_;
  Blob blob_;
};

class Blobs {
 public:
  // Makes the folders; deletes what unfinished uploads left behind. Errors: unavailable.
  static Result<Blobs> open(const std::filesystem::path& data);

  Result<Upload> upload() const;
  // Takes over a whole file on the same disk that is flushed already.
  Upload adopt(std::filesystem::path path, Blob blob) const;
  std::filesystem::path temporary_path() const { return incoming_ / random_hex(16); }
  // Gives a sealed upload its final name. Keeping the same bytes twice leaves one file.
  Result<void> keep(Upload& upload) const;
  Result<File> read(const std::string& sha256) const;
  // Missing files are no error: a crash may have come between the row's end and the file's.
  void remove(const std::string& sha256) const;
  // Deletes every blob for which `wanted` is false.
  Result<void> sweep(const std::function<bool(const std::string& sha256)>& wanted) const;

 private:
  explicit Blobs(std::filesystem::path data) : blobs_(data / "blobs"), incoming_(data / "incoming") {}
  std::filesystem::path place(const std::string& sha256) const {
    return blobs_ / sha256.substr(0, 2) / sha256;
  }

  std::filesystem::path blobs_, incoming_;
};

}  // namespace vacuform
