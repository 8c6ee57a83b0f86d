#include "api/base/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

namespace vacuform {

namespace {

std::string reason(int number) { return std::generic_category().message(number); }

bool full(int number) { return number == ENOSPC || number == EDQUOT; }

// File names of the store are its own; they tell a log reader nothing about a patient.
tl::unexpected<Error> disk_error(const char* doing, const std::filesystem::path& path, int number) {
  return fail(full(number) ? Code::disk_full : Code::unavailable,
              std::string(doing) + " failed: " + reason(number), path.filename().string(),
              full(number) ? "delete jobs that are no longer needed, or free some space on the server's disk"
                           : "check that the server may write to its data folder");
}

void (*flush_failure)() = nullptr;

}  // namespace

void when_flush_fails(void (*handler)()) { flush_failure = handler; }
void flush_failed() {
  if (flush_failure) flush_failure();
}

File& File::operator=(File&& other) noexcept {
  if (this != &other) {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = other.descriptor_;
    other.descriptor_ = -1;
  }
  return *this;
}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<File> File::create(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0600);
  if (descriptor < 0) return disk_error("creating a file", path, errno);
  return File(descriptor);
}

Result<File> File::open(const std::filesystem::path& path) {
  // O_NONBLOCK: a FIFO in the place of a file would wait for its writer.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0)
    return fail(errno == ENOENT ? Code::not_found : Code::unreadable,
                "opening a file failed: " + reason(errno), path.filename().string());
  File file(descriptor);
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode))
    return fail(Code::unreadable, "not a regular file", path.filename().string());
  return file;
}

Result<void> File::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return disk_error("writing", "the data folder", errno);
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return {};
}

Result<std::size_t> File::read_at(std::uint64_t offset, std::span<char> into) const {
  for (;;) {
    const ssize_t n = ::pread(descriptor_, into.data(), into.size(), static_cast<off_t>(offset));
    if (n >= 0) return static_cast<std::size_t>(n);
    if (errno != EINTR) return fail(Code::unreadable, "reading a file failed: " + reason(errno));
  }
}

Result<std::uint64_t> File::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0)
    return fail(Code::unreadable, "reading a file failed: " + reason(errno));
  return static_cast<std::uint64_t>(status.st_size);
}

Result<void> File::sync() {
  if (::fsync(descriptor_) == 0) return {};
  const int number = errno;
  if (number == EIO) flush_failed();
  return disk_error("flushing to the disk", "the data folder", number);
}

void File::invalidate() const { (void)::futimens(descriptor_, nullptr); }

Result<void> make_directory(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!error && !std::filesystem::is_directory(path, error))
    error = std::make_error_code(std::errc::not_a_directory);
  if (!error) std::filesystem::permissions(path, std::filesystem::perms::owner_all, error);
  if (error)
    return fail(full(error.value()) ? Code::disk_full : Code::unavailable,
                "making a folder failed: " + error.message(), path.string(),
                "give another folder with --data, or check that the server may write there");
  return {};
}

Result<void> sync_directory(const std::filesystem::path& path) {
  const File directory(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.is_open() && ::fsync(directory.descriptor()) == 0) return {};
  const int number = errno;
  if (directory.is_open() && number == EIO) flush_failed();
  return disk_error("flushing a folder to the disk", path, number);
}

Result<std::string> read_text_file(const std::filesystem::path& path, std::uint64_t limit) {
  VACUFORM_TRY(file, File::open(path));
  VACUFORM_TRY(bytes, file.size());
  if (bytes > limit)
    return fail(Code::too_large, "the file is larger than expected", path.filename().string());
  std::string text(bytes, '\0');
  VACUFORM_TRY(n, file.read_at(0, text));
  text.resize(n);
  return text;
}

Result<void> write_text_file(const std::filesystem::path& path, std::string_view text) {
  std::filesystem::path beside = path;
  beside += ".new";
  ::unlink(beside.c_str());
  const auto replace = [&]() -> Result<void> {
    VACUFORM_TRY(file, File::create(beside));
    VACUFORM_CHECK(file.write(text));
    VACUFORM_CHECK(file.sync());
    if (std::rename(beside.c_str(), path.c_str()) != 0) return disk_error("renaming a file", path, errno);
    return {};
  };
  if (auto replaced = replace(); !replaced) {
    ::unlink(beside.c_str());
    return replaced;
  }
  return sync_directory(path.has_parent_path() ? path.parent_path() : ".");
}

}  // namespace vacuform
