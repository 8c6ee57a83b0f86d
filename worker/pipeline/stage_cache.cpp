#include "worker/pipeline/stage_cache.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/base/file_tree.hpp"
#include "api/base/sha256.hpp"
#include "worker/pipeline/archive.hpp"

namespace vacuform {

namespace fs = std::filesystem;

template <class A>
void fields(A& a, Warning::Mark& m) {
  a(m.place_mm, m.size_mm);
}
template <class A>
void fields(A& a, Warning::Figure& f) {
  a(f.value, f.unit, f.limit);
}
template <class A>
void fields(A& a, ProposedSetting& s) {
  a(s.name, s.number, s.word);
}
template <class A>
void fields(A& a, Proposal& p) {
  a(p.set, p.text);
}
template <class A>
void fields(A& a, Warning& w) {
  a(w.code, w.text, w.marks, w.figure, w.fix, w.place, w.proposals);
}
template <class A>
void fields(A& a, Undercut& u) {
  a(u.place, u.depth_mm, u.area_mm2);
}
template <class A>
void fields(A& a, ScanFindings& f) {
  a(f.format, f.triangles_read, f.unit, f.unit_guessed, f.size_given, f.up, f.up_guessed, f.components,
    f.components_dropped, f.turned_inside_out, f.holes_closed, f.holes_capped, f.rebuilt, f.size_mm,
    f.trim_mm, f.trim_chosen, f.crumbs_dropped, f.front, f.front_from_format, f.front_assumed, f.mirrored,
    f.outliers_dropped, f.space, f.left_from_file);
}
template <class A>
void fields(A& a, TriangleMesh& m) {
  a(m.vertices, m.triangles);
}
template <class A>
void fields(A& a, ScanPlacing& p) {
  a(p.x, p.y, p.z, p.origin);
}
template <class A>
void fields(A& a, Mold& m) {
  a(m.mesh, m.top, m.undercuts, m.findings, m.warnings, m.placing);
}
template <class A>
void fields(A& a, Vent& v) {
  a(v.place, v.diameter_mm);
}
template <class A>
void fields(A& a, Extrapolation& e) {
  a(e.coarse_mm, e.fine_mm, e.mean, e.p95, e.max);
}
template <class A>
void fields(A& a, FormingSummary& s) {
  a(s.drape_steps, s.vacuum_steps, s.iterations, s.residual, s.kinetic_mj, s.converged, s.half_steps,
    s.pressure_kpa, s.mass_error, s.force_error, s.shear_modulus_kpa, s.extrapolation);
}
template <class A>
void fields(A& a, Deviation& d) {
  a(d.p99, d.max, d.place);
}
template <class A>
void fields(A& a, Misfit& m) {
  a(m.place, m.distance_mm, m.size_mm);
}
template <class A>
void fields(A& a, SurfaceFit& f) {
  a(f.penetration, f.gap, f.pierced, f.bridged);
}
template <class A>
void fields(A& a, FormedSheet& s) {
  a(s.triangles, s.rest, s.formed, s.thickness, s.temperature, s.contact, s.contact_time, s.element_thickness,
    s.element_wrinkled, s.summary, s.fit, s.vents, s.warnings);
}

namespace {

// All of an open file; nothing unless it is a regular one.
std::optional<std::vector<std::uint8_t>> bytes_of(const Descriptor& file) {
  struct stat info {};
  if (!file || ::fstat(file.number(), &info) != 0 || !S_ISREG(info.st_mode)) return std::nullopt;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(info.st_size));
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t n = ::pread(file.number(), bytes.data() + at, bytes.size() - at, static_cast<off_t>(at));
    if (n <= 0) return std::nullopt;
    at += static_cast<std::size_t>(n);
  }
  return bytes;
}

bool write_all(int file, const void* data, std::size_t size) {
  const char* bytes = static_cast<const char*>(data);
  for (std::size_t at = 0; at < size;) {
    const ssize_t n = ::write(file, bytes + at, size - at);
    if (n <= 0) return false;
    at += static_cast<std::size_t>(n);
  }
  return true;
}

