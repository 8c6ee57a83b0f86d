// Preloaded into a program: while the file that VACUFORM_FAILING_DISK names exists, no flush reaches the disk.
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>

namespace {

int flush(long call, int descriptor) {
  const char* file = std::getenv("VACUFORM_FAILING_DISK");
  if (!file || ::access(file, F_OK) != 0) return static_cast<int>(::syscall(call, descriptor));
  errno = EIO;
  return -1;
}

}  // namespace

extern "C" int fsync(int descriptor) { return flush(SYS_fsync, descriptor); }
extern "C" int fdatasync(int descriptor) { return flush(SYS_fdatasync, descriptor); }
