#include "server/store/sealed_file.hpp"

#include <fcntl.h>
#include <sodium.h>
#include <unistd.h>

#include <algorithm>

#include "api/base/secrets.hpp"
#include "server/store/incoming.hpp"

namespace vacuform {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_part = 64 << 10, length_bytes = 4,
                      nonce_bytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES,
                      tag_bytes = crypto_aead_xchacha20poly1305_ietf_ABYTES,
                      head_bytes = length_bytes + nonce_bytes;

const unsigned char* bytes_of(const char* text) { return reinterpret_cast<const unsigned char*>(text); }
unsigned char* bytes_of(char* text) { return reinterpret_cast<unsigned char*>(text); }

std::array<unsigned char, 8> little_endian(std::uint64_t number) {
  std::array<unsigned char, 8> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<unsigned char>(number >> (8 * i));
  return bytes;
}

tl::unexpected<Error> cannot_resume() {
  return fail(Code::unreadable, "an upload cannot be resumed", {}, "begin it again");
}

// Reads until the span is full. False if the bytes end before.
Result<bool> read_whole(const File& file, std::uint64_t at, std::span<char> into) {
  while (!into.empty()) {
    VACUFORM_TRY(n, file.read_at(at, into));
    if (n == 0) return false;
    at += n;
    into = into.subspan(n);
  }
  return true;
}

}  // namespace

std::string SealedFile::new_key() { return random_hex(key_bytes); }

SealedFile::SealedFile(File file, const std::string& key) : file_(std::move(file)) {
  static_assert(key_bytes == crypto_aead_xchacha20poly1305_ietf_KEYBYTES);
  sodium_hex2bin(key_.data(), key_.size(), key.data(), key.size(), nullptr, nullptr, nullptr);
}

Result<SealedFile> SealedFile::open(const fs::path& path, const std::string& key) {
  File existing(::open(path.c_str(), O_RDWR | O_CLOEXEC));
  if (!existing.is_open()) {
    VACUFORM_TRY(created, File::create(path));
    existing = std::move(created);
  }
  SealedFile file(std::move(existing), key);
  VACUFORM_CHECK(file.read_records());
  return file;
}

Result<SealedFile> SealedFile::temporary(const fs::path& path) {
  VACUFORM_TRY(created, File::create(path));
  VACUFORM_CHECK(delete_file(path));
  return SealedFile(std::move(created), new_key());
}

Result<SealedFile> SealedFile::of_pieces(const fs::path& path, const std::string& key, std::size_t pieces,
                                         const OpenPiece& open_piece) {
  VACUFORM_CHECK(delete_file(path));
  {
    VACUFORM_TRY(created, File::create(path));
    std::vector<char> bytes(most_part);
    for (std::size_t i = 0; i < pieces; ++i) {
      VACUFORM_TRY(piece, open_piece(i));
      for (std::uint64_t at = 0;;) {
        VACUFORM_TRY(n, piece->read_at(at, bytes));
        if (n == 0) break;
        VACUFORM_CHECK(created.write({bytes.data(), n}));
        at += n;
      }
    }
  }
  std::error_code error;
  const std::uint64_t whole = fs::file_size(path, error);
  VACUFORM_TRY(file, open(path, key));
  if (error || file.flushed_ != whole) return cannot_resume();
  file.in_pieces_ = file.flushed_;
  return file;
}

Result<std::optional<std::string>> SealedFile::part_at(std::uint64_t at, std::uint64_t number) const {
  std::array<char, head_bytes> head{};
  VACUFORM_TRY(has_head, read_whole(file_, at, head));
  std::size_t bytes = 0;
  for (std::size_t i = length_bytes; i-- > 0;) bytes = bytes << 8 | static_cast<unsigned char>(head[i]);
  if (!has_head || bytes > most_part) return std::optional<std::string>();
  std::string sealed(bytes + tag_bytes, '\0'), part(bytes, '\0');
  VACUFORM_TRY(whole, read_whole(file_, at + head_bytes, sealed));
  const auto place = little_endian(number);
  if (!whole || crypto_aead_xchacha20poly1305_ietf_decrypt(
                    bytes_of(part.data()), nullptr, nullptr, bytes_of(sealed.data()), sealed.size(),
                    place.data(), place.size(), bytes_of(head.data()) + length_bytes, key_.data()) != 0)
    return std::optional<std::string>();
  return std::optional(std::move(part));
}

