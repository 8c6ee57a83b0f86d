#include "api/base/file_tree.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

namespace vacuform {

namespace {

struct Close {
  void operator()(DIR* listing) const { ::closedir(listing); }
};
using Listing = std::unique_ptr<DIR, Close>;

// Lists a folder from its beginning; the descriptor stays the caller's.
Listing list(int folder) {
  const int own = ::openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  Listing listing(own >= 0 ? ::fdopendir(own) : nullptr);
  if (!listing && own >= 0) ::close(own);
  return listing;
}

// The next name but "." and ".."; null at the end.
const char* next(const Listing& listing) {
  while (const dirent* entry = ::readdir(listing.get()))
    if (std::strcmp(entry->d_name, ".") != 0 && std::strcmp(entry->d_name, "..") != 0) return entry->d_name;
  return nullptr;
}

void measure(int folder, int depth, const TreeLimits& limits, TreeSize& sum) {
  const Listing listing = list(folder);
  sum.within = sum.within && listing && depth <= limits.depth;
  while (sum.within) {
    const char* name = next(listing);
    if (!name) return;
    struct stat info {};
    if (::fstatat(folder, name, &info, AT_SYMLINK_NOFOLLOW) != 0) continue;  // gone meanwhile
    ++sum.entries;
    if (S_ISREG(info.st_mode)) sum.bytes += static_cast<std::uint64_t>(info.st_size);
    sum.within = sum.entries <= limits.entries && sum.bytes <= limits.bytes;
    if (!S_ISDIR(info.st_mode) || !sum.within) continue;
    const Descriptor below = open_folder(folder, name, false);
    sum.within = static_cast<bool>(below);
    if (below) measure(below.number(), depth + 1, limits, sum);
  }
}

bool remove_entry(int folder, const char* name) {
  return ::unlinkat(folder, name, 0) == 0 || ::unlinkat(folder, name, AT_REMOVEDIR) == 0;
}

// Moves a folder up into `top` under a name that is free there.
bool move_up(int folder, const char* name, int top, std::size_t& number) {
  if (!open_folder(folder, name, true)) return false;  // its owner must be allowed to write to it
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const std::string free = ".below-" + std::to_string(number++);
    if (::renameat(folder, name, top, free.c_str()) == 0) return true;
    if (errno != EEXIST && errno != ENOTEMPTY && errno != ENOTDIR) return false;
  }
  return false;
}

}  // namespace

Descriptor::~Descriptor() {
  if (number_ >= 0) ::close(number_);
}

Descriptor open_folder(int parent, const char* name, bool force) {
  constexpr int how = O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;
  if (force) {
    // By way of the open folder: a link that takes its place meanwhile is not followed.
    const Descriptor place(::openat(parent, name, how | O_PATH));
    struct stat info {};
    if (place && ::fstat(place.number(), &info) == 0 && (info.st_mode & S_IRWXU) != S_IRWXU)
      ::chmod(("/proc/self/fd/" + std::to_string(place.number())).c_str(), S_IRWXU);
  }
  return Descriptor(::openat(parent, name, how | O_RDONLY));
}

TreeSize measure_tree(int folder, const TreeLimits& limits) {
  TreeSize sum;
  measure(folder, 0, limits, sum);
  return sum;
}

// Folders within folders are moved up to the top until none is left, so that two levels are open at a time.
std::size_t remove_tree(int parent, const char* name) {
  if (remove_entry(parent, name) || errno == ENOENT) return 0;
  const Descriptor top = open_folder(parent, name, true);
  if (!top) return 1;
  std::size_t left = 0, number = 0;
  constexpr int most_passes = 100'000;  // a process that still adds to the tree must not keep us here
  bool progress = true;
  for (int pass = 0; progress && pass < most_passes; ++pass) {
    progress = false;
    left = 0;
    const Listing listing = list(top.number());
    if (!listing) return 1;
    while (const char* entry = next(listing)) {
      if (remove_entry(top.number(), entry)) {
        progress = true;
        continue;
      }
      const Descriptor folder = open_folder(top.number(), entry, true);
      const Listing below = folder ? list(folder.number()) : nullptr;
      while (const char* deeper = below ? next(below) : nullptr)
        if (remove_entry(folder.number(), deeper) || move_up(folder.number(), deeper, top.number(), number))
          progress = true;
      if (::unlinkat(top.number(), entry, AT_REMOVEDIR) == 0)
        progress = true;
      else if (errno != ENOENT)
        ++left;
    }
  }
  if (remove_entry(parent, name) || errno == ENOENT) return 0;
  return left > 0 ? left : 1;
}

}  // namespace vacuform
