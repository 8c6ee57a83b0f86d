// A file on its way in, which still has the names that its sender left in it: on the disk it is encrypted, with a key of its
// own that stands elsewhere. Without the key nothing of it can be read, so it is deleted with its key.
//
// The file is a row of records: the length of a part (4 bytes, the lowest first), a random nonce (24), and the part with its
// tag, by XChaCha20-Poly1305 (libsodium; draft-irtf-cfrg-xchacha-03) over the number of the record. A record of length 0 marks
// what was flushed: what follows the last mark is gone after a crash. Nothing is ever written twice in one place.
//
// For another server that continues the file, what was flushed can be copied as pieces: the file in its order.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/base/byte_source.hpp"
#include "server/store/blob_store.hpp"

namespace vacuform {

// One thread at a time.
class SealedFile : public ByteSource {
 public:
  static std::string new_key();  // 64 hexadecimal digits

  // Continues the file, which is read through once, or starts one. What comes after the last mark, or after a damaged record,
  // is cut off. Errors: unavailable, unreadable (a part is missing).
  static Result<SealedFile> open(const std::filesystem::path& path, const std::string& key);
  // From all pieces, in their order; `open_piece` is called for each after the one before is done with. An earlier file of
  // that path goes. Errors: as above; unreadable also if they are not such pieces; those of `open_piece` and the readers.
  using OpenPiece = std::function<Result<std::unique_ptr<BlobReader>>(std::size_t number)>;
  static Result<SealedFile> of_pieces(const std::filesystem::path& path, const std::string& key,
                                      std::size_t pieces, const OpenPiece& open_piece);
  // A file that has no name and goes with this object, whose key only this process has. `path` is a new name on its disk.
  static Result<SealedFile> temporary(const std::filesystem::path& path);

  // How many have come.
  std::uint64_t bytes() const { return plain_ + held_.size(); }
  // Appends the next bytes. They are lost in a crash before flush(). Errors: disk_full, unavailable.
  Result<void> take(std::string_view bytes);
  Result<void> flush();
  bool is_flushed() const { return bytes() == flushed_plain_; }
  // Frees the space of the bytes since the last flush; then the file must be opened again.
  void drop_unflushed();
  // Writes what was flushed since the last piece.
  Result<void> write_piece(Upload& into);
  // What has come can be read afterwards.
  Result<void> seal();

  Result<std::uint64_t> size() const override { return plain_; }
  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const override;

 private:
  static constexpr std::size_t key_bytes = 32;
  struct Record {
    std::uint64_t number = 0;         // marks count
    std::uint64_t plain = 0, at = 0;  // where it begins, in the bytes that came and in the file
    std::size_t bytes = 0;            // of them
  };
  SealedFile(File file, const std::string& key);
  Result<void> read_records();
  // The part in a record; nothing if it is not whole.
  Result<std::optional<std::string>> part_at(std::uint64_t at, std::uint64_t number) const;
  Result<void> append(std::string_view part);

  File file_;
  std::array<unsigned char, key_bytes> key_{};
  std::vector<Record> records_;                                    // without marks
  std::uint64_t written_ = 0;                                      // the number of the next record
  std::uint64_t plain_ = 0, sealed_ = 0;                           // bytes in records, and of the file
  std::uint64_t flushed_plain_ = 0, flushed_ = 0, in_pieces_ = 0;  // the last two of the file
  std::string held_;                                               // less than a record
  mutable std::string open_;                                       // the part that was read last
  mutable std::size_t open_record_ = 0;
};

}  // namespace vacuform
