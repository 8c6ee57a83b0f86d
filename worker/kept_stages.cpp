#include "worker/kept_stages.hpp"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "api/sha256.hpp"
#include "worker/archive.hpp"

namespace vacuform {

namespace fs = std::filesystem;

template <class A>
void fields(A& a, Warning::Mark& m) {
  a(m.place_mm, m.size_mm);
}
template <class A>
void fields(A& a, Warning& w) {
  a(w.code, w.text, w.marks);
}
template <class A>
void fields(A& a, Undercut& u) {
  a(u.place, u.depth_mm, u.area_mm2);
}
template <class A>
void fields(A& a, ScanFindings& f) {
  a(f.format, f.triangles_read, f.unit, f.unit_guessed, f.size_given, f.up, f.up_guessed, f.components,
    f.components_dropped, f.turned_inside_out, f.holes_closed, f.holes_capped, f.rebuilt, f.size_mm,
    f.trim_mm, f.trim_chosen);
}
template <class A>
void fields(A& a, TriangleMesh& m) {
  a(m.vertices, m.triangles);
}
template <class A>
void fields(A& a, Mold& m) {
  a(m.mesh, m.top, m.undercuts, m.findings, m.warnings);
}
template <class A>
void fields(A& a, Vent& v) {
  a(v.place, v.diameter_mm);
}
template <class A>
void fields(A& a, FormingSummary& s) {
  a(s.drape_steps, s.vacuum_steps, s.iterations, s.residual, s.kinetic_mj, s.converged, s.pressure_kpa,
    s.mass_error, s.force_error, s.shear_modulus_kpa);
}
template <class A>
void fields(A& a, FormedSheet& s) {
  a(s.triangles, s.rest, s.formed, s.thickness, s.temperature, s.contact, s.contact_time, s.element_thickness,
    s.element_slack, s.summary, s.vents, s.warnings);
}

namespace {

std::optional<std::vector<std::uint8_t>> bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) return std::nullopt;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(in.tellg()));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in) return std::nullopt;
  return bytes;
}

// A changed program must not trust what another one made.
const std::string& program_digest() {
  static const std::string digest = [] {
    const auto program = bytes_of("/proc/self/exe");
    return program ? sha256_hex(*program) : std::string();
  }();
  return digest;
}

constexpr std::size_t digest_size = 64;  // the file begins with the digest of the rest

template <class T>
std::optional<T> read_kept(const fs::path& path) {
  const auto file = bytes_of(path);
  if (!file || file->size() < digest_size) return std::nullopt;
  const auto content = std::span(*file).subspan(digest_size);
  if (sha256_hex(content) != std::string(file->begin(), file->begin() + digest_size)) return std::nullopt;
  T value{};
  ArchiveReader reader(content);
  reader(value);
  if (!reader.at_end()) return std::nullopt;
  std::error_code ignored;
  fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);  // used just now
  return value;
}

template <class T>
void write_kept(const fs::path& path, const T& value) {
  ArchiveWriter writer;
  writer(value);
  const fs::path part = path.string() + "." + std::to_string(::getpid()) + ".part";
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  std::error_code error;
  fs::permissions(part, fs::perms::owner_read | fs::perms::owner_write, error);
  out << sha256_hex(writer.bytes);
  out.write(reinterpret_cast<const char*>(writer.bytes.data()),
            static_cast<std::streamsize>(writer.bytes.size()));
  out.close();
  if (out && !error) fs::rename(part, path, error);
  if (!out || error) fs::remove(part, error);
}

}  // namespace

KeptStages::KeptStages(fs::path folder, std::function<void(Stage)> found, std::uint64_t most_bytes)
    : found_(std::move(found)), most_bytes_(most_bytes) {
  std::error_code error;
  if (fs::create_directories(folder, error)) fs::permissions(folder, fs::perms::owner_all, error);
  if (!program_digest().empty()) folder_ = std::move(folder);
}

fs::path KeptStages::path(const char* stage, const nlohmann::ordered_json& made_from) const {
  Sha256 digest;
  digest.add(program_digest());
  digest.add(made_from.dump());
  return *folder_ / (digest.hex() + "." + stage);
}

std::optional<Mold> KeptStages::mold(const nlohmann::ordered_json& made_from) const {
  auto kept = folder_ ? read_kept<Mold>(path("mold", made_from)) : std::nullopt;
  if (kept && found_) found_(Stage::scan);
  return kept;
}
std::optional<FormedSheet> KeptStages::sheet(const nlohmann::ordered_json& made_from) const {
  auto kept = folder_ ? read_kept<FormedSheet>(path("sheet", made_from)) : std::nullopt;
  if (kept && found_) found_(Stage::forming);
  return kept;
}
void KeptStages::keep(const nlohmann::ordered_json& made_from, const Mold& mold) const {
  if (!folder_) return;
  write_kept(path("mold", made_from), mold);
  make_room();
}
void KeptStages::keep(const nlohmann::ordered_json& made_from, const FormedSheet& sheet) const {
  if (!folder_) return;
  write_kept(path("sheet", made_from), sheet);
  make_room();
}

void KeptStages::make_room() const {
  struct File {
    fs::path path;
    fs::file_time_type used;
    std::uint64_t size;
  };
  std::vector<File> files;
  std::uint64_t sum = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(*folder_, error)) {
    if (entry.path().extension() != ".mold" && entry.path().extension() != ".sheet") continue;
    files.push_back({entry.path(), entry.last_write_time(error), entry.file_size(error)});
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
