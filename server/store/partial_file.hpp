// A file that arrives in pieces over many connections, without the names in it (api/names.hpp), and that survives a crash
// between them: what flush() has flushed is there again after kill -9 or a power cut.
//
// Two files stand under one name. NAME.part has the bytes as they will be kept, names blanked. NAME.tail says how many
// bytes had come at the last flush, and has the last of them as they came: the filter decides by what came before, and
// blanked bytes no longer tell all of that. After a restart the filter and the hash go once through NAME.part and then
// through the tail. The tail begins with a line where there is one within reach, and is at most 256 KiB; it is the only
// place where a name can stand, and goes when the file is complete or given up. (Of a line of text beyond that length, the
// words behind a restart may be taken for the begin of a line.)
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "api/names.hpp"
#include "server/store/blobs.hpp"

namespace vacuform {

class PartialFile {
 public:
  // Goes on with what stands under that name, or begins. `extension` as NameFilter takes it. Errors: unavailable,
  // unreadable.
  static Result<PartialFile> open(std::filesystem::path name, const std::string& extension);
  // How many bytes the last flush of that name left; 0 when there was none. Reads only that number.
  static Result<std::uint64_t> flushed(const std::filesystem::path& name);
  static void remove(const std::filesystem::path& name);

  std::uint64_t bytes() const { return received_; }
  // Takes the next bytes. They are lost in a crash before flush(). Errors: unavailable (disk full).
  Result<void> take(std::string_view bytes);
  Result<void> flush();
  // Ends the file and hands it over; nothing may be taken afterwards. The tail stays until remove().
  Result<Upload> finish();

 private:
  PartialFile(std::filesystem::path name, const std::string& extension)
      : name_(std::move(name)), filter_(extension) {}
  Result<void> begin();
  Result<void> go_on(std::uint64_t tail_from, std::string_view tail);
  Result<void> keep(std::string_view blanked);
  void shorten_tail();

  std::filesystem::path name_;
  File file_;
  NameFilter filter_;
  Sha256 hash_;
  std::uint64_t received_ = 0, kept_ = 0;  // kept_: of NAME.part; the filter holds a few back
  std::uint64_t skip_ = 0;                 // of the filter's output that NAME.part has already
  std::string tail_;                       // the last bytes as they came
};

}  // namespace vacuform
