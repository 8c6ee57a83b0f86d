#include "api/redaction/redaction.hpp"

#include <algorithm>
#include <cstring>

#include "api/base/patient_space.hpp"
#include "api/base/stl_bodies.hpp"
#include "api/base/text.hpp"
#include "api/redaction/formats.hpp"
#include "api/redaction/gunzip.hpp"

namespace vacuform {

namespace redaction {

namespace {

constexpr std::size_t stl_head = stl_head_bytes;  // 80 bytes of anything, then the count
constexpr std::size_t piece_bytes = 64 << 10;

bool has_control(std::string_view text) {
  return std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 9; });
}

// Files that are taken for others by mistake; what refuses them says what they are.
bool foreign(std::string_view head) {
  constexpr std::string_view marks[] = {"PK\x03\x04", "\x1f\x8b", "Kaydara FBX"};
  return std::any_of(std::begin(marks), std::end(marks), [&](auto mark) { return head.starts_with(mark); });
}

// The heads are free text, of which only the axes stay. Bytes behind the triangles that the reader refuses are made
// unreadable, and others are left out.
Result<void> binary_stl(const ByteSource& file, Cursor& in, Copy& out) {
  VACUFORM_TRY(found, find_stl_bodies(file));
  for (const StlBodies::Body& body : found.bodies) {
    VACUFORM_TRY(head, in.take(stl_head));
    const NamedSpace named = find_space(head.substr(0, 80));
    std::string text(named.size == 0 ? "" : "SPACE=");
    text.append(name(named.space)).resize(80, ' ');
    VACUFORM_CHECK(out.write(text.append(head.substr(80))));
    VACUFORM_CHECK(out.from(in, stl_record_bytes * body.triangles));
  }
  if (found.rest != StlBodies::Rest::unknown) return {};
  for (std::uint64_t left = found.rest_bytes; left > 0;) {
    const std::uint64_t n = std::min<std::uint64_t>(left, piece_bytes);
    VACUFORM_CHECK(out.write(std::string(n, '\x7f')));
    left -= n;
  }
  return {};
}

tl::unexpected<Error> too_long(const char* what, std::size_t longest) {
  return fail(
      Code::too_large,
      std::string("a ") + what + " of the file is longer than " + std::to_string(longest >> 20) + " MiB", {},
      "export it again");
}

Result<void> as_it_is(Cursor& in, Copy& out) { return out.from(in, all_bytes); }

// What a file without a magic number is, by its first text and its extension.
Result<void> some_text(std::string_view head, const std::string& extension, Cursor& in, Copy& out) {
  const std::string_view first = head.substr(std::min(head.find_first_not_of(" \t\r\n"), head.size()));
  if (lower(first.substr(0, 5)) == "solid") return text(TextKind::stl, in, out);
  if (extension == "csv" || extension == "txt") return text(TextKind::csv, in, out);
  if (extension == "off" || first.find("OFF") <= 4) return text(TextKind::off, in, out);
  constexpr std::string_view begins_obj = "#vfogusmlp";
  if (first.starts_with("v ") || first.starts_with("mtllib ") ||
      ((extension == "obj" || extension.empty()) && !first.empty() &&
       begins_obj.find(first[0]) != std::string_view::npos))
    return text(TextKind::obj, in, out);
  return as_it_is(in, out);
}

// Extensions of files that are no drawings.
bool is_scan(const std::string& extension) {
  constexpr std::string_view scans[] = {"stl", "obj", "ply", "off", "glb", "zip", "csv", "txt", "icc", "icm"};
  return one_of(extension, scans);
}

bool begins_wide_xml(std::string_view head) {
  using namespace std::string_view_literals;
  // UTF-16 with a mark, or without one.
  return head.starts_with("\xff\xfe"sv) || head.starts_with("\xfe\xff"sv) || head.starts_with("<\0"sv) ||
         head.starts_with("\0<"sv);
}

Result<void> redacted(const ByteSource& file, const std::string& extension, Copy& out) {
  Cursor in(file);
  VACUFORM_TRY(size, file.size());
  VACUFORM_TRY(first, in.peek(stl_head));
  std::string head(first);
  if (begins_png(head)) return png(in, out);
  if (begins_jpeg(head)) return jpeg(in, out);
  if (head.starts_with("glTF")) return glb(in, size, out);
  if (head.starts_with("PK\x03\x04") && extension == "zip") return zip(file, out);
  if (head.starts_with(gzip_mark) && !is_scan(extension)) {
    VACUFORM_TRY(content, gunzip(file, most_svg));
    // What is no SVG is refused later, packed as it is.
    if (const std::string_view begin = trimmed(content);
        begins_wide_xml(content) || begin.starts_with('<') || begin.starts_with("\xef\xbb\xbf<"))
      return svg(MemorySource(content), out);
    return as_it_is(in, out);
  }
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return ply(in, out);
  // The count of a file of at most 1 GiB has a zero or a one in its highest byte, and no text has that. Some programs
  // leave it at its largest value.
  const bool counts = head.size() == stl_head && !foreign(head) &&
                      (has_control(head.substr(80)) || head.substr(80) == "\xff\xff\xff\xff");
  if (counts && (extension == "stl" || extension.empty() || head.starts_with("solid")))
    return binary_stl(file, in, out);
  const bool wide = begins_wide_xml(head);
  if (has_control(head) && !wide) return as_it_is(in, out);
  if (head.starts_with("\xef\xbb\xbf")) {  // that of UTF-8
    head.erase(0, 3);
    in.drop(3);
  }
  const std::string begin = lower(trimmed(head));
  const bool page = begin.starts_with("<html") || begin.starts_with("<!doctype html");
  if (!page && (begin.starts_with('<') || (wide && !is_scan(extension)))) return svg(file, out);
  if (!is_scan(extension) && begins_dxf(head)) return dxf(in, out);
  return some_text(head, extension, in, out);
}

}  // namespace

