// Names in files. Scans and pictures contain hidden texts: the header of an STL file, comments in OBJ, PLY, OFF and
// CSV, texts and extras in GLB, also in its pictures, texts and Exif in PNG and JPEG, everything in SVG besides the drawing. Often
// they name the patient, or the person who made the scan. Such texts are blanked before a file is stored or used.
//
// The texts are blanked, not cut out: every file keeps its length, its lines and its geometry, bit for bit, so errors
// name the same positions. The bytes are read once, as a stream, without trust in any length or count that they state.
// Data that does not look like a known format passes unchanged, and at worst a wrong guess blanks bytes that the
// readers do not read. Blanking twice changes nothing. Memory stays below 256 KiB, except for a GLB file of very many
// parts, 2 MiB, and a zip, 4 MiB.
//
// A zip of a model is the exception (zip_names.hpp): it is written again without names, uncompressed, so its length changes,
// and it may be refused.
//
// Not covered: parts of the drawing in SVG (its visible texts, its ids, which name the coils, and its classes), and
// files of other kinds, which the pipeline refuses.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/error.hpp"
#include "api/redaction/filter_state.hpp"

namespace vacuform {

class NameFilter {
 public:
  // `extension` of the file's name, in lower case without the dot, or empty; for formats without a magic number.
  explicit NameFilter(std::string extension);
  NameFilter(NameFilter&&) noexcept;
  ~NameFilter();

  // Takes the next bytes and returns those that are ready; it holds a few back.
  std::string pass(std::string_view bytes);
  // Returns the last ones.
  std::string finish();
  // Why the file is refused, if it is: only a zip can be. To be asked after the last bytes at the latest.
  Result<void> check() const;

  // Whether the filter can continue from a state; that of a zip cannot.
  bool can_go_on() const { return !format_ || format_->can_go_on(); }
  // The state of the filter, to continue after the bytes that it has taken; at most 2 MiB. It may contain words that
  // are not decided yet.
  std::string state() const;
  // From a filter of the same extension. False if the text is not a state; then the filter must not be used.
  bool go_on(std::string_view state);

  // The parser of one format.
  class Format {
   public:
    virtual ~Format() = default;
    virtual void take(std::string_view in, std::string& out) = 0;
    virtual void end(std::string&) {}
    virtual void fields(FilterState&) {}
    virtual bool can_go_on() const { return true; }
    virtual std::optional<Error> problem() const { return {}; }
  };

 private:
  enum class Kind { unknown, as_it_is, binary_stl, text_stl, obj, ply, off, csv, glb, png, jpeg, svg, zip };
  static Kind kind_of(std::string_view head, const std::string& extension);
  static std::unique_ptr<Format> format_of(Kind kind);
  void begin(std::string& out);

  std::string extension_, head_;
  Kind kind_ = Kind::unknown;  // until the head is complete
  std::unique_ptr<Format> format_;
};

// A complete file. `file_name` may be any name; only its extension counts. Errors: those of a zip.
Result<void> blank_names(std::vector<std::uint8_t>& bytes, const std::string& file_name);

}  // namespace vacuform