// A changed program must not trust what another one made.
const std::string& program_digest() {
  static const std::string digest = [] {
    const auto program = bytes_of(Descriptor(::open("/proc/self/exe", O_RDONLY | O_CLOEXEC)));
    return program ? sha256_hex(*program) : std::string();
  }();
  return digest;
}

constexpr std::size_t digest_size = 64;  // the file begins with the digest of the rest

template <class T>
std::optional<T> read_cached(const fs::path& path) {
  // Another job of this scan may have left anything here: a FIFO must not block, a link not lead elsewhere.
  const Descriptor opened(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  const auto file = bytes_of(opened);
  if (!file || file->size() < digest_size) return std::nullopt;
  const auto content = std::span(*file).subspan(digest_size);
  if (sha256_hex(content) != std::string(file->begin(), file->begin() + digest_size)) return std::nullopt;
  T value{};
  ArchiveReader reader(content);
  reader(value);
  if (!reader.at_end()) return std::nullopt;
  ::futimens(opened.number(), nullptr);  // used just now
  return value;
}

template <class T>
void write_cached(const fs::path& path, const T& value) {
  ArchiveWriter writer;
  writer(value);
  const fs::path part = path.string() + "." + std::to_string(::getpid()) + ".part";
  ::unlink(part.c_str());
  const Descriptor out(::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!out) return;
  const std::string digest = sha256_hex(writer.bytes);
  const bool written = write_all(out.number(), digest.data(), digest.size()) &&
                       write_all(out.number(), writer.bytes.data(), writer.bytes.size());
  if (!written || ::rename(part.c_str(), path.c_str()) != 0) ::unlink(part.c_str());
}

}  // namespace

StageCache::StageCache(fs::path folder, std::function<void(Stage)> found, std::uint64_t most_bytes)
    : found_(std::move(found)), most_bytes_(most_bytes) {
  std::error_code error;
  fs::create_directories(folder.parent_path(), error);
  ::mkdir(folder.c_str(), 0700);
  if (!program_digest().empty()) folder_ = std::move(folder);
}

fs::path StageCache::path(const char* stage, const nlohmann::ordered_json& made_from) const {
  Sha256 digest;
  digest.add(program_digest());
  digest.add(made_from.dump());
  return *folder_ / (digest.hex() + "." + stage);
}

std::optional<Mold> StageCache::mold(const nlohmann::ordered_json& made_from) const {
  auto cached = folder_ ? read_cached<Mold>(path("mold", made_from)) : std::nullopt;
  if (cached && found_) found_(Stage::scan);
  return cached;
}
std::optional<FormedSheet> StageCache::sheet(const nlohmann::ordered_json& made_from) const {
  auto cached = folder_ ? read_cached<FormedSheet>(path("sheet", made_from)) : std::nullopt;
  if (cached && found_) found_(Stage::forming);
  return cached;
}
void StageCache::store(const nlohmann::ordered_json& made_from, const Mold& mold) const {
  if (!folder_) return;
  write_cached(path("mold", made_from), mold);
  make_room();
}
void StageCache::store(const nlohmann::ordered_json& made_from, const FormedSheet& sheet) const {
  if (!folder_) return;
  write_cached(path("sheet", made_from), sheet);
  make_room();
}

void StageCache::make_room() const {
  struct File {
    fs::path path;
    std::int64_t used;  // nanoseconds
    std::uint64_t size;
  };
  std::vector<File> files;
  std::uint64_t sum = 0;
  std::error_code error;
  for (fs::directory_iterator it(*folder_, error), end; !error && it != end; it.increment(error)) {
    struct stat info {};
    const fs::path& file = it->path();
    if ((file.extension() != ".mold" && file.extension() != ".sheet") || ::lstat(file.c_str(), &info) != 0)
      continue;
    files.push_back({file, std::int64_t{info.st_mtim.tv_sec} * 1'000'000'000 + info.st_mtim.tv_nsec,
                     static_cast<std::uint64_t>(info.st_size)});
    sum += files.back().size;
  }
  std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.used < b.used; });
  for (const File& file : files) {
    if (sum <= most_bytes_) break;
    fs::remove(file.path, error);
    sum -= file.size;
  }
}

}  // namespace vacuform
