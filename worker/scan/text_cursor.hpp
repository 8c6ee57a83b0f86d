// Walks over the lines and words of an untrusted text, without copies and without the C locale.
#pragma once

#include <charconv>
#include <cstdint>
#include <span>
#include <string_view>
#include <system_error>

namespace vacuform {

class TextCursor {
 public:
  explicit TextCursor(std::span<const std::uint8_t> bytes)
      : at_(reinterpret_cast<const char*>(bytes.data())), begin_(at_), end_(at_ + bytes.size()) {}

  // The next line without its end (LF, CR LF or a lone CR); false at the end of the text. The last line needs no end.
  bool next_line(std::string_view& line) {
    if (at_ == end_) return false;
    const char* start = at_;
    while (at_ != end_ && *at_ != '\n' && *at_ != '\r') ++at_;
    line = {start, static_cast<std::size_t>(at_ - start)};
    if (at_ != end_ && *at_++ == '\r' && at_ != end_ && *at_ == '\n') ++at_;
    ++line_number_;
    return true;
  }

  // The next word of the text, across line ends; empty at the end.
  std::string_view next_word() {
    while (at_ != end_ && is_space(*at_)) {
      if (*at_ == '\n') ++line_number_;
      ++at_;
    }
    const char* start = at_;
    while (at_ != end_ && !is_space(*at_)) ++at_;
    return {start, static_cast<std::size_t>(at_ - start)};
  }

  std::uint64_t line_number() const { return line_number_; }  // of the line that next_line gave last, from 1
  std::uint64_t position() const { return static_cast<std::uint64_t>(at_ - begin_); }
  std::uint64_t remaining() const { return static_cast<std::uint64_t>(end_ - at_); }

  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

 private:
  const char* at_;
  const char* begin_;
  const char* end_;
  std::uint64_t line_number_ = 0;
};

// Takes the first word off a line; empty when there is no word.
inline std::string_view take_word(std::string_view& line) {
  std::size_t i = 0;
  while (i < line.size() && TextCursor::is_space(line[i])) ++i;
  std::size_t j = i;
  while (j < line.size() && !TextCursor::is_space(line[j])) ++j;
  const auto word = line.substr(i, j - i);
  line.remove_prefix(j);
  return word;
}

// The whole word must be the number. "nan" and "inf" parse; callers check for finite values. A number too small for a
// double becomes 0, one too large becomes infinite.
inline bool parse_number(std::string_view word, double& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range) {
    const auto e = word.find_first_of("eE");
    const bool tiny = e != std::string_view::npos && e + 1 < word.size() && word[e + 1] == '-';
    value = tiny ? 0.0 : 1e308 * 10;
    return stop == word.data() + word.size();
  }
  return error == std::errc{} && stop == word.data() + word.size() && !word.empty();
}
inline bool parse_integer(std::string_view word, std::int64_t& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc{} && stop == word.data() + word.size() && !word.empty();
}

}  // namespace vacuform
