// Random numbers and secrets (libsodium behind them).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace vacuform {

// Call once before anything else here; false when the machine has no source of randomness.
bool start_secrets();
// `bytes` random bytes in lower-case hexadecimal.
std::string random_hex(std::size_t bytes);
std::uint64_t random_number();
// Compares in a time that depends on the lengths alone.
bool equal_secrets(std::string_view a, std::string_view b);

// SHA-256 of a text, in hexadecimal.
std::string text_hash(std::string_view text);

}  // namespace vacuform
