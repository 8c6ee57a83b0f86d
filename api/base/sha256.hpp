// SHA-256, the one digest of Vacuform: it names blobs, checks transfers and labels prints.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace vacuform {

// Takes bytes in pieces of any size. Not copyable; one object is one message.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void add(std::span<const std::uint8_t> bytes);
  void add(std::string_view text) { add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}); }

  // 64 lower-case hexadecimal digits. Ends the message: call it once, and add nothing after it.
  std::string hex();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string sha256_hex(std::span<const std::uint8_t> bytes);

// HMAC with SHA-256 (RFC 2104), as 32 bytes. The key has any length.
std::string hmac_sha256(std::string_view key, std::string_view text);

}  // namespace vacuform
