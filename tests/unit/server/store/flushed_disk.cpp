#include "flushed_disk.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <mutex>
#include <random>

namespace vacuform {

namespace fs = std::filesystem;

namespace {

std::mutex mutex;
FlushedDisk disk;
std::function<void(const FlushedDisk&)> told;

// Numbers of files are given again, so the time of birth belongs to it.
std::string identity(int folder, const char* name, int flags) {
  struct statx found {};
  if (::statx(folder, name, flags | AT_SYMLINK_NOFOLLOW, STATX_INO | STATX_BTIME, &found) != 0) return {};
  return std::to_string(found.stx_ino) + "/" + std::to_string(found.stx_btime.tv_sec) + "." +
         std::to_string(found.stx_btime.tv_nsec);
}

std::string bytes_of(const fs::path& path) {
  std::string all;
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  std::array<char, 65536> piece;
  for (ssize_t n; file >= 0 && (n = ::read(file, piece.data(), piece.size())) > 0;)
    all.append(piece.data(), static_cast<std::size_t>(n));
  if (file >= 0) ::close(file);
  return all;
}

std::map<std::string, std::string> names_in(const fs::path& folder, int descriptor) {
  std::map<std::string, std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    names[name] = identity(descriptor, name.c_str(), 0);
  }
  return names;
}

void note(int descriptor) {
  const fs::path link = "/proc/self/fd/" + std::to_string(descriptor);
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) return;
  if (!S_ISDIR(status.st_mode)) {
    disk.files[identity(descriptor, "", AT_EMPTY_PATH)] = std::make_shared<const std::string>(bytes_of(link));
    return;
  }
  disk.folders[fs::read_symlink(link)] = names_in(link, descriptor);
}

int flushed(int descriptor) {
  const std::lock_guard hold(mutex);
  if (!told) return 0;
  told(disk);
  note(descriptor);
  told(disk);
  return 0;
}

}  // namespace

void FlushedDisk::restore(const fs::path& folder, const fs::path& into) const {
  fs::create_directories(into);
  const auto names = folders.find(folder);
  if (names == folders.end()) return;
  for (const auto& [name, whose] : names->second) {
    if (fs::is_directory(folder / name)) {
      restore(folder / name, into / name);
      continue;
    }
    const auto file = files.find(whose);
    const int out = ::open((into / name).c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    if (file != files.end() && ::write(out, file->second->data(), file->second->size()) !=
                                   static_cast<ssize_t>(file->second->size()))
      std::abort();
    ::close(out);
  }
}

FlushedDisk live_disk(const fs::path& folder) {
  FlushedDisk live;
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  live.folders[folder] = names_in(folder, descriptor);
  ::close(descriptor);
  for (const auto& [name, whose] : live.folders[folder]) {
    if (!fs::is_directory(folder / name)) {
      live.files[whose] = std::make_shared<const std::string>(bytes_of(folder / name));
      continue;
    }
    live.merge(live_disk(folder / name));
  }
  return live;
}

void FlushedDisk::merge(FlushedDisk&& other) {
  files.merge(other.files);
  folders.merge(other.folders);
}

FlushedDisk torn_disk(const FlushedDisk& flushed, const FlushedDisk& live, unsigned seed) {
  constexpr std::size_t sector = 512;
  std::mt19937 random(seed);
  const auto chance = [&] { return random() % 2 == 0; };
  FlushedDisk torn = flushed;
  for (auto& [folder, names] : torn.folders) {
    const auto now = live.folders.find(folder);
    if (now == live.folders.end()) continue;
    for (const auto& [name, whose] : now->second)
      if (chance()) names[name] = whose;
    std::erase_if(names, [&](const auto& one) { return !now->second.contains(one.first) && chance(); });
  }
  for (const auto& [whose, bytes] : live.files) {
    const auto before = flushed.files.find(whose);
    std::string mixed = before == flushed.files.end() ? std::string() : *before->second;
    if (mixed == *bytes) continue;
    for (std::size_t at = 0; at < bytes->size(); at += sector) {
      if (!chance()) continue;
      const std::string_view piece = std::string_view(*bytes).substr(at, sector);
      if (mixed.size() < at + piece.size()) mixed.resize(at + piece.size(), '\0');
      mixed.replace(at, piece.size(), piece);
    }
    if (mixed.size() > bytes->size() && chance()) mixed.resize(bytes->size());
    torn.files[whose] = std::make_shared<const std::string>(std::move(mixed));
  }
  return torn;
}

FlushedDisk flushed_disk() {
  const std::lock_guard hold(mutex);
  return disk;
}

void watch_flushes(std::function<void(const FlushedDisk&)> flushed) {
  const std::lock_guard hold(mutex);
  disk = {};
  told = std::move(flushed);
}

}  // namespace vacuform

extern "C" int fsync(int descriptor) { return vacuform::flushed(descriptor); }
extern "C" int fdatasync(int descriptor) { return vacuform::flushed(descriptor); }
