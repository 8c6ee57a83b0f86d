#include "api/base/stl_bodies.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string_view>

namespace vacuform {

namespace {

constexpr std::size_t most_bodies = 1000;
constexpr std::uint64_t unknown_count = 0xFFFFFFFF;  // of programs that never come back to the head
constexpr float largest_number = 1e7f;
constexpr double most_doubtful = 0.1;  // of the records

std::uint32_t word_at(const char* bytes) {
  std::uint32_t word = 0;
  for (int i = 3; i >= 0; --i) word = word << 8 | static_cast<unsigned char>(bytes[i]);
  return word;
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

bool is_idle(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte == 0 || (byte >= 9 && byte <= 13) || (byte >= 32 && byte != 127);
}

// Text has three letters in a row. Numbers seldom look like text of more than ASCII, and never like ASCII throughout.
enum class Looks { numbers, doubtful, text };
Looks looks_of(std::string_view record) {
  int letters = 0, most = 0;
  bool idle = true, ascii = true;
  for (const char c : record) {
    idle = idle && is_idle(c);
    ascii = ascii && static_cast<unsigned char>(c) < 0x80;
    letters = is_letter(c) ? letters + 1 : 0;
    most = std::max(most, letters);
  }
  if (idle && most >= 3) return ascii ? Looks::text : Looks::doubtful;
  for (std::size_t i = 0; i < 12; ++i) {
    const auto number = std::bit_cast<float>(word_at(record.data() + 4 * i));
    if (!(std::abs(number) <= largest_number)) return Looks::text;
    // Text in UTF-16 is made of these.
    if (std::fpclassify(number) == FP_SUBNORMAL) return Looks::doubtful;
  }
  return Looks::numbers;
}

struct RestKind {
  bool records = true, idle = true, zeros = true;
};

Result<void> fill(const ByteSource& file, std::uint64_t at, std::span<char> into) {
  for (std::size_t had = 0; had < into.size();) {
    VACUFORM_TRY(n, file.read_at(at + had, into.subspan(had)));
    if (n == 0) return fail(Code::unreadable, "the file became shorter while it was read", {}, "try again");
    had += n;
  }
  return {};
}

Result<RestKind> look_at(const ByteSource& file, std::uint64_t begin, std::uint64_t size) {
  RestKind kind;
  kind.records = (size - begin) % stl_record_bytes == 0;
  std::uint64_t doubtful = 0;
  std::array<char, 1000 * stl_record_bytes> piece;
  for (std::uint64_t at = begin; at < size && (kind.records || kind.idle);) {
    const std::span<char> part(piece.data(), std::min<std::uint64_t>(piece.size(), size - at));
    VACUFORM_CHECK(fill(file, at, part));
    const std::string_view text(part.data(), part.size());
    kind.zeros = kind.zeros && text.find_first_not_of('\0') == std::string_view::npos;
    kind.idle = kind.idle && std::all_of(text.begin(), text.end(), is_idle);
    for (std::size_t i = 0; kind.records && i < text.size(); i += stl_record_bytes) {
      const Looks looks = looks_of(text.substr(i, stl_record_bytes));
      kind.records = looks != Looks::text;
      doubtful += looks == Looks::doubtful;
    }
    at += part.size();
  }
  kind.records = kind.records && most_doubtful * static_cast<double>(size - begin) >=
                                     static_cast<double>(stl_record_bytes * doubtful);
  return kind;
}

}  // namespace

Result<StlBodies> find_stl_bodies(const ByteSource& file) {
  VACUFORM_TRY(size, file.size());
  StlBodies found;
  std::uint64_t at = 0;
  while (at + stl_head_bytes <= size && found.bodies.size() < most_bodies) {
    std::array<char, 4> count{};
    VACUFORM_CHECK(fill(file, at + stl_head_bytes - 4, count));
    const StlBodies::Body body{at, word_at(count.data())};
    if (at == 0) {
      found.declared = body.triangles;
      found.bodies.push_back(body);
      if (body.end() > size) break;
    } else if (body.triangles == 0 || body.end() > size) {
      break;
    } else {
      found.bodies.push_back(body);
    }
    at = body.end();
  }
  StlBodies::Body& first = found.bodies.front();
  const std::uint64_t records = (size - stl_head_bytes) / stl_record_bytes;
  if (first.end() > size) {
    if (found.declared == unknown_count && records > 0 && (size - stl_head_bytes) % stl_record_bytes == 0)
      first.triangles = records;
    return found;
  }
  if (at == size) return found;
  VACUFORM_TRY(kind, look_at(file, first.end(), size));
  if (kind.records && !kind.zeros) {
    first.triangles = records;
    found.bodies.resize(1);
    return found;
  }
  if (found.bodies.size() > 1) {
    VACUFORM_TRY(behind, look_at(file, at, size));
    kind = behind;
  }
  found.rest_bytes = size - at;
  found.rest = kind.idle ? StlBodies::Rest::idle : StlBodies::Rest::unknown;
  return found;
}

}  // namespace vacuform
