// Redaction: a copy of a file without the names in it. Scans and pictures contain hidden texts: the header of an STL file,
// comments in OBJ, PLY, OFF and CSV, the names of properties in PLY, texts, extras and unknown keys in GLB, texts and Exif in
// PNG and JPEG, also inside GLB and SVG, everything in SVG besides the drawing, and in any of them bytes that no reader uses.
// Often they name the patient, or the person who made the scan. The server stores the copy alone.
//
// The geometry, the pixels and the drawing stay, bit for bit. Text formats keep their lines, so that errors name the same
// places; where a number should stand and a word does, the copy has question marks. A second redaction changes nothing. The
// copy of an untrusted file is made in linear time. Memory stays below 1 MiB, except for lines of text (16 MiB at most), the
// JSON of a GLB file (64 MiB at most) and the styles and attributes of an SVG file.
//
// Of an SVG, the name and the version of the program that wrote it stay, where the size depends on it (svg_generator.hpp); of
// the Exif data of a JPEG, its orientation and resolution. A packed SVG is stored unpacked. A DXF keeps its shapes alone: its
// layers and blocks get numbers for names.
//
// Not covered: parts of the drawing in SVG (its visible texts, its ids, which name the coils, and its classes), and GLB
// files that end too early and files of other kinds, which are copied as they are and which the pipeline refuses.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "api/base/byte_source.hpp"
#include "api/base/error.hpp"

namespace vacuform {

// `extension` of the file's name, in lower case without the dot, or empty; for formats without a magic number. Errors:
// corrupt_file, unsupported_format, unusable_scan, too_large (of the file; damaged files of most formats are left to their
// readers, so these are those of a zip, of SVG, and of the limits above), and those of the source and the sink.
Result<void> redact(const ByteSource& file, const std::string& extension, const ByteSink& out);

// In memory. `file_name` may be any name; only its extension counts.
Result<void> redact(std::vector<std::uint8_t>& bytes, const std::string& file_name);

// The largest zip that is read (PKWARE, .ZIP File Format Specification 6.3). The same entries in the same order give the same
// bytes. Refused: encrypted and damaged archives, packing other than deflate, absolute paths and those to a parent folder, links,
// and what is beyond these limits.
//
// A zip holds a model: one OBJ with its MTL, or one PLY, and PNG or JPEG images. It is written again, uncompressed: model.obj,
// model.mtl or model.ply, and texture-1 and so on, the images by the numbers that the files call them by. Other entries are left
// out. Refused: more than one model, images that are missing or neither PNG nor JPEG.
//
// Or it holds the layers of a print: SVG and SVGZ files whose names end with that of a layer (print_step.hpp), after the name of
// a project, as head-F_Cu.svg does. They are written as one SVG, each in a group with the name of its layer. An id or a class
// that two files have gets a number in the second. Refused: drawings without such a name, pictures and DXF files with one, drawings
// whose pages differ, and style sheets that would style other drawings.
struct ZipLimits {
  std::uint64_t entries = 1000;                                // also of what is left out
  std::uint64_t bytes = (std::uint64_t{1} << 30) - (1 << 20);  // unpacked, of what is kept
  std::uint64_t ratio = 200;     // unpacked against packed, of an entry above a mebibyte
  std::uint64_t line = 1 << 20;  // of an OBJ or MTL
};
inline constexpr ZipLimits zip_limits;

}  // namespace vacuform
