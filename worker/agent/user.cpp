#include "worker/agent/user.hpp"

#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "api/base/file_tree.hpp"

namespace vacuform {

Result<void> settle(const std::string& work, const std::string& name) {
  const passwd* user = name.empty() ? nullptr : ::getpwnam(name.c_str());
  if (!name.empty() && !user)
    return fail(Code::bad_usage, "there is no user " + name, "--user", "make it: useradd --system " + name);
  const uid_t uid = user ? user->pw_uid : ::geteuid();
  const gid_t gid = user ? user->pw_gid : ::getegid();
  const bool change = uid != ::geteuid();
  if (change && ::geteuid() != 0)
    return fail(Code::bad_usage, "only root can become the user " + name, "--user",
                "leave --user out, or start it as root");

  const Error unusable{Code::unreadable, "the folder for work cannot be used", work,
                       "give --work a folder that belongs to the worker's user and that it may write to"};
  std::error_code ignored;
  std::filesystem::create_directories(std::filesystem::path(work).parent_path(), ignored);
  const bool made = ::mkdir(work.c_str(), 0700) == 0;
  const Descriptor folder(::open(work.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  struct stat info {};
  if (!folder || ::fstat(folder.number(), &info) != 0) return tl::make_unexpected(unusable);
  if (made && change && ::fchown(folder.number(), uid, gid) == 0) info.st_uid = uid;
  if (info.st_uid != uid || ::fchdir(folder.number()) != 0) return tl::make_unexpected(unusable);
  if (!change) return {};

  // A change of user takes this away, and the server counts on it.
  int when_parent_ends = 0;
  const pid_t parent = ::getppid();
  if (::prctl(PR_GET_PDEATHSIG, &when_parent_ends) != 0 || ::setgroups(0, nullptr) != 0 ||
      ::setresgid(gid, gid, gid) != 0 || ::setresuid(uid, uid, uid) != 0 || ::setresuid(0, 0, 0) == 0)
    return fail(Code::bad_usage, "this process cannot become the user " + name, "--user",
                "start it with the capabilities to change its user, or as that user");
  if (when_parent_ends != 0 && (::prctl(PR_SET_PDEATHSIG, when_parent_ends) != 0 || ::getppid() != parent))
    return fail(Code::unavailable, "the server that started this worker is gone");
  return {};
}

}  // namespace vacuform
