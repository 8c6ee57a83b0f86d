#include "server/store/partial_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <vector>

namespace vacuform {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t least_tail = 96 << 10;  // more than any filter holds back
constexpr std::size_t most_tail = 192 << 10;
constexpr std::size_t piece_size = 64 << 10;

fs::path part_of(fs::path name) { return name += ".part"; }
fs::path tail_of(fs::path name) { return name += ".tail"; }

struct Tail {
  std::uint64_t received = 0;
  std::string bytes;
};

// "<received>\n" and the bytes.
std::optional<Tail> parsed(std::string text) {
  Tail tail;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), tail.received);
  if (error != std::errc() || end == text.data() + text.size() || *end != '\n') return std::nullopt;
  text.erase(0, static_cast<std::size_t>(end - text.data()) + 1);
  tail.bytes = std::move(text);
  if (tail.bytes.size() > tail.received) return std::nullopt;
  return tail;
}

Result<std::optional<Tail>> read_tail(const fs::path& name) {
  auto text = read_text_file(tail_of(name), most_tail + piece_size + 64);
  if (!text && text.error().code == Code::not_found) return std::optional<Tail>();
  if (!text) return tl::make_unexpected(std::move(text.error()));
  return parsed(std::move(*text));
}

}  // namespace

Result<std::uint64_t> PartialFile::flushed(const fs::path& name) {
  VACUFORM_TRY(tail, read_tail(name));
  std::error_code error;
  return tail && fs::exists(part_of(name), error) ? tail->received : 0;
}

void PartialFile::remove(const fs::path& name) {
  ::unlink(tail_of(name).c_str());
  ::unlink(part_of(name).c_str());
}

Result<PartialFile> PartialFile::open(fs::path name, const std::string& extension) {
  PartialFile file(std::move(name), extension);
  VACUFORM_TRY(tail, read_tail(file.name_));
  file.file_ = File(::open(part_of(file.name_).c_str(), O_RDWR | O_CLOEXEC));
  if (tail && file.file_.is_open()) {
    VACUFORM_CHECK(file.go_on(tail->received - tail->bytes.size(), tail->bytes));
  } else {
    VACUFORM_CHECK(file.begin());
  }
  return file;
}

Result<void> PartialFile::begin() {
  remove(name_);
  VACUFORM_TRY(file, File::create(part_of(name_)));
  file_ = std::move(file);
  return {};
}

Result<void> PartialFile::go_on(std::uint64_t tail_from, std::string_view tail) {
  std::vector<char> piece(piece_size);
  while (kept_ < tail_from) {
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(piece.size(), tail_from - kept_));
    VACUFORM_TRY(n, file_.read_at(kept_, {piece.data(), wanted}));
    if (n == 0) return fail(Code::unreadable, "a part of an upload is missing", {}, "begin it again");
    const std::string_view bytes(piece.data(), n);
    hash_.add(bytes);
    skip_ += n - filter_.pass(bytes).size();
    kept_ += n;
  }
  received_ = tail_from;
  if (::ftruncate(file_.descriptor(), static_cast<off_t>(tail_from)) != 0 ||
      ::lseek(file_.descriptor(), 0, SEEK_END) < 0)
    return fail(Code::unavailable, "an upload cannot be gone on with", {}, "begin it again");
  return take(tail);
}

Result<void> PartialFile::keep(std::string_view blanked) {
  const auto known = static_cast<std::size_t>(std::min<std::uint64_t>(skip_, blanked.size()));
  skip_ -= known;
  blanked.remove_prefix(known);
  hash_.add(blanked);
  kept_ += blanked.size();
  return file_.write(blanked);
}

Result<void> PartialFile::take(std::string_view bytes) {
  for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), piece_size))) {
    const std::string_view piece = bytes.substr(0, piece_size);
    VACUFORM_CHECK(keep(filter_.pass(piece)));
    received_ += piece.size();
    tail_ += piece;
    shorten_tail();
  }
  return {};
}

void PartialFile::shorten_tail() {
  if (tail_.size() <= most_tail) return;
  const std::size_t latest = tail_.size() - least_tail, line = tail_.rfind('\n', latest - 1);
  tail_.erase(0, line == std::string::npos || tail_.size() - line > most_tail ? latest : line + 1);
}

Result<void> PartialFile::flush() {
  VACUFORM_CHECK(file_.sync());
  return write_text_file(tail_of(name_), std::to_string(received_) + "\n" + tail_);
}

Result<Upload> PartialFile::finish() {
  VACUFORM_CHECK(keep(filter_.finish()));
  VACUFORM_CHECK(file_.sync());
  return Blobs::adopt(part_of(name_), {hash_.hex(), kept_});
}

}  // namespace vacuform
