// multipart/form-data (RFC 7578) as it streams in. Memory stays below 128 KiB whatever the size of a part.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "api/base/error.hpp"
#include "server/messages/message.hpp"

namespace vacuform::http {

// Receives the parts in their order. An error that it returns ends the reading and is given to the caller.
class PartSink {
 public:
  virtual ~PartSink() = default;
  virtual Result<void> begin(const std::string& name, const std::string& file_name) = 0;
  virtual Result<void> data(std::string_view bytes) = 0;
  virtual Result<void> end() = 0;
};

class MultipartParser {
 public:
  MultipartParser(std::string_view boundary, PartSink& sink);
  // Errors: bad_usage when the text is not multipart, and those of the sink. After an error the parser is of
  // no use.
  Result<void> feed(std::string_view bytes);
  // Call at the end of the body. Errors: bad_usage when the last boundary has not come.
  Result<void> finish() const;

 private:
  enum class Place { preamble, after_delimiter, head, data, epilogue };
  Result<void> read_head(std::string_view head);
  Result<void> count_outside(std::size_t bytes);

  std::string delimiter_, pending_;
  PartSink& sink_;
  Place place_ = Place::preamble;
  int parts_ = 0;
  std::uint64_t outside_ = 0;  // bytes of the preamble and of the epilogue
};

// The boundary of a Content-Type header. Errors: unsupported_format when it is not multipart/form-data.
Result<std::string> multipart_boundary(std::string_view content_type);

// Reads a whole multipart body into the sink. Errors: as above, and those of Body::read.
Result<void> read_multipart(Request& request, PartSink& sink);

// "C:\scans\Head 3.STL" -> "stl": the extension of a file's name, at most 8 letters and digits in lower case,
// or nothing. No other part of a client's file name is ever used.
std::string safe_extension(std::string_view file_name);

}  // namespace vacuform::http
