// Sessions of browsers that signed in with a token. Only the hash of a cookie's value is stored.
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
};

}  // namespace vacuform
