// The digest fields of RFC 9530, with sha-256, the one digest of Vacuform.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/messages/message.hpp"

namespace vacuform::http {

// The value of Content-Digest or Repr-Digest: "sha-256=:X48E...=:". `sha256` is 64 hexadecimal digits.
std::string digest_field(const std::string& sha256);

// The SHA-256 in hexadecimal that a field of that name states; empty when the request has none, or one by other
// algorithms only, which RFC 9530 lets a recipient ignore. Errors: bad_usage when it is malformed.
Result<std::string> stated_digest(const Request& request, std::string_view field);

// SHA-1 finds damage alone, and is there because tus wants it.
enum class Algorithm { sha256, sha1 };

// The base 64 of a digest in hexadecimal; none when it is not of the algorithm's length.
std::optional<std::string> digest_from_base64(std::string_view text, Algorithm algorithm);

// A body whose end is an error, wrong_digest, unless its bytes have this digest, in hexadecimal. What is read of `body`
// before is passed on unchecked: use nothing of it before its end has come.
std::unique_ptr<Body> checked_body(Body& body, std::string digest, Algorithm algorithm = Algorithm::sha256);

}  // namespace vacuform::http
