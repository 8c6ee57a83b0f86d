#include "server/store/partial_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <initializer_list>
#include <optional>
#include <system_error>
#include <vector>

#include "server/store/file_blobs.hpp"

namespace vacuform {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t piece_size = 64 << 10;
constexpr std::size_t most_state = 4 << 20;  // more than the state of any filter

fs::path part_of(fs::path name) { return name += ".part"; }
fs::path state_of(fs::path name) { return name += ".state"; }

struct State {
  std::uint64_t received = 0, kept = 0;
  std::string filter;
};

// Reads the numbers of a line, each with the character after it; what follows them in the text is left in it. False if
// the text begins otherwise.
bool take_numbers(std::string_view& text,
                  std::initializer_list<std::pair<std::uint64_t*, char>> numbers_and_marks) {
  for (const auto& [number, mark] : numbers_and_marks) {
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, *number);
    if (error != std::errc() || stop == end || *stop != mark) return false;
    text.remove_prefix(static_cast<std::size_t>(stop + 1 - text.data()));
  }
  return true;
}

// "<received> <kept>\n" and the state of the filter; nullopt if it is missing or invalid.
Result<std::optional<State>> read_state(const fs::path& name) {
  auto text = read_text_file(state_of(name), most_state);
  if (!text && text.error().code == Code::not_found) return std::optional<State>();
  if (!text) return tl::make_unexpected(std::move(text.error()));
  State state;
  std::string_view rest = *text;
  if (!take_numbers(rest, {{&state.received, ' '}, {&state.kept, '\n'}})) return std::optional<State>();
  state.filter = rest;
  return state.kept <= state.received ? std::optional(std::move(state)) : std::nullopt;
}

tl::unexpected<Error> cannot_resume() {
  return fail(Code::unreadable, "an upload cannot be resumed", {}, "begin it again");
}

// Appends a piece's bytes to the file. Gives the state in the piece.
Result<std::string> append_piece(const BlobReader& piece, File& file) {
  std::string state(32, '\0');
  VACUFORM_TRY(started, piece.read_at(0, state));
  state.resize(started);
  std::string_view rest = state;
  std::uint64_t length = 0;
  if (!take_numbers(rest, {{&length, '\n'}}) || length > most_state) return cannot_resume();
  std::uint64_t at = state.size() - rest.size();
  state.resize(length);
  for (std::size_t had = 0; had < length;) {
    VACUFORM_TRY(n, piece.read_at(at, {state.data() + had, length - had}));
    if (n == 0) return cannot_resume();
    had += n, at += n;
  }
  for (std::vector<char> bytes(piece_size);;) {
    VACUFORM_TRY(n, piece.read_at(at, bytes));
    if (n == 0) return state;
    VACUFORM_CHECK(file.write({bytes.data(), n}));
    at += n;
  }
}

}  // namespace

Result<std::uint64_t> PartialFile::flushed(const fs::path& name) {
  VACUFORM_TRY(state, read_state(name));
  std::error_code error;
  return state && fs::exists(part_of(name), error) ? state->received : 0;
}

bool PartialFile::is_one(const fs::path& file) {
  return file.extension() == ".part" || file.extension() == ".state";
}

Result<void> PartialFile::remove(const fs::path& name) {
  VACUFORM_CHECK(delete_file(state_of(name)));
  return delete_file(part_of(name));
}

Result<PartialFile> PartialFile::open(fs::path name, const std::string& extension) {
  PartialFile file(std::move(name), extension);
  VACUFORM_TRY(state, read_state(file.name_));
  file.file_ = File(::open(part_of(file.name_).c_str(), O_RDWR | O_CLOEXEC));
  if (!state || !file.file_.is_open()) {
    VACUFORM_CHECK(file.begin());
    return file;
  }
  if (!file.filter_.go_on(state->filter)) return cannot_resume();
  file.received_ = file.flushed_received_ = state->received;
  file.kept_ = file.flushed_kept_ = state->kept;
  VACUFORM_CHECK(file.hash_again());
  return file;
}

