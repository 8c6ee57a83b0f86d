// Reads scan files: takes untrusted bytes and gives triangles in the unit and axes of the file.
//
// Every reader checks each offset and count in 64 bits before it is used, allocates only in proportion to bytes that
// exist, validates every index and rejects coordinates that are not finite or absurd. Polygons become fans. Each format
// has one reader in a separate file; this is their common interface.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/base/error.hpp"
#include "api/base/patient_space.hpp"
#include "api/job_limits.hpp"
#include "worker/scan/scan_colours.hpp"
#include "worker/scan/scan_progress.hpp"
#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

// Limits of a scan. A scan beyond them is rejected with Code::too_large and the figure.
struct ScanLimits {
  std::uint64_t bytes = std::uint64_t{1} << 30;
  std::uint64_t triangles = job_limits.scan_triangles;
  std::uint64_t vertices = job_limits.scan_vertices;
  double coordinate = 1e7;  // in the file's unit; a head in micrometres stays below 1e6
  double crowding = 1000;   // crowding_of(); a head has about 10, a cone of 360 sides has 60
};
inline constexpr ScanLimits scan_limits;

// The sum of the surfaces of the boxes around single triangles, over that of the box around all, which counts as at least a
// third as thick as it is long: about the number of
// triangles that a search at a place must look at. Long slivers that cross, or meet in one vertex, make every search slow.
double crowding_of(const TriangleMesh& mesh);

struct ScanFile {
  std::string format;  // "STL (binary)", "PLY (ASCII)", "OBJ", ...
  TriangleMesh mesh;   // as in the file: not welded, any orientation, any unit; at least one triangle
  bool y_up = false;   // the format itself says that +Y is up and +Z is the front (glTF)
  PatientSpace space = PatientSpace::unknown;  // if a head or a comment of the file names one
  std::vector<std::string> notes = {};  // how the shape was read where the file is not as its format demands
  std::optional<ScanColours> colours = {};  // if they were asked for and the file has any
  std::vector<std::string> colour_notes =
      {};  // how colours were read, or why there are none, if they were asked for
  std::vector<std::string> colours_missing = {};  // colours that the file asks for and that are not there
};

// What to read of a scan file. Colours cost memory, and a file whose colours are damaged can still have a sound shape.
enum class ScanParts { shape, with_colours };

// Detects the format by the bytes and, if they are not conclusive, by the extension of `file_name`; then reads it.
// Errors: unsupported_format, corrupt_file, too_large, unusable_scan (no triangles), cancelled. Messages name the line,
// the byte or the element. The mesh is the same whatever `parts` says, triangle by triangle.
Result<ScanFile> read_scan(std::span<const std::uint8_t> bytes, const std::string& file_name,
                           const ScanProgress& progress, ScanParts parts = ScanParts::shape);

// The readers. `where` is the file's name, for messages.
using Bytes = std::span<const std::uint8_t>;
Result<ScanFile> read_stl_binary(Bytes bytes, const std::string& where, const ScanProgress& progress);
Result<ScanFile> read_stl_ascii(Bytes bytes, const std::string& where, const ScanProgress& progress);
// `files`: of the zip that holds the model, or null.
struct ModelFiles;
Result<ScanFile> read_obj(Bytes bytes, const std::string& where, const ScanProgress& progress,
                          ScanParts parts, const ModelFiles* files = nullptr);
Result<ScanFile> read_ply(Bytes bytes, const std::string& where, const ScanProgress& progress,
                          ScanParts parts, const ModelFiles* files = nullptr);
Result<ScanFile> read_off(Bytes bytes, const std::string& where, const ScanProgress& progress);
Result<ScanFile> read_glb(Bytes bytes, const std::string& where, const ScanProgress& progress,
                          ScanParts parts);

// If the bytes of a binary file show that it went through a text-mode copy, a sentence that says how; otherwise empty.
// Looks for bytes replaced by U+FFFD, for line feeds that all became CR LF and for Latin-1 turned into UTF-8.
std::string text_mode_damage(Bytes bytes);

// Error checks that every reader shares.
inline tl::unexpected<Error> corrupt(std::string what, const std::string& where) {
  return fail(Code::corrupt_file, std::move(what), where, "export the scan again, as binary STL for example");
}
inline tl::unexpected<Error> too_many_triangles(std::uint64_t count, const std::string& where) {
  return fail(Code::too_large,
              "the scan has " + std::to_string(count) + " triangles, above the limit of " +
                  std::to_string(scan_limits.triangles),
              where, "reduce it (quadric decimation) to a few hundred thousand");
}

}  // namespace vacuform
