// What a name filter remembers between two pieces of a file, as text and back: each filter names its members once, in fields().
#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace vacuform {

class FilterState {
 public:
  // Writes what it is given.
  FilterState() = default;
  // Reads it back, from a text that is there as long.
  explicit FilterState(std::string_view text) : rest_(text), reads_(true) {}

  bool reads() const { return reads_; }
  // False when the text was not written by the same fields().
  bool good() const { return good_; }
  bool ended() const { return good_ && rest_.empty(); }
  const std::string& text() const { return written_; }

  // Several at once.
  template <class... T>
  void operator()(T&... values) {
    (field(values), ...);
  }

 private:
  template <class T>
  requires std::is_integral_v<T> || std::is_enum_v<T>
  void field(T& value) {
    if (!reads_) {
      written_.append(std::to_string(static_cast<std::int64_t>(value))).append(" ");
      return;
    }
    std::int64_t number = 0;
    const char* const end = rest_.data() + rest_.size();
    const auto [stop, error] = std::from_chars(rest_.data(), end, number);
    good_ = good_ && error == std::errc() && stop != end && *stop == ' ';
    if (!good_) return;
    rest_.remove_prefix(static_cast<std::size_t>(stop - rest_.data()) + 1);
    value = static_cast<T>(number);
  }
  void field(std::string& text) {
    std::size_t size = text.size();
    field(size);
    if (!reads_) {
      written_ += text;
      return;
    }
    good_ = good_ && size <= rest_.size();
    if (!good_) return;
    text = rest_.substr(0, size);
    rest_.remove_prefix(size);
  }
  template <class T>
  void field(std::vector<T>& values) {
    std::size_t size = values.size();
    field(size);
    good_ = good_ && size <= (reads_ ? rest_.size() : size);  // each takes a byte at least
    if (!good_) return;
    values.resize(size);
    for (T& value : values)
      if constexpr (std::is_integral_v<T>)
        field(value);
      else
        value.fields(*this);
  }

  std::string written_;
  std::string_view rest_;
  bool reads_ = false, good_ = true;
};

}  // namespace vacuform
