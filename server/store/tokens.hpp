// Tokens by which callers are known. Only the hash of a token's secret is stored.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/base/clock.hpp"
#include "api/base/error.hpp"
#include "server/store/scopes.hpp"

namespace vacuform {

// Access rights; see server/access/tokens.hpp.
struct Token {
  std::string id;     // 16 hexadecimal digits; no secret
  std::string owner;  // whose jobs it sees and makes
  Scopes scopes;
  std::string hash;  // SHA-256 of its secret, in hexadecimal
  Millis created = 0;
  std::optional<Millis> expires, revoked;
  std::string file = {};  // of the data folder, for which the server made it; empty: made on request
};

class TokenTable {
 public:
  virtual ~TokenTable() = default;
  // Errors: conflict if the id exists.
  virtual Result<void> add_token(const Token& token) = 0;
  // Also returns an expired or revoked one. Errors: not_found.
  virtual Result<Token> token(const std::string& id) = 0;
  virtual Result<std::vector<Token>> tokens() = 0;  // oldest first
  // Permanent; revoking twice is harmless. Errors: not_found.
  virtual Result<void> revoke_token(const std::string& id) = 0;
};

}  // namespace vacuform
