#include "worker/work_folder.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace vacuform {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view prefix = "job-";

// An open, locked folder, or -1 when it is locked already. Locks end with the process that holds them.
int lock(const fs::path& folder, int how) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (fd < 0) return -1;
  if (::flock(fd, how) == 0) return fd;
  ::close(fd);
  return -1;
}

Error unusable(const fs::path& folder) {
  return {Code::unreadable, "the folder for work cannot be used", folder.string(),
          "give --work a folder that belongs to you and that you may write to"};
}

}  // namespace

// Folders are made and swept under the parent's lock, so that none is swept between being made and being locked.
Result<WorkFolder> WorkFolder::make(const fs::path& parent) {
  const int parent_lock = lock(parent, LOCK_EX);
  std::string name = (parent / (std::string(prefix) + "XXXXXX")).string();
  const bool made = parent_lock >= 0 && ::mkdtemp(name.data()) != nullptr;
  const int own_lock = made ? lock(name, LOCK_EX | LOCK_NB) : -1;
  if (parent_lock >= 0) ::close(parent_lock);
  if (own_lock < 0) return tl::make_unexpected(unusable(parent));
  return WorkFolder(name, own_lock);
}

WorkFolder::WorkFolder(WorkFolder&& other) noexcept : path_(std::move(other.path_)), lock_(other.lock_) {
  other.lock_ = -1;
}

WorkFolder::~WorkFolder() {
  if (lock_ < 0) return;
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  ::close(lock_);
}

Result<int> sweep(const fs::path& parent) {
  std::error_code ec;
  fs::create_directories(parent.parent_path(), ec);
  ::mkdir(parent.c_str(), 0700);
  struct stat info {};
  if (::lstat(parent.c_str(), &info) != 0 || !S_ISDIR(info.st_mode) || info.st_uid != ::geteuid())
    return tl::make_unexpected(unusable(parent));
  const int parent_lock = lock(parent, LOCK_EX);
  if (parent_lock < 0) return tl::make_unexpected(unusable(parent));
  int removed = 0;
  for (const auto& entry : fs::directory_iterator(parent, ec)) {
    if (entry.path().filename().string().rfind(prefix, 0) != 0) continue;
    const int abandoned = lock(entry.path(), LOCK_EX | LOCK_NB);
    if (abandoned < 0) continue;
    std::error_code ignored;
    fs::remove_all(entry.path(), ignored);
    ::close(abandoned);
    ++removed;
  }
  ::close(parent_lock);
  return removed;
}

}  // namespace vacuform