Result<void> SealedFile::read_records() {
  std::uint64_t at = 0, plain = 0, number = 0;
  std::vector<Record> since_mark;
  for (;;) {
    VACUFORM_TRY(part, part_at(at, number));
    if (!part) break;
    if (!part->empty()) since_mark.push_back({number, plain, at, part->size()});
    plain += part->size();
    at += head_bytes + part->size() + tag_bytes;
    ++number;
    if (!part->empty()) continue;
    records_.insert(records_.end(), since_mark.begin(), since_mark.end());
    since_mark.clear();
    written_ = number;
    plain_ = flushed_plain_ = plain;
    sealed_ = flushed_ = at;
  }
  if (::ftruncate(file_.descriptor(), static_cast<off_t>(sealed_)) != 0 ||
      ::lseek(file_.descriptor(), 0, SEEK_END) < 0)
    return fail(Code::unavailable, "an upload cannot be resumed", {}, "begin it again");
  return {};
}

Result<void> SealedFile::append(std::string_view part) {
  std::string record(head_bytes + part.size() + tag_bytes, '\0');
  const auto length = little_endian(part.size()), number = little_endian(written_);
  std::copy_n(length.begin(), length_bytes, record.begin());
  unsigned char* const nonce = bytes_of(record.data()) + length_bytes;
  randombytes_buf(nonce, nonce_bytes);
  crypto_aead_xchacha20poly1305_ietf_encrypt(bytes_of(record.data()) + head_bytes, nullptr,
                                             bytes_of(part.data()), part.size(), number.data(), number.size(),
                                             nullptr, nonce, key_.data());
  if (auto written = file_.write(record); !written) {  // on a full disk a part of it
    if (::ftruncate(file_.descriptor(), static_cast<off_t>(sealed_)) == 0)
      ::lseek(file_.descriptor(), 0, SEEK_END);
    return written;
  }
  if (!part.empty()) records_.push_back({written_, plain_, sealed_, part.size()});
  ++written_;
  plain_ += part.size();
  sealed_ += record.size();
  return {};
}

Result<void> SealedFile::take(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::string_view some = bytes.substr(0, most_part - held_.size());
    held_ += some;
    bytes.remove_prefix(some.size());
    if (held_.size() == most_part) VACUFORM_CHECK(seal());
  }
  return {};
}

Result<void> SealedFile::seal() {
  if (held_.empty()) return {};
  VACUFORM_CHECK(append(held_));
  held_.clear();
  return {};
}

Result<void> SealedFile::flush() {
  if (is_flushed()) return {};
  VACUFORM_CHECK(seal());
  VACUFORM_CHECK(append({}));
  VACUFORM_CHECK(file_.sync());
  flushed_plain_ = plain_;
  flushed_ = sealed_;
  return {};
}

void SealedFile::drop_unflushed() {
  (void)!::ftruncate(file_.descriptor(), static_cast<off_t>(flushed_));  // otherwise open() truncates it
}

Result<void> SealedFile::write_piece(Upload& into) {
  std::vector<char> bytes(most_part);
  while (in_pieces_ < flushed_) {
    const auto wanted =
        static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), flushed_ - in_pieces_));
    VACUFORM_TRY(n, file_.read_at(in_pieces_, {bytes.data(), wanted}));
    if (n == 0) return fail(Code::unreadable, "a part of an upload is missing", {}, "begin it again");
    VACUFORM_CHECK(into.write({bytes.data(), n}));
    in_pieces_ += n;
  }
  return {};
}

Result<std::size_t> SealedFile::read_at(std::uint64_t offset, std::span<char> into) const {
  const auto after =
      std::upper_bound(records_.begin(), records_.end(), offset,
                       [](std::uint64_t at, const Record& record) { return at < record.plain; });
  if (after == records_.begin()) return 0;
  const Record& record = *(after - 1);
  if (offset - record.plain >= record.bytes) return 0;
  const auto index = static_cast<std::size_t>(after - records_.begin());  // from 1; 0: no record yet
  if (open_record_ != index) {
    VACUFORM_TRY(part, part_at(record.at, record.number));
    if (!part) return fail(Code::unreadable, "a part of an upload is damaged", {}, "begin it again");
    open_ = *std::move(part);
    open_record_ = index;
  }
  return open_.copy(into.data(), into.size(), static_cast<std::size_t>(offset - record.plain));
}

}  // namespace vacuform
