#include "full_disk.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/statvfs.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>

namespace vacuform {

namespace {

std::atomic<int> calls{0}, failing{0};
std::atomic<bool> on{false};
Full mode = Full::once;
std::optional<std::uint64_t> free_bytes;

bool fails() {
  if (!on) return false;
  const int call = ++calls;
  if (call < failing || (mode == Full::once && call > failing)) return false;
  errno = ENOSPC;
  return true;
}

int opened(const char* path, int flags, unsigned mode_bits) {
  if ((flags & O_CREAT) != 0 && ::access(path, F_OK) != 0 && fails()) return -1;
  return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode_bits));
}

long written(int file, const void* bytes, std::size_t size) {
  if (file > 2 && fails()) return -1;
  return ::syscall(SYS_write, file, bytes, size);
}

long written_at(int file, const void* bytes, std::size_t size, long at) {
  if (fails()) return -1;
  return ::syscall(SYS_pwrite64, file, bytes, size, at);
}

}  // namespace

void fill_disk_at(int call, Full how) {
  calls = 0;
  failing = call;
  mode = how;
  on = true;
}

bool empty_disk() {
  on = false;
  return calls >= failing;
}

void say_free(std::optional<std::uint64_t> bytes) { free_bytes = bytes; }

}  // namespace vacuform

using vacuform::fails;

extern "C" {

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const unsigned mode = (flags & O_CREAT) != 0 ? va_arg(more, unsigned) : 0;
  va_end(more);
  return vacuform::opened(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const unsigned mode = (flags & O_CREAT) != 0 ? va_arg(more, unsigned) : 0;
  va_end(more);
  return vacuform::opened(path, flags, mode);
}
ssize_t write(int file, const void* bytes, size_t size) { return vacuform::written(file, bytes, size); }
ssize_t pwrite(int file, const void* bytes, size_t size, off_t at) {
  return vacuform::written_at(file, bytes, size, at);
}
ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t at) {
  return vacuform::written_at(file, bytes, size, at);
}
int fsync(int) { return fails() ? -1 : 0; }
int fdatasync(int) { return fails() ? -1 : 0; }
int ftruncate(int file, off_t size) noexcept {
  return fails() ? -1 : static_cast<int>(syscall(SYS_ftruncate, file, size));
}
int ftruncate64(int file, off64_t size) noexcept {
  return fails() ? -1 : static_cast<int>(syscall(SYS_ftruncate, file, size));
}
int posix_fallocate(int file, off_t at, off_t size) {
  return fails() ? ENOSPC : static_cast<int>(syscall(SYS_fallocate, file, 0, at, size)) == 0 ? 0 : errno;
}
int mkdir(const char* path, mode_t mode) noexcept {
  return access(path, F_OK) != 0 && fails() ? -1
                                            : static_cast<int>(syscall(SYS_mkdirat, AT_FDCWD, path, mode));
}
int link(const char* from, const char* to) noexcept {
  return fails() ? -1 : static_cast<int>(syscall(SYS_linkat, AT_FDCWD, from, AT_FDCWD, to, 0));
}
int rename(const char* from, const char* to) noexcept {
  return fails() ? -1 : static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}
int statvfs(const char* path, struct statvfs* status) noexcept {
  using Real = int(const char*, struct statvfs*);
  static auto* const real = reinterpret_cast<Real*>(dlsym(RTLD_NEXT, "statvfs"));
  if (real(path, status) != 0) return -1;
  if (!vacuform::free_bytes) return 0;
  status->f_frsize = 1;
  status->f_blocks = 1 << 30;
  status->f_bavail = *vacuform::free_bytes;
  return 0;
}

}  // extern "C"
