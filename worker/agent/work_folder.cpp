#include "worker/agent/work_folder.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "api/base/file_tree.hpp"
#include "api/base/log.hpp"

namespace vacuform {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view prefix = "job-";

// An open, locked folder; no descriptor when it is locked already. Locks end with the process that holds them.
Descriptor lock(const fs::path& folder, int how) {
  Descriptor opened = open_folder(AT_FDCWD, folder.c_str(), true);
  if (opened && ::flock(opened.number(), how) != 0) opened = Descriptor();
  return opened;
}

// What cannot be deleted now is tried again by the next sweep.
bool remove_logged(const fs::path& folder) {
  const std::size_t left = remove_tree(AT_FDCWD, folder.c_str());
  if (left > 0)
    log_event("work-folder-not-deleted", {{"folder", folder.filename().string()}, {"entries", left}});
  return left == 0;
}

Error unusable(const fs::path& folder) {
  return {Code::unreadable, "the folder for work cannot be used", folder.string(),
          "give --work a folder that belongs to you and that you may write to"};
}

}  // namespace

// Folders are made and swept under the parent's lock, so that none is swept between being made and being locked.
Result<WorkFolder> WorkFolder::make(const fs::path& parent) {
  const Descriptor parent_lock = lock(parent, LOCK_EX);
  std::string name = (parent / (std::string(prefix) + "XXXXXX")).string();
  const bool made = parent_lock && ::mkdtemp(name.data()) != nullptr;
  Descriptor own_lock = made ? lock(name, LOCK_EX | LOCK_NB) : Descriptor();
  if (!own_lock) return tl::make_unexpected(unusable(parent));
  return WorkFolder(name, std::move(own_lock));
}

WorkFolder::~WorkFolder() {
  if (lock_) remove_logged(path_);
}

Result<int> sweep(const fs::path& parent) {
  std::error_code ec;
  if (parent.has_parent_path()) fs::create_directories(parent.parent_path(), ec);
  ::mkdir(parent.c_str(), 0700);
  struct stat info {};
  if (::lstat(parent.c_str(), &info) != 0 || !S_ISDIR(info.st_mode) || info.st_uid != ::geteuid())
    return tl::make_unexpected(unusable(parent));
  const Descriptor parent_lock = lock(parent, LOCK_EX);
  if (!parent_lock) return tl::make_unexpected(unusable(parent));
  int removed = 0;
  for (fs::directory_iterator it(parent, ec), end; !ec && it != end; it.increment(ec)) {
    if (it->path().filename().string().rfind(prefix, 0) != 0) continue;
    const Descriptor abandoned = lock(it->path(), LOCK_EX | LOCK_NB);
    if (abandoned && remove_logged(it->path())) ++removed;
  }
  return removed;
}

}  // namespace vacuform
