// Names in files. Scans and pictures carry texts that nobody looks at: the header of an STL file, comments in OBJ, PLY and
// OFF, texts and Exif in PNG and JPEG. Often they name the patient, or whoever made the scan. Such texts are blanked
// before a file is kept or anything is made of it.
//
// Blanked, not cut out: every file keeps its length, its lines and its geometry, bit for bit, so errors name the same
// places. The bytes are looked at once, as they stream by, without trust in any length or count that they state: what does
// not look like a known format passes as it is, and at worst a wrong guess blanks what the readers do not read. Blanking
// twice changes nothing. Memory stays below 128 KiB.
//
// Not covered: GLB, whose JSON part may hold names, SVG, whose texts are part of the drawing, and files of other kinds,
// which the pipeline refuses.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

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

  // How one format is gone through.
  class Format {
   public:
    virtual ~Format() = default;
    virtual void take(std::string_view in, std::string& out) = 0;
    virtual void end(std::string&) {}
  };

 private:
  std::string extension_, head_;
  std::unique_ptr<Format> format_;  // once the head is known
};

// A whole file. `file_name` may be any name; only its extension counts.
void blank_names(std::vector<std::uint8_t>& bytes, const std::string& file_name);

}  // namespace vacuform
