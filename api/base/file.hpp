// File access for the server: an owned descriptor, complete writes, and writes that are on the disk when they return.
// Every file and folder is private to the user that runs the server (0600, 0700).
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "api/base/error.hpp"

namespace vacuform {

// What happens when the disk does not take what it had accepted (EIO of a flush); nothing by default but the error. Linux
// then forgets which bytes are lost, and the next flush succeeds: a service must end, and read what is there when it
// starts again. Set before there are threads.
void when_flush_fails(void (*handler)());
// Calls that handler.
void flush_failed();

class File {
 public:
  File() = default;
  explicit File(int descriptor) : descriptor_(descriptor) {}
  File(File&& other) noexcept : descriptor_(other.descriptor_) { other.descriptor_ = -1; }
  File& operator=(File&& other) noexcept;
  ~File();

  // Makes a new file for writing and reading; refuses one that exists. Errors: disk_full, unavailable (no
  // permission).
  static Result<File> create(const std::filesystem::path& path);
  // Opens a regular file for reading. Errors: not_found, unreadable.
  static Result<File> open(const std::filesystem::path& path);

  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }
  // All bytes or an error (disk_full, unavailable).
  Result<void> write(std::string_view bytes);
  // Bytes from `offset` on, at most the span's size; 0 only at the end of the file. Safe from many threads.
  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const;
  Result<std::uint64_t> size() const;
  // Returns when the bytes are on the disk.
  Result<void> sync();
  // Changes the file's times, so that a reader who caches by time checks the bytes again.
  void invalidate() const;

 private:
  int descriptor_ = -1;
};

// Makes a folder and those above it. Errors: disk_full, unavailable.
Result<void> make_directory(const std::filesystem::path& path);
// Returns when the names in the folder are on the disk: after a rename, so that the name survives a power
// cut.
Result<void> sync_directory(const std::filesystem::path& path);

// A whole small file. Errors: not_found, unreadable, too_large.
Result<std::string> read_text_file(const std::filesystem::path& path, std::uint64_t limit);
// Writes a temporary file next to the target, flushes, renames: readers see either the old text or the new one. An
// error leaves no temporary file.
Result<void> write_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace vacuform
