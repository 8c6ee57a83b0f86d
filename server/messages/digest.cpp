#include "server/messages/digest.hpp"

#include <openssl/evp.h>
#include <sodium.h>

#include <algorithm>
#include <array>

#include "api/base/base64.hpp"
#include "api/base/sha256.hpp"
#include "api/base/text.hpp"

namespace vacuform::http {

namespace {

constexpr std::size_t digest_bytes = 32;
constexpr std::string_view field_key = "sha-256";

std::string hexadecimal(std::span<const unsigned char> bytes) {
  std::string digits(2 * bytes.size() + 1, '\0');  // sodium ends it with a zero
  sodium_bin2hex(digits.data(), digits.size(), bytes.data(), bytes.size());
  digits.pop_back();
  return digits;
}

// ":X48E...=:", a byte sequence of RFC 8941, perhaps with parameters behind it.
std::optional<std::string> byte_sequence(std::string_view value) {
  const std::size_t end = value.find(':', 1);
  if (!value.starts_with(':') || end == std::string_view::npos) return std::nullopt;
  const std::string_view rest = trimmed(value.substr(end + 1));
  if (!rest.empty() && rest[0] != ';') return std::nullopt;
  return digest_from_base64(value.substr(1, end - 1), Algorithm::sha256);
}

class Hash {
 public:
  virtual ~Hash() = default;
  virtual void add(std::string_view bytes) = 0;
  virtual std::string hex() = 0;
};

class HashSha256 : public Hash {
 public:
  void add(std::string_view bytes) override { hash_.add(bytes); }
  std::string hex() override { return hash_.hex(); }

 private:
  Sha256 hash_;
};

class HashSha1 : public Hash {
 public:
  HashSha1() { EVP_DigestInit_ex(context_.get(), EVP_sha1(), nullptr); }
  void add(std::string_view bytes) override { EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()); }
  std::string hex() override {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
    unsigned size = 0;
    EVP_DigestFinal_ex(context_.get(), digest.data(), &size);
    return hexadecimal({digest.data(), size});
  }

 private:
  struct Free {
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
  };
  std::unique_ptr<EVP_MD_CTX, Free> context_{EVP_MD_CTX_new()};
};

class CheckedBody : public Body {
 public:
  CheckedBody(Body& body, std::string digest, std::unique_ptr<Hash> hash)
      : body_(body), stated_(std::move(digest)), hash_(std::move(hash)) {}

  Result<void> read(const Taker& take) override {
    VACUFORM_CHECK(body_.read([&](std::string_view piece) {
      hash_->add(piece);
      return take(piece);
    }));
    if (hash_->hex() != stated_)
      return fail(Code::wrong_digest, "the body is not the one whose digest was stated", "request body",
                  "send it again");
    return {};
  }

 private:
  Body& body_;
  const std::string stated_;
  std::unique_ptr<Hash> hash_;
};

}  // namespace

std::string digest_field(const std::string& sha256) {
  std::string bytes(digest_bytes, '\0');
  sodium_hex2bin(reinterpret_cast<unsigned char*>(bytes.data()), bytes.size(), sha256.data(), sha256.size(),
                 nullptr, nullptr, nullptr);
  return std::string(field_key) + "=:" + to_base64(bytes) + ":";
}

Result<std::string> stated_digest(const Request& request, std::string_view field) {
  std::string stated;
  for (const Header& header : request.headers) {
    if (!equal_ignoring_case(header.name, field)) continue;
    std::string_view rest = header.value;
    while (!rest.empty()) {
      const std::size_t comma = rest.find(',');  // base 64 has none
      const std::string_view member = trimmed(rest.substr(0, comma));
      rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
      const std::size_t equals = member.find('=');
      if (member.substr(0, equals) != field_key) continue;
      const auto digest =
          equals == std::string_view::npos ? std::nullopt : byte_sequence(member.substr(equals + 1));
      if (!digest)
        return fail(Code::bad_usage, "not a digest of the form sha-256=:BASE64:", std::string(field),
                    "send the base 64 of the 32 bytes of the SHA-256 between colons, or leave it out");
      stated = *digest;  // of doubled members the last counts (RFC 8941)
    }
  }
  return stated;
}

std::optional<std::string> digest_from_base64(std::string_view text, Algorithm kind) {
  const auto bytes = from_base64(text);
  if (!bytes || bytes->size() != (kind == Algorithm::sha1 ? 20u : digest_bytes)) return std::nullopt;
  return hexadecimal({reinterpret_cast<const unsigned char*>(bytes->data()), bytes->size()});
}

std::unique_ptr<Body> checked_body(Body& body, std::string digest, Algorithm kind) {
  std::unique_ptr<Hash> hash;
  if (kind == Algorithm::sha1)
    hash = std::make_unique<HashSha1>();
  else
    hash = std::make_unique<HashSha256>();
  return std::make_unique<CheckedBody>(body, std::move(digest), std::move(hash));
}

}  // namespace vacuform::http