Result<PartialFile> PartialFile::of_pieces(fs::path name, const std::string& extension, std::size_t pieces,
                                           const OpenPiece& open_piece) {
  VACUFORM_CHECK(remove(name));
  {
    VACUFORM_TRY(part, File::create(part_of(name)));
    std::string state;
    for (std::size_t i = 0; i < pieces; ++i) {
      VACUFORM_TRY(piece, open_piece(i));
      VACUFORM_TRY(last, append_piece(*piece, part));
      state = std::move(last);
    }
    VACUFORM_CHECK(write_text_file(state_of(name), state));
  }
  VACUFORM_TRY(file, open(std::move(name), extension));
  file.in_pieces_ = file.kept_;
  return file;
}

Result<void> PartialFile::write_piece(Upload& into) {
  VACUFORM_TRY(state, read_text_file(state_of(name_), most_state));
  VACUFORM_CHECK(into.write(std::to_string(state.size()) + "\n" + state));
  std::vector<char> bytes(piece_size);
  while (in_pieces_ < flushed_kept_) {
    const auto wanted =
        static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), flushed_kept_ - in_pieces_));
    VACUFORM_TRY(n, file_.read_at(in_pieces_, {bytes.data(), wanted}));
    if (n == 0) return fail(Code::unreadable, "a part of an upload is missing", {}, "begin it again");
    VACUFORM_CHECK(into.write({bytes.data(), n}));
    in_pieces_ += n;
  }
  return {};
}

Result<void> PartialFile::begin() {
  VACUFORM_CHECK(remove(name_));
  VACUFORM_TRY(file, File::create(part_of(name_)));
  file_ = std::move(file);
  return {};
}

// Truncates the file to its length at the last flush.
Result<void> PartialFile::hash_again() {
  std::vector<char> piece(piece_size);
  for (std::uint64_t at = 0; at < kept_;) {
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(piece.size(), kept_ - at));
    VACUFORM_TRY(n, file_.read_at(at, {piece.data(), wanted}));
    if (n == 0) return fail(Code::unreadable, "a part of an upload is missing", {}, "begin it again");
    hash_.add(std::string_view(piece.data(), n));
    at += n;
  }
  if (::ftruncate(file_.descriptor(), static_cast<off_t>(kept_)) != 0 ||
      ::lseek(file_.descriptor(), 0, SEEK_END) < 0)
    return fail(Code::unavailable, "an upload cannot be resumed", {}, "begin it again");
  return {};
}

Result<void> PartialFile::keep(std::string_view blanked) {
  hash_.add(blanked);
  kept_ += blanked.size();
  return file_.write(blanked);
}

Result<void> PartialFile::take(std::string_view bytes) {
  for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), piece_size))) {
    const std::string_view piece = bytes.substr(0, piece_size);
    VACUFORM_CHECK(keep(filter_.pass(piece)));
    VACUFORM_CHECK(filter_.check());
    received_ += piece.size();
  }
  return {};
}

Result<void> PartialFile::flush() {
  VACUFORM_CHECK(file_.sync());
  // Without a state the file begins again after a restart.
  if (filter_.can_go_on())
    VACUFORM_CHECK(write_text_file(
        state_of(name_), std::to_string(received_) + " " + std::to_string(kept_) + "\n" + filter_.state()));
  flushed_received_ = received_;
  flushed_kept_ = kept_;
  return {};
}

void PartialFile::drop_unflushed() {
  (void)!::ftruncate(file_.descriptor(), static_cast<off_t>(flushed_kept_));  // otherwise open() truncates it
}

Result<Upload> PartialFile::finish(const fs::path& as) {
  VACUFORM_CHECK(keep(filter_.finish()));
  VACUFORM_CHECK(filter_.check());
  VACUFORM_CHECK(file_.sync());
  // If the file system does not support hard links, the file is moved.
  if (::link(part_of(name_).c_str(), as.c_str()) != 0 && ::rename(part_of(name_).c_str(), as.c_str()) != 0)
    return fail(errno == ENOSPC || errno == EDQUOT ? Code::disk_full : Code::unavailable,
                "an upload cannot be kept: " + std::generic_category().message(errno), {},
                "check that the server may write to its data folder, and that its disk has room");
  return Upload::of_file(as, {hash_.hex(), kept_});
}

}  // namespace vacuform
