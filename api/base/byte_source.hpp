// Bytes that are read by their places, and bytes that go somewhere: a file and its copy, wherever they are.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "api/base/error.hpp"

namespace vacuform {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual Result<std::uint64_t> size() const = 0;
  // Bytes from `offset` on, at most the span's size; 0 only at the end. Errors: unavailable, unreadable.
  virtual Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const = 0;
};

// Bytes in memory, to which it keeps a reference.
class MemorySource : public ByteSource {
 public:
  explicit MemorySource(std::string_view bytes) : bytes_(bytes) {}
  Result<std::uint64_t> size() const override { return bytes_.size(); }
  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const override {
    if (offset >= bytes_.size()) return 0;
    return bytes_.copy(into.data(), into.size(), static_cast<std::size_t>(offset));
  }

 private:
  std::string_view bytes_;
};

// Takes the next bytes. An error ends the copy.
using ByteSink = std::function<Result<void>(std::string_view)>;

}  // namespace vacuform
