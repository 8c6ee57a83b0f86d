#include "api/base/sha256.hpp"

#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <sodium.h>

#include <new>
#include <stdexcept>

namespace vacuform {

namespace {

constexpr std::size_t digest_size = 32;

const EVP_MD* method() {
  static const EVP_MD* const sha256 = EVP_MD_fetch(nullptr, "SHA256", nullptr);
  if (!sha256) throw std::runtime_error("OpenSSL offers no SHA-256");
  return sha256;
}

void check(bool done) {
  if (!done) throw std::runtime_error("OpenSSL made no SHA-256");
}

}  // namespace

struct Sha256::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();

  State() {
    if (!context) throw std::bad_alloc();
    check(EVP_DigestInit_ex2(context, method(), nullptr) == 1);
  }
  ~State() { EVP_MD_CTX_free(context); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
};

Sha256::Sha256() : state_(std::make_unique<State>()) {}
Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

void Sha256::add(std::span<const std::uint8_t> bytes) {
  check(EVP_DigestUpdate(state_->context, bytes.data(), bytes.size()) == 1);
}

std::string Sha256::hex() {
  unsigned char digest[digest_size];
  check(EVP_DigestFinal_ex(state_->context, digest, nullptr) == 1);
  char text[2 * digest_size + 1];
  return sodium_bin2hex(text, sizeof text, digest, sizeof digest);
}

std::string sha256_hex(std::span<const std::uint8_t> bytes) {
  Sha256 sha;
  sha.add(bytes);
  return sha.hex();
}

std::string hmac_sha256(std::string_view key, std::string_view text) {
  std::string code(digest_size, '\0');
  check(HMAC(method(), key.data(), static_cast<int>(key.size()),
             reinterpret_cast<const unsigned char*>(text.data()), text.size(),
             reinterpret_cast<unsigned char*>(code.data()), nullptr) != nullptr);
  return code;
}

}  // namespace vacuform
