// A private folder for one job, gone when the job is: whatever a worker is killed by, the next one sweeps up.
#pragma once

#include <filesystem>

#include "api/error.hpp"

namespace vacuform {

class WorkFolder {
 public:
  // Makes <parent>/job-XXXXXX, mode 0700, and locks it for as long as this object (or its process) lives.
  // Errors: unreadable.
  static Result<WorkFolder> make(const std::filesystem::path& parent);
  // Removes the folder with everything in it.
  ~WorkFolder();
  WorkFolder(WorkFolder&& other) noexcept;
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  WorkFolder(std::filesystem::path path, int lock) : path_(std::move(path)), lock_(lock) {}
  std::filesystem::path path_;
  int lock_ = -1;
};

// Makes `parent` (mode 0700) when absent and removes from it the folders whose workers are gone: those whose lock is
// free. Gives their number. Errors: unreadable (it cannot be made, or belongs to someone else).
Result<int> sweep(const std::filesystem::path& parent);

}  // namespace vacuform
