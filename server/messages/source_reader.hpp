// The body of a response that is a piece of a source, read in order.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "api/base/sha256.hpp"
#include "server/messages/message.hpp"

namespace vacuform::http {

class SourceReader {
 public:
  explicit SourceReader(SourceBody body);
  // The next bytes, at most so many; valid until the next call. Empty if the body must end before its end: the source
  // cannot be read, or it is whole, its hash is known, and with the last bytes it has another. That is logged.
  std::string_view next(std::size_t most);

 private:
  const SourceBody body_;
  std::uint64_t read_ = 0;
  std::unique_ptr<Sha256> hash_;
  std::vector<char> piece_;
};

}  // namespace vacuform::http
