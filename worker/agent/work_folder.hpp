// A private folder for one job, deleted with the job. If a worker is killed, the next one deletes its folders.
#pragma once

#include <filesystem>

#include "api/base/error.hpp"
#include "api/base/file_tree.hpp"

namespace vacuform {

class WorkFolder {
 public:
  // Creates <parent>/job-XXXXXX, mode 0700, and locks it for as long as this object (or its process) lives.
  // Errors: unreadable.
  static Result<WorkFolder> make(const std::filesystem::path& parent);
  // Deletes the folder with all its contents, whatever its permissions; logs what cannot be deleted.
  ~WorkFolder();
  WorkFolder(WorkFolder&&) noexcept = default;
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  int descriptor() const { return lock_.number(); }  // of the folder itself, even if it is moved

 private:
  WorkFolder(std::filesystem::path path, Descriptor lock) : path_(std::move(path)), lock_(std::move(lock)) {}
  std::filesystem::path path_;
  Descriptor lock_;
};

// Creates `parent` (mode 0700) if absent and deletes the folders in it whose workers have ended, that is, whose lock is
// free. Returns their number. Errors: unreadable (it cannot be created, or belongs to another user).
Result<int> sweep(const std::filesystem::path& parent);

}  // namespace vacuform
