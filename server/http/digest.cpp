#include "server/http/digest.hpp"

#include <sodium.h>
#include <strings.h>

#include <algorithm>
#include <array>

#include "api/sha256.hpp"

namespace vacuform::http {

namespace {

constexpr std::size_t digest_bytes = 32;
constexpr std::string_view algorithm = "sha-256";
constexpr std::string_view blanks = " \t";

std::string_view trimmed(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  return text.substr(0, text.find_last_not_of(blanks) + 1);
}

// ":X48E...=:", a byte sequence of RFC 8941, perhaps with parameters behind it.
std::optional<std::string> hexadecimal(std::string_view value) {
  const std::size_t end = value.find(':', 1);
  if (!value.starts_with(':') || end == std::string_view::npos) return std::nullopt;
  const std::string_view text = value.substr(1, end - 1), rest = trimmed(value.substr(end + 1));
  std::array<unsigned char, digest_bytes> bytes;
  std::size_t size = 0;
  if ((!rest.empty() && rest[0] != ';') ||
      sodium_base642bin(bytes.data(), bytes.size(), text.data(), text.size(), nullptr, &size, nullptr,
                        sodium_base64_VARIANT_ORIGINAL) != 0 ||
      size != bytes.size())
    return std::nullopt;
  std::array<char, 2 * digest_bytes + 1> digits;
  return sodium_bin2hex(digits.data(), digits.size(), bytes.data(), bytes.size());
}

class CheckedBody : public Body {
 public:
  CheckedBody(Body& body, std::string sha256) : body_(body), stated_(std::move(sha256)) {}

  Result<std::size_t> read(std::span<char> into) override {
    VACUFORM_TRY(n, body_.read(into));
    if (n > 0) {
      hash_.add(std::string_view(into.data(), n));
      return n;
    }
    if (found_.empty()) found_ = hash_.hex();
    if (found_ != stated_)
      return fail(Code::wrong_digest, "the body is not the one whose SHA-256 was stated", "Content-Digest",
                  "send it again");
    return n;
  }

 private:
  Body& body_;
  const std::string stated_;
  std::string found_;
  Sha256 hash_;
};

}  // namespace

std::string digest_field(const std::string& sha256) {
  std::array<unsigned char, digest_bytes> bytes{};
  std::size_t size = 0;
  sodium_hex2bin(bytes.data(), bytes.size(), sha256.data(), sha256.size(), nullptr, &size, nullptr);
  std::array<char, sodium_base64_ENCODED_LEN(digest_bytes, sodium_base64_VARIANT_ORIGINAL)> text;
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(), sodium_base64_VARIANT_ORIGINAL);
  return std::string(algorithm) + "=:" + text.data() + ":";
}

Result<std::string> stated_digest(const Request& request, std::string_view field) {
  std::string stated;
  for (const Header& header : request.headers) {
    if (header.name.size() != field.size() ||
        strncasecmp(header.name.data(), field.data(), field.size()) != 0)
      continue;
    std::string_view rest = header.value;
    while (!rest.empty()) {
      const std::size_t comma = rest.find(',');  // base 64 has none
      const std::string_view member = trimmed(rest.substr(0, comma));
      rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
      const std::size_t equals = member.find('=');
      if (member.substr(0, equals) != algorithm) continue;
      const auto digest =
          equals == std::string_view::npos ? std::nullopt : hexadecimal(member.substr(equals + 1));
      if (!digest)
        return fail(Code::bad_usage, "not a digest of the form sha-256=:BASE64:", std::string(field),
                    "send the base 64 of the 32 bytes of the SHA-256 between colons, or leave it out");
      stated = *digest;  // of doubled members the last counts (RFC 8941)
    }
  }
  return stated;
}

std::unique_ptr<Body> checked_body(Body& body, std::string sha256) {
  return std::make_unique<CheckedBody>(body, std::move(sha256));
}

}  // namespace vacuform::http
