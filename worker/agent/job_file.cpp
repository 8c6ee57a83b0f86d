#include "worker/agent/job_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace vacuform {

// One name at a time with O_NOFOLLOW: below two fixed names that says what openat2() would with RESOLVE_BENEATH,
// RESOLVE_NO_SYMLINKS and RESOLVE_NO_MAGICLINKS, and systemd's RestrictSUIDSGID= refuses openat2() altogether.
Result<std::optional<JobFile>> open_job_file(int home, const char* folder, const char* name,
                                             std::uint64_t largest) {
  const auto refuse = [&](const char* why) {
    return fail(Code::internal,
                std::string("the job's process left something that is not a file of its own: ") + why, name,
                "report it with the job's id");
  };
  const Descriptor inside(::openat(home, folder, O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (!inside && errno == ENOENT) return std::nullopt;
  if (!inside) return refuse("the folder is a link or a file");
  JobFile file;
  file.descriptor =
      Descriptor(::openat(inside.number(), name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (!file.descriptor && errno == ENOENT) return std::nullopt;
  if (!file.descriptor) return refuse(errno == ELOOP ? "a symbolic link" : "it cannot be opened");
  struct stat info {};
  if (::fstat(file.descriptor.number(), &info) != 0 || !S_ISREG(info.st_mode))
    return refuse("not a regular file");
  if (info.st_uid != ::geteuid()) return refuse("it belongs to another user");
  if (info.st_nlink != 1) return refuse("it has a second name (a hard link)");
  file.bytes = static_cast<std::uint64_t>(info.st_size);
  if (file.bytes > largest) return refuse("it is too large");
  return std::optional<JobFile>(std::move(file));
}

}  // namespace vacuform
