// A disk that forgets whatever was not flushed: what files and folders hold after the power has gone.
//
// The program that links this has an fsync() and an fdatasync() of its own, which the store and SQLite call without knowing.
// They note what the flushed file or folder holds at that moment; nothing else is ever thought to have reached the disk. A
// file that a flushed folder names and that was never flushed itself is empty afterwards.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>

namespace vacuform {

struct FlushedDisk {
  std::map<std::string, std::shared_ptr<const std::string>> files;  // by their identity, what they hold
  std::map<std::filesystem::path, std::map<std::string, std::string>> folders;  // names, and whose they are

  void merge(FlushedDisk&& other);
  // Writes what `folder` and the folders in it hold after the loss of power, into a new folder.
  void restore(const std::filesystem::path& folder, const std::filesystem::path& into) const;
};

// The disk as it is now.
FlushedDisk flushed_disk();
// What `folder` and the folders in it would hold if all of it were flushed now.
FlushedDisk live_disk(const std::filesystem::path& folder);
// A disk that has done some of its unflushed work, in any order: of each sector of 512 bytes, of each size and of each name
// it has the flushed or the live one, by chance.
FlushedDisk torn_disk(const FlushedDisk& flushed, const FlushedDisk& live, unsigned seed);
// Begins with an empty disk, and calls `flushed` at each flush, before and after it counts, on the thread that flushes.
// Empty: nobody, and flushes are not noted.
void watch_flushes(std::function<void(const FlushedDisk&)> flushed);

}  // namespace vacuform
