// Sessions of browsers that signed in with a token or a link. Only the hash of a cookie's value is stored.
#pragma once

#include <string>

#include "api/base/clock.hpp"
#include "api/base/error.hpp"
#include "server/store/tokens.hpp"

namespace vacuform {

struct Session {
  std::string hash;   // SHA-256 of the cookie's value, in hexadecimal
  std::string token;  // id of the token that began it
  Millis ends = 0;
};

// A session as a request finds it.
struct FoundSession {
  Token token;
  Millis ends = 0;
};

// Signs a browser in once, in place of a token. Only the hash of its code is stored.
struct SignInLink {
  std::string hash;   // SHA-256 of the code, in hexadecimal
  std::string token;  // id of the token that it stands for
  Millis expires = 0;
};

inline constexpr int most_links_of_token = 20;
inline constexpr int most_sessions = 1000;  // of all tokens
inline constexpr int most_sessions_of_token = 50;

class SessionTable {
 public:
  virtual ~SessionTable() = default;
  // Deletes sessions that have ended, and makes room: a token with too many sessions loses its oldest one. If all tokens
  // together have too many, the token with the most sessions loses its oldest, so that no token ends those of others.
  virtual Result<void> add_session(const Session& session) = 0;
  // Also returns one that has ended, or whose token has expired or was revoked. Errors: not_found.
  virtual Result<FoundSession> find_session(const std::string& hash) = 0;
  // Ending a session that does not exist is harmless.
  virtual Result<void> end_session(const std::string& hash) = 0;

  // Deletes links that have expired; a token with too many loses the one that expires first.
  virtual Result<void> add_link(const SignInLink& link) = 0;
  // The token that a link stands for, which may have expired or been revoked since. The link is gone then: of several
  // callers one gets the token. Errors: not_found, also if it was used or has expired.
  virtual Result<Token> use_link(const std::string& hash) = 0;
};

}  // namespace vacuform
