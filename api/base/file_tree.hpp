// Folders of untrusted programs: opened, measured and deleted without following links and without recursion, for any
// depth, number of files and permissions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

namespace vacuform {

// A file descriptor that is closed with this object; -1 if there is no descriptor.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor();

  int number() const { return number_; }
  explicit operator bool() const { return number_ >= 0; }

 private:
  int number_ = -1;
};

// Opens the folder `name` in the folder `parent`; with `force` it first gives the owner all rights to it. Returns no
// descriptor, and sets errno, if `name` is a link or not a folder.
Descriptor open_folder(int parent, const char* name, bool force);

struct TreeSize {
  std::size_t entries = 0;  // files, folders and everything else
  std::uint64_t bytes = 0;  // of regular files
  bool within =
      true;  // false: more than was allowed, or a folder that cannot be read; then the sums are not complete
};
struct TreeLimits {
  std::size_t entries = 1000;
  int depth = 4;  // of folders below the first; at most this many descriptors are open
  std::uint64_t bytes = 8ull << 30;
};
// Measures the contents of a folder. Stops at the first limit that is exceeded, so its time is bounded.
TreeSize measure_tree(int folder, const TreeLimits& limits);

// Deletes `name` in the folder `parent` (a descriptor, or AT_FDCWD) with everything below it. Returns the number of
// entries that could not be deleted, 0 if nothing is left or nothing was there.
std::size_t remove_tree(int parent, const char* name);

}  // namespace vacuform
