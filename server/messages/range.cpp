#include "server/messages/range.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include "api/base/text.hpp"

namespace vacuform::http {

namespace {

std::optional<std::uint64_t> whole_number(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

RangeAnswer byte_range(std::string_view header, std::uint64_t bytes) {
  constexpr std::string_view unit = "bytes=";
  header = trimmed(header);
  if (!header.starts_with(unit)) return {};
  const std::string_view range = trimmed(header.substr(unit.size()));
  const auto dash = range.find('-');
  if (dash == std::string_view::npos || range.find(',') != std::string_view::npos) return {};
  const auto first = whole_number(range.substr(0, dash)), last = whole_number(range.substr(dash + 1));
  if (dash == 0) {  // the last so many bytes
    if (!last) return {};
    if (*last == 0 || bytes == 0) return {RangeAnswer::unsatisfiable, 0, 0};
    return {RangeAnswer::part, bytes - std::min(*last, bytes), bytes - 1};
  }
  if (!first || (!last && dash + 1 != range.size()) || (last && *last < *first)) return {};
  if (*first >= bytes) return {RangeAnswer::unsatisfiable, 0, 0};
  return {RangeAnswer::part, *first, last ? std::min(*last, bytes - 1) : bytes - 1};
}

namespace {

bool names(std::string_view header, std::string_view quoted, bool weak_too) {
  while (!header.empty()) {
    const auto comma = header.find(',');
    std::string_view tag = trimmed(header.substr(0, comma));
    if (tag == "*") return true;
    if (weak_too && tag.starts_with("W/")) tag.remove_prefix(2);
    if (tag == quoted) return true;
    if (comma == std::string_view::npos) return false;
    header.remove_prefix(comma + 1);
  }
  return false;
}

}  // namespace

bool names_etag(std::string_view header, std::string_view quoted) { return names(header, quoted, true); }

bool names_strong_etag(std::string_view header, std::string_view quoted) {
  return names(header, quoted, false);
}

}  // namespace vacuform::http
