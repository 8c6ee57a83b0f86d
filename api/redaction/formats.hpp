// The formats that redaction.hpp knows. Each function copies a whole file of its format from the cursor. Internal to
// api/redaction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "api/base/byte_source.hpp"

namespace vacuform::redaction {

// Reads bytes from their beginning to their end.
class Cursor {
 public:
  // Gives the next bytes, at most the span's size; 0 only at the end.
  using Pull = std::function<Result<std::size_t>(std::span<char>)>;
  explicit Cursor(Pull pull) : pull_(std::move(pull)) {}
  // Keeps a reference to the source, or to the bytes.
  explicit Cursor(const ByteSource& source);
  explicit Cursor(std::string_view bytes);

  // The next `bytes`, or fewer at the end; valid until the next call. They are still there afterwards.
  Result<std::string_view> peek(std::size_t bytes);
  // The same, and goes on behind them.
  Result<std::string_view> take(std::size_t bytes);
  // The next line with its end (LF, CR LF or a lone CR); empty at the end of the bytes. Errors: too_large (a line of more than
  // `longest` bytes).
  Result<std::string_view> line(std::size_t longest = longest_line);
  // The next characters up to white space or the end, and goes on behind them. Errors: as of line().
  Result<std::string> word();
  // What has come into memory and was not taken: one byte at least, but at the end.
  Result<std::string_view> some() {
    return peek(1).map([this](auto) { return rest(); });
  }
  void drop(std::size_t bytes) { begin_ += bytes; }
  // Goes on behind so many bytes, or at the end; gives how many there were.
  Result<std::uint64_t> skip(std::uint64_t bytes);

  static constexpr std::size_t longest_line = 16 << 20;

 private:
  std::string_view rest() const { return std::string_view(held_).substr(begin_); }
  Result<bool> more();

  Pull pull_;
  std::string held_;
  std::size_t begin_ = 0;
  bool ended_ = false;
};

// Where a copy goes: many small pieces become few large ones.
class Copy {
 public:
  explicit Copy(ByteSink sink) : sink_(std::move(sink)) {}
  Result<void> write(std::string_view bytes);
  Result<void> zeros(std::uint64_t count);
  // Takes as many bytes off the cursor, or those that are left there.
  Result<void> from(Cursor& in, std::uint64_t count);
  Result<void> end();
  std::uint64_t bytes() const { return bytes_; }

 private:
  ByteSink sink_;
  std::string held_;
  std::uint64_t bytes_ = 0;
};

// The end of the bytes, for a count of them.
inline constexpr std::uint64_t all_bytes = ~std::uint64_t{0};

bool begins_png(std::string_view head);
bool begins_jpeg(std::string_view head);
Result<void> png(Cursor& in, Copy& out);
Result<void> jpeg(Cursor& in, Copy& out);

enum class TextKind { stl, obj, off, csv };
Result<void> text(TextKind kind, Cursor& in, Copy& out);
constexpr bool is_white(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
// A number, or one of the words that programs write for a missing one.
bool is_number(std::string_view word);

// `texture` gives what stays of the name of a texture; without it, nothing does.
using TextureName = std::function<Result<std::string>(std::string_view path)>;
Result<void> ply(Cursor& in, Copy& out, const TextureName& texture = {});
Result<void> glb(Cursor& in, std::uint64_t size, Copy& out);
inline constexpr std::uint64_t most_svg = 32 << 20;  // bytes, unpacked
Result<void> svg(const ByteSource& file, Copy& out);
// Drawings of one page as one, each in a group that is its layer. Errors: those of svg(), unusable_pattern (their pages differ, or
// the style sheet of one would style others).
struct LayerFile {
  std::string layer, path, text;
};
Result<void> svg_of_layers(std::span<const LayerFile> files, Copy& out);
// Whether a text is a DXF in ASCII, by its first two lines; comments before it count as one.
bool begins_dxf(std::string_view head);
Result<void> dxf(Cursor& in, Copy& out);
Result<void> zip(const ByteSource& file, Copy& out);

}  // namespace vacuform::redaction
