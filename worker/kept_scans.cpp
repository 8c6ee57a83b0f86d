#include "worker/kept_scans.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <vector>

namespace vacuform {

namespace fs = std::filesystem;

namespace {

bool is_digest(const std::string& name) {
  return name.size() == 64 && name.find_first_not_of("0123456789abcdef") == std::string::npos;
}

// A folder that nobody else may look into: made, or found as it should be.
bool private_folder(const fs::path& folder) {
  ::mkdir(folder.c_str(), 0700);
  struct stat info {};
  return ::lstat(folder.c_str(), &info) == 0 && S_ISDIR(info.st_mode) && info.st_uid == ::geteuid() &&
         (info.st_mode & 077) == 0;
}

Error unusable(const fs::path& folder) {
  return {Code::unreadable, "the folder for kept stages cannot be used", folder.string(),
          "give --keep a folder of your own with mode 0700, or --no-keep"};
}

std::uint64_t bytes_in(const fs::path& folder) {
  std::uint64_t sum = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code gone;
    if (it->is_regular_file(gone) && !it->is_symlink(gone)) sum += it->file_size(gone);
  }
  return sum;
}

}  // namespace

Result<KeptScans> KeptScans::open(fs::path folder, std::uint64_t most_bytes, std::chrono::hours longest) {
  std::error_code error;
  fs::create_directories(folder.parent_path().parent_path(), error);
  ::mkdir(folder.parent_path().c_str(), 0700);  // the folder for work, where nobody made it yet
  if (!private_folder(folder)) return tl::make_unexpected(unusable(folder));
  return KeptScans(std::move(folder), most_bytes, longest);
}

Result<fs::path> KeptScans::of(const std::string& sha256) const {
  if (!is_digest(sha256)) return fail(Code::bad_usage, "not a SHA-256", sha256.substr(0, 64));
  const fs::path folder = folder_ / sha256;
  if (!private_folder(folder)) return tl::make_unexpected(unusable(folder));
  std::error_code error;
  fs::last_write_time(folder, fs::file_time_type::clock::now(), error);
  return folder;
}

int KeptScans::make_room() const {
  struct Scan {
    fs::path folder;
    fs::file_time_type used;
    std::uint64_t bytes;
  };
  std::vector<Scan> scans;
  std::uint64_t sum = 0;
  std::error_code error;
  for (fs::directory_iterator it(folder_, error), end; !error && it != end; it.increment(error)) {
    if (!is_digest(it->path().filename().string())) continue;
    std::error_code gone;
    scans.push_back({it->path(), it->last_write_time(gone), bytes_in(it->path())});
    sum += scans.back().bytes;
  }
  std::sort(scans.begin(), scans.end(), [](const Scan& a, const Scan& b) { return a.used < b.used; });
  const auto oldest = fs::file_time_type::clock::now() - longest_;
  int deleted = 0;
  for (const Scan& scan : scans) {
    if (sum <= most_bytes_ && scan.used >= oldest) continue;
    fs::remove_all(scan.folder, error);
    sum -= scan.bytes;
    ++deleted;
  }
  return deleted;
}

}  // namespace vacuform
