// A file that arrives in pieces over many connections, without the names in it (api/redaction/names.hpp), and that
// survives a crash between them: bytes flushed by flush() are still there after kill -9 or a power cut.
//
// Each name has two files. NAME.part contains the bytes to store, with names blanked. NAME.state contains the number of
// bytes received at the last flush, how many of them are in NAME.part, and the state of the filter: the filter decides
// by the preceding bytes, and blanked bytes no longer contain all of that. After a restart the filter continues from
// its state, and NAME.part is hashed once. A zip has no state: after a restart it begins again. Only the state can
// contain a name, at most a word of text or an unfinished segment of a JPEG (64 KiB); it is deleted when the file is
// complete or abandoned.
//
// For another server that may continue the file, what was flushed can be written as pieces: the length of NAME.state in
// decimal, a line feed, NAME.state, and the bytes of NAME.part since the piece before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "api/redaction/names.hpp"
#include "server/store/blob_store.hpp"

namespace vacuform {

class PartialFile {
 public:
  // Continues the file of that name, or starts one. `extension` as for NameFilter. Errors: unavailable, unreadable.
  static Result<PartialFile> open(std::filesystem::path name, const std::string& extension);
  // How many bytes the last flush of that name left; 0 if there was none. Reads only that number.
  static Result<std::uint64_t> flushed(const std::filesystem::path& name);
  // Errors: unavailable.
  static Result<void> remove(const std::filesystem::path& name);
  // Makes the file of that name from all pieces that write_piece() gave, and opens it; an earlier file of that name goes.
  // `open_piece` is called for each, in their order, after the one before is done with. Errors: unavailable, unreadable
  // (they are not such pieces), and those of `open_piece` and the readers.
  using OpenPiece = std::function<Result<std::unique_ptr<BlobReader>>(std::size_t number)>;
  static Result<PartialFile> of_pieces(std::filesystem::path name, const std::string& extension,
                                       std::size_t pieces, const OpenPiece& open_piece);
  // Whether a file of that name is one of these two; other files do not belong to the upload.
  static bool is_one(const std::filesystem::path& file);

  std::uint64_t bytes() const { return received_; }
  // Appends the next bytes. They are lost in a crash before flush(). Errors: disk_full, unavailable.
  Result<void> take(std::string_view bytes);
  Result<void> flush();
  // Whether the file can be continued from its state, by open() or of_pieces(): a zip cannot.
  bool can_go_on() const { return filter_.can_go_on(); }
  // Writes the state of the last flush, and the bytes that were flushed since the last piece.
  Result<void> write_piece(Upload& into);
  // Whether all appended bytes are flushed.
  bool is_flushed() const { return received_ == flushed_received_; }
  // Frees the space of the bytes since the last flush; then the file must be opened again.
  void drop_unflushed();
  // Ends the file and provides it under a second name, `as`, on the same disk; no bytes may be appended afterwards. The
  // file under the first name stays until remove(), so that a file that could not be stored is not lost.
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
  std::uint64_t in_pieces_ = 0;  // of NAME.part
};

}  // namespace vacuform
