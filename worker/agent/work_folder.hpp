// A private folder for one job, gone when the job is: whatever a worker is killed by, the next one sweeps up.
#pragma once

#include <filesystem>

#include "api/base/error.hpp"
#include "api/base/file_tree.hpp"

namespace vacuform {

class WorkFolder {
 public:
  // Makes <parent>/job-XXXXXX, mode 0700, and locks it for as long as this object (or its process) lives.
  // Errors: unreadable.
  static Result<WorkFolder> make(const std::filesystem::path& parent);
  // Removes the folder with everything in it, whatever its permissions; logs what cannot be removed.
  ~WorkFolder();
  WorkFolder(WorkFolder&&) noexcept = default;
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  int descriptor() const { return lock_.number(); }  // of the folder itself, wherever it is moved

 private:
  WorkFolder(std::filesystem::path path, Descriptor lock) : path_(std::move(path)), lock_(std::move(lock)) {}
  std::filesystem::path path_;
  Descriptor lock_;
};

// Makes `parent` (mode 0700) when absent and removes from it the folders whose workers are gone: those whose lock is
// free. Gives the number of those that are gone. Errors: unreadable (it cannot be made, or belongs to someone else).
Result<int> sweep(const std::filesystem::path& parent);

}  // namespace vacuform
