#include "worker/agent/scan_caches.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "api/base/file_tree.hpp"
#include "api/base/log.hpp"

namespace vacuform {

namespace fs = std::filesystem;

namespace {

bool is_digest(const std::string& name) {
  return name.size() == 64 && name.find_first_not_of("0123456789abcdef") == std::string::npos;
}

// A private folder: created, or found with the right owner and mode.
bool private_folder(const fs::path& folder) {
  ::mkdir(folder.c_str(), 0700);
  struct stat info {};
  return ::lstat(folder.c_str(), &info) == 0 && S_ISDIR(info.st_mode) && info.st_uid == ::geteuid() &&
         (info.st_mode & 077) == 0;
}

Error unusable(const fs::path& folder) {
  return {Code::unreadable, "the folder for cached stages cannot be used", folder.string(),
          "give --cache a folder of your own with mode 0700, or --no-cache"};
}

// A job leaves a few files here and no folders; a subfolder with more is not read, counted or used any longer.
TreeSize size_of(const fs::path& folder) {
  const Descriptor opened = open_folder(AT_FDCWD, folder.c_str(), true);
  TreeLimits limits;
  limits.entries = ScanCaches::most_files;
  limits.depth = 0;
  return opened ? measure_tree(opened.number(), limits) : TreeSize{0, 0, false};
}

}  // namespace

Result<ScanCaches> ScanCaches::open(fs::path folder, std::uint64_t most_bytes, std::chrono::hours longest) {
  std::error_code error;
  if (folder.is_absolute()) fs::create_directories(folder.parent_path().parent_path(), error);
  if (folder.has_parent_path())
    ::mkdir(folder.parent_path().c_str(), 0700);  // the work folder, if it does not exist yet
  if (!private_folder(folder)) return tl::make_unexpected(unusable(folder));
  return ScanCaches(std::move(folder), most_bytes, longest);
}

Result<fs::path> ScanCaches::of(const std::string& key) const {
  if (!is_digest(key)) return fail(Code::bad_usage, "not a key of 64 hexadecimal digits", key.substr(0, 64));
  const fs::path folder = folder_ / key;
  if (!private_folder(folder)) return tl::make_unexpected(unusable(folder));
  std::error_code error;
  fs::last_write_time(folder, fs::file_time_type::clock::now(), error);
  return folder;
}

int ScanCaches::make_room() const {
  struct Scan {
    fs::path folder;
    fs::file_time_type used;
    TreeSize size;
  };
  std::vector<Scan> scans;
  std::uint64_t sum = 0;
  std::error_code error;
  for (fs::directory_iterator it(folder_, error), end; !error && it != end; it.increment(error)) {
    if (!is_digest(it->path().filename().string())) continue;
    std::error_code gone;
    scans.push_back({it->path(), it->last_write_time(gone), size_of(it->path())});
    sum += scans.back().size.bytes;
  }
  std::sort(scans.begin(), scans.end(), [](const Scan& a, const Scan& b) { return a.used < b.used; });
  const auto oldest = fs::file_time_type::clock::now() - longest_;
  int deleted = 0;
  for (const Scan& scan : scans) {
    if (scan.size.within && sum <= most_bytes_ && scan.used >= oldest) continue;
    if (const std::size_t left = remove_tree(AT_FDCWD, scan.folder.c_str()); left > 0) {
      log_event("cache-not-deleted", {{"key", scan.folder.filename().string()}, {"entries", left}});
      continue;
    }
    sum -= scan.size.bytes;
    ++deleted;
  }
  return deleted;
}

}  // namespace vacuform
