// Who asks, and whether they may: a bearer token in Authorization, or the cookie of someone who signed in with one.
//
// A cookie is a session of its own, in memory, so that what a browser holds is not the token and ends with sign-out, with
// the server, or after twelve hours. It goes to no other site (SameSite=Strict) and to no script (HttpOnly); a request
// that changes something must also come with an Origin, which origin.hpp has compared with the Host.
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "server/http/message.hpp"
#include "server/store/tokens.hpp"

namespace vacuform {

struct Caller {
  std::string token;  // its id, for the log
  std::string owner;
  Scopes scopes;
  std::optional<Millis> expires = {};       // of the token
  std::optional<Millis> session_ends = {};  // by sign-in: the session, or the token if that is earlier

  bool sees_of(const std::string& other) const { return scopes.has(Scope::admin) || other == owner; }
  // The owner whose jobs a list shows; none: everybody's.
  std::optional<std::string> only() const;
};

// From any thread.
class Access {
 public:
  explicit Access(TokenTable& store, Clock clock = wall_clock) : store_(store), clock_(std::move(clock)) {}

  // Errors: unauthorized (no token, or one that cannot be used), forbidden (not of this scope), too_many_attempts: wrong
  // tokens beyond twenty at once and one a second later. A right token is never refused because others are wrong.
  Result<Caller> check(const http::Request& request, Scope wanted);

  // The value of Set-Cookie for someone who shows a usable token; `by_tls`: through the TLS front. Errors: as above.
  Result<std::string> sign_in(std::string_view token, bool by_tls);
  // Ends the session of the request's cookie; gives the value of Set-Cookie that takes it away.
  std::string sign_out(const http::Request& request);

 private:
  struct Session {
    std::string token;  // id
    Millis ends = 0;
  };
  Result<Caller> caller_of(const http::Request& request);
  Result<Caller> caller_of_session(const http::Request& request);
  Error refused(Error error);
  void make_room_for_session(const std::string& token);

  TokenTable& store_;
  const Clock clock_;
  std::mutex mutex_;
  std::map<std::string, Session> sessions_;  // by the hash of the cookie's value
  double patience_ = 20;                     // wrong tokens that are still answered
  Millis patience_at_ = 0;
};

}  // namespace vacuform
