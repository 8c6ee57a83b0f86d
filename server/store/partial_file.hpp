// A file that arrives in pieces over many connections, without the names in it (api/redaction/names.hpp), and that survives a crash
// between them: what flush() has flushed is there again after kill -9 or a power cut.
//
// Two files stand under one name. NAME.part has the bytes as they will be kept, names blanked. NAME.state says how many
// bytes had come at the last flush and how many of them stood in NAME.part, and has what the filter remembered: it decides by
// what came before, and blanked bytes no longer tell all of that. After a restart the filter goes on as if nothing had been,
// and the hash goes once through NAME.part. The state is the only place where a name can stand, of at most a word of text or
// a segment of a JPEG (64 KiB) that has not ended yet; it goes when the file is complete or given up.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "api/redaction/names.hpp"
#include "server/store/blobs.hpp"

namespace vacuform {

class PartialFile {
 public:
  // Goes on with what stands under that name, or begins. `extension` as NameFilter takes it. Errors: unavailable,
  // unreadable.
  static Result<PartialFile> open(std::filesystem::path name, const std::string& extension);
  // How many bytes the last flush of that name left; 0 when there was none. Reads only that number.
  static Result<std::uint64_t> flushed(const std::filesystem::path& name);
  // Errors: unavailable.
  static Result<void> remove(const std::filesystem::path& name);
  // Whether a file of that name belongs to one; others beside them are nobody's.
  static bool is_one(const std::filesystem::path& file);

  std::uint64_t bytes() const { return received_; }
  // Takes the next bytes. They are lost in a crash before flush(). Errors: disk_full, unavailable.
  Result<void> take(std::string_view bytes);
  Result<void> flush();
  // Whether all bytes that were taken are flushed.
  bool is_flushed() const { return received_ == flushed_received_; }
  // Frees the space of what was taken since the last flush; then the file must be opened again.
  void drop_unflushed();
  // Ends the file and hands it over under a second name, `as`, on the same disk; nothing may be taken afterwards. What is
  // under the first name stays until remove(), so that a file that could not be kept is not lost.
  Result<Upload> finish(const std::filesystem::path& as);

 private:
  PartialFile(std::filesystem::path name, const std::string& extension)
      : name_(std::move(name)), filter_(extension) {}
  Result<void> begin();
  Result<void> hash_again();
  Result<void> keep(std::string_view blanked);

  std::filesystem::path name_;
  File file_;
  NameFilter filter_;
  Sha256 hash_;
  std::uint64_t received_ = 0, kept_ = 0;  // kept_: of NAME.part; the filter holds a few back
  std::uint64_t flushed_received_ = 0, flushed_kept_ = 0;
};

}  // namespace vacuform
