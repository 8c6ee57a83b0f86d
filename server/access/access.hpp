// Who asks, and whether they may: a bearer token in Authorization, or the cookie of someone who signed in with one or with a
// link that stands for one.
//
// A cookie is a session of its own, so that what a browser holds is not the token and ends with sign-out, with the token,
// or after twelve hours. Sessions are in the store: they outlive a restart of the server, and servers on one database
// share them. A cookie goes to no other site (SameSite=Strict) and to no script (HttpOnly); a request that
// changes something must also come with an Origin, which origin.hpp has compared with the Host.
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "server/messages/message.hpp"
#include "server/store/sessions.hpp"
#include "server/store/tokens.hpp"

namespace vacuform {

struct Caller {
  std::string token;  // its id, for the log
  std::string owner;
  Scopes scopes;
  std::optional<Millis> expires = {};       // of the token
  std::optional<Millis> session_ends = {};  // by sign-in: the session, or the token if that is earlier
  std::string session = {};                 // the hash of its cookie, by sign-in

  bool sees_of(const std::string& other) const { return scopes.has(Scope::admin) || other == owner; }
  // The owner whose jobs a list shows; none: everybody's.
  std::optional<std::string> only() const;
};

// From any thread.
class Access {
 public:
  Access(TokenTable& tokens, SessionTable& sessions, Clock clock = wall_clock)
      : tokens_(tokens), sessions_(sessions), clock_(std::move(clock)) {}

  // Errors: unauthorized (no token, or one that cannot be used), forbidden (not of this scope), too_many_attempts: wrong
  // tokens beyond twenty at once and one a second later; and those of the store. A right token is never refused because
  // others are wrong.
  Result<Caller> check(const http::Request& request, Scope wanted);

  // Whether the token of a caller who was let in can still be used, and the session has not ended: for answers that last.
  // True if the store cannot tell.
  bool still_allowed(const Caller& caller) const;

  // The value of Set-Cookie for someone who shows a usable token; `by_tls`: through the TLS front. Errors: as above.
  Result<std::string> sign_in(std::string_view token, bool by_tls);
  // Makes a link that signs in with this token, once, within an hour, without showing it. Errors: not_found; conflict, if the
  // token cannot be used; those of the store.
  struct MadeLink {
    std::string code;  // after /sign-in?link=: 64 hexadecimal digits, stored nowhere
    Millis expires = 0;
  };
  Result<MadeLink> make_link(const std::string& token_id);
  // As sign_in(). Errors: unauthorized (no such link, used, or expired; or its token cannot be used any more), and as above.
  Result<std::string> sign_in_by_link(std::string_view code, bool by_tls);
  // Ends the session of the request's cookie; gives the value of Set-Cookie that takes it away. Errors: those of the
  // store; the session may then go on, so the browser must keep its cookie.
  Result<std::string> sign_out(const http::Request& request);

 private:
  Result<Caller> caller_of(const http::Request& request);
  Result<Caller> caller_of_session(const http::Request& request);
  Error refused(Error error);
  Result<std::string> begin_session(const Token& token, bool by_tls);

  TokenTable& tokens_;
  SessionTable& sessions_;
  const Clock clock_;
  std::mutex mutex_;
  double patience_ = 20;  // wrong tokens that are still answered
  Millis patience_at_ = 0;
};

}  // namespace vacuform
