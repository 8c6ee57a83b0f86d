// Names in files. Scans and pictures carry texts that nobody looks at: the header of an STL file, comments in OBJ, PLY, OFF
// and CSV, texts, pictures and extras in GLB, texts and Exif in PNG and JPEG, whatever SVG says beside the drawing. Often they
// name the patient, or whoever made the scan. Such texts are blanked before a file is kept or anything is made of it.
//
// Blanked, not cut out: every file keeps its length, its lines and its geometry, bit for bit, so errors name the same
// places. The bytes are looked at once, as they stream by, without trust in any length or count that they state: what does
// not look like a known format passes as it is, and at worst a wrong guess blanks what the readers do not read. Blanking
// twice changes nothing. Memory stays below 256 KiB, but for a GLB file of very many parts, 2 MiB.
//
// Not covered: what is part of the drawing in SVG (its visible texts, its ids, which name the coils, and its classes), and
// files of other kinds, which the pipeline refuses.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "api/redaction/filter_state.hpp"

namespace vacuform {

class NameFilter {
 public:
  // `extension` of the file's name, in lower case without the dot, or nothing; for formats that do not begin with a mark.
  explicit NameFilter(std::string extension);
  NameFilter(NameFilter&&) noexcept;
  ~NameFilter();

  // Takes the next bytes and gives those that are ready: all but a few, later.
  std::string pass(std::string_view bytes);
  // Gives the last ones.
  std::string finish();

  // All that a filter remembers, to go on behind the bytes that it has taken; at most 2 MiB. It may hold words that it has not
  // decided about yet.
  std::string state() const;
  // Of the same extension. False when the text is no state; then the filter is of no use.
  bool go_on(std::string_view state);

  // How one format is gone through.
  class Format {
   public:
    virtual ~Format() = default;
    virtual void take(std::string_view in, std::string& out) = 0;
    virtual void end(std::string&) {}
    virtual void fields(FilterState&) {}
  };

 private:
  enum class Kind { unknown, as_it_is, binary_stl, text_stl, obj, ply, off, csv, glb, png, jpeg, svg };
  static Kind kind_of(std::string_view head, const std::string& extension);
  static std::unique_ptr<Format> format_of(Kind kind);
  void begin(std::string& out);

  std::string extension_, head_;
  Kind kind_ = Kind::unknown;  // until the head is whole
  std::unique_ptr<Format> format_;
};

// A whole file. `file_name` may be any name; only its extension counts.
void blank_names(std::vector<std::uint8_t>& bytes, const std::string& file_name);

}  // namespace vacuform
