// The header lines of RFC 9110 that decide which bytes of a file are sent.
#pragma once

#include <cstdint>
#include <string_view>

namespace vacuform::http {

struct RangeAnswer {
  enum Kind { whole, part, unsatisfiable } kind = whole;
  std::uint64_t first = 0, last = 0;  // of a part, both inclusive
};

// What a Range header asks of a file of that many bytes. A header that is absent, malformed, of another unit
// or of several ranges asks for the whole.
RangeAnswer byte_range(std::string_view header, std::uint64_t bytes);

// Whether an If-None-Match header names this entity tag (with its quotes): one of a list, weak or strong, or
// "*".
bool names_etag(std::string_view header, std::string_view quoted);

// The same of an If-Match header, where a weak tag names nothing.
bool names_strong_etag(std::string_view header, std::string_view quoted);

}  // namespace vacuform::http