Cursor::Cursor(const ByteSource& source)
    : pull_([&source, at = std::uint64_t{0}](std::span<char> into) mutable -> Result<std::size_t> {
        VACUFORM_TRY(n, source.read_at(at, into));
        at += n;
        return n;
      }) {}

Cursor::Cursor(std::string_view bytes)
    : pull_([bytes](std::span<char> into) mutable -> Result<std::size_t> {
        const std::size_t n = bytes.copy(into.data(), into.size());
        bytes.remove_prefix(n);
        return n;
      }) {}

// Reads the next piece behind what is held. False at the end.
Result<bool> Cursor::more() {
  if (ended_) return false;
  held_.erase(0, begin_);
  begin_ = 0;
  const std::size_t had = held_.size();
  held_.resize(had + piece_bytes);
  VACUFORM_TRY(n, pull_({held_.data() + had, piece_bytes}));
  held_.resize(had + n);
  ended_ = n == 0;
  return !ended_;
}

Result<std::string_view> Cursor::peek(std::size_t bytes) {
  while (held_.size() - begin_ < bytes) {
    VACUFORM_TRY(found, more());
    if (!found) break;
  }
  return rest().substr(0, bytes);
}

Result<std::string_view> Cursor::take(std::size_t bytes) {
  VACUFORM_TRY(found, peek(bytes));
  drop(found.size());
  return found;
}

Result<std::uint64_t> Cursor::skip(std::uint64_t bytes) {
  std::uint64_t skipped = 0;
  while (skipped < bytes) {
    VACUFORM_TRY(found, some());
    if (found.empty()) break;
    const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(bytes - skipped, found.size()));
    drop(n);
    skipped += n;
  }
  return skipped;
}

Result<std::string_view> Cursor::line(std::size_t longest) {
  for (std::size_t seen = 0;;) {
    const std::string_view held = rest();
    while (seen < held.size() && held[seen] != '\n' && held[seen] != '\r') ++seen;
    if (seen > longest) return too_long("line", longest);
    const bool whole = seen < held.size() && (held[seen] == '\n' || seen + 1 < held.size());
    if (!whole) {
      VACUFORM_TRY(found, more());
      if (found) continue;
    }
    return take(seen + (rest().substr(seen).starts_with("\r\n") ? 2 : 1));
  }
}

Result<std::string> Cursor::word() {
  std::string word;
  for (;;) {
    VACUFORM_TRY(found, some());
    std::size_t end = 0;
    while (end < found.size() && !is_white(found[end])) ++end;
    word += found.substr(0, end);
    const bool ended = end < found.size() || found.empty();
    drop(end);
    if (ended) return word;
    if (word.size() > longest_line) return too_long("word", longest_line);
  }
}

Result<void> Copy::write(std::string_view bytes) {
  bytes_ += bytes.size();
  held_ += bytes;
  return held_.size() < piece_bytes ? Result<void>() : end();
}

Result<void> Copy::zeros(std::uint64_t count) {
  const std::string zeros(static_cast<std::size_t>(std::min<std::uint64_t>(count, piece_bytes)), '\0');
  for (; count > zeros.size(); count -= zeros.size()) VACUFORM_CHECK(write(zeros));
  return write(std::string_view(zeros).substr(0, static_cast<std::size_t>(count)));
}

Result<void> Copy::from(Cursor& in, std::uint64_t count) {
  while (count > 0) {
    VACUFORM_TRY(some, in.some());
    if (some.empty()) return {};
    some = some.substr(0, static_cast<std::size_t>(std::min<std::uint64_t>(count, some.size())));
    VACUFORM_CHECK(write(some));
    in.drop(some.size());
    count -= some.size();
  }
  return {};
}

Result<void> Copy::end() {
  VACUFORM_CHECK(sink_(held_));
  held_.clear();
  return {};
}

}  // namespace redaction

Result<void> redact(const ByteSource& file, const std::string& extension, const ByteSink& out) {
  redaction::Copy copy(out);
  VACUFORM_CHECK(redaction::redacted(file, extension, copy));
  return copy.end();
}

Result<void> redact(std::vector<std::uint8_t>& bytes, const std::string& file_name) {
  const std::size_t dot = file_name.rfind('.');
  std::vector<std::uint8_t> copy;
  copy.reserve(bytes.size());
  const MemorySource file({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  const auto keep = [&](std::string_view piece) -> Result<void> {
    copy.insert(copy.end(), piece.begin(), piece.end());
    return {};
  };
  VACUFORM_CHECK(redact(file, dot == std::string::npos ? "" : lower(file_name.substr(dot + 1)), keep));
  bytes = std::move(copy);
  return {};
}

}  // namespace vacuform
