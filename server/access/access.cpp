#include "server/access/access.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "api/base/secrets.hpp"
#include "api/base/text.hpp"
#include "server/access/tokens.hpp"

namespace vacuform {

namespace {

// Behind TLS the cookie is restricted to TLS and to this host. The browser enforces this by the prefix: no plain page
// and no other host of the same domain can set such a cookie (draft-ietf-httpbis-rfc6265bis, 4.1.3.2).
std::string_view cookie_name(bool by_tls) { return by_tls ? "__Host-vacuform-session" : "vacuform-session"; }

std::string set_cookie(bool by_tls, const std::string& value, Millis seconds) {
  return std::string(cookie_name(by_tls)) + "=" + value + "; Path=/; HttpOnly; SameSite=Strict" +
         (by_tls ? "; Secure" : "") + "; Max-Age=" + std::to_string(seconds);
}

constexpr Millis session_seconds = 12 * 3600, link_seconds = 3600;
constexpr double most_patience = 20;

// The value of the session cookie in the request.
std::string_view cookie_of(const http::Request& request) {
  std::string_view all = request.header("Cookie");
  while (!all.empty()) {
    const std::size_t end = all.find(';');
    std::string_view pair = all.substr(0, end);
    all.remove_prefix(end == std::string_view::npos ? all.size() : end + 1);
    while (pair.starts_with(' ')) pair.remove_prefix(1);
    const std::size_t equals = pair.find('=');
    if (equals != std::string_view::npos && pair.substr(0, equals) == cookie_name(request.by_front))
      return pair.substr(equals + 1);
  }
  return {};
}

Error no_token() {
  return {
      Code::unauthorized, "there is no token", "Authorization",
      "send Authorization: Bearer and a token, or sign in at /sign-in; the administrator makes tokens with "
      "vacuform-server token create"};
}

}  // namespace

std::optional<std::string> Caller::only() const {
  if (scopes.has(Scope::admin)) return std::nullopt;
  return owner;
}

Result<Caller> Access::check(const http::Request& request, Scope wanted) {
  auto caller = caller_of(request);
  if (caller && !caller->scopes.allow(wanted))
    return fail(Code::forbidden, "the token lacks the scope " + std::string(name(wanted)), caller->token,
                "use a token that has it");
  return caller;
}

Result<Caller> Access::caller_of(const http::Request& request) {
  constexpr std::string_view scheme = "Bearer ";
  const std::string_view shown = request.header("Authorization");
  if (equal_ignoring_case(shown.substr(0, scheme.size()), scheme)) {
    auto token = usable_token(tokens_, shown.substr(scheme.size()), clock_);
    if (!token) return tl::make_unexpected(refused(std::move(token.error())));
    return Caller{token->id, token->owner, token->scopes, token->expires};
  }
  if (!shown.empty() || cookie_of(request).empty()) return tl::make_unexpected(no_token());
  return caller_of_session(request);
}

Result<Caller> Access::caller_of_session(const http::Request& request) {
  if (request.method != "GET" && request.header("Origin").empty())
    return fail(Code::bad_usage, "a request by cookie that changes something has no Origin", "Origin",
                "use the pages of this server, or a token in Authorization");
  const auto session = sessions_.find_session(text_hash(cookie_of(request)));
  if (!session && session.error().code != Code::not_found) return tl::make_unexpected(session.error());
  const Millis now = clock_();
  if (session && now < session->ends && usable(session->token, now)) {
    const Token& token = session->token;
    return Caller{token.id,
                  token.owner,
                  token.scopes,
                  token.expires,
                  std::min(session->ends, token.expires.value_or(session->ends)),
                  text_hash(cookie_of(request))};
  }
  return fail(Code::unauthorized, "the session has ended", "Cookie", "sign in again at /sign-in");
}

bool Access::still_allowed(const Caller& caller) const {
  const Millis now = clock_();
  if (caller.session.empty()) {
    const auto token = tokens_.token(caller.token);
    return token ? usable(*token, now) : token.error().code != Code::not_found;
  }
  const auto session = sessions_.find_session(caller.session);
  return session ? now < session->ends && usable(session->token, now)
                 : session.error().code != Code::not_found;
}

// The answer to a wrong token: at first that it is wrong; after too many attempts, to wait.
Error Access::refused(Error error) {
  if (error.code != Code::unauthorized) return error;
  const std::lock_guard hold(mutex_);
  const Millis now = clock_();
  patience_ = std::min(most_patience,
                       patience_ + static_cast<double>(std::max<Millis>(0, now - patience_at_)) / 1000);
  patience_at_ = now;
  if (patience_ < 1)
    return {Code::too_many_attempts, "there were too many wrong tokens", "token", "try again in a minute"};
  patience_ -= 1;
  log_event("token-refused", {{"why", error.what}});
  return error;
}

Result<std::string> Access::begin_session(const Token& token, bool by_tls) {
  const std::string value = random_hex(32);
  VACUFORM_CHECK(sessions_.add_session({text_hash(value), token.id, clock_() + session_seconds * 1000}));
  log_event("signed-in", {{"token", token.id}});
  return set_cookie(by_tls, value, session_seconds);
}

Result<std::string> Access::sign_in(std::string_view text, bool by_tls) {
  const auto token = usable_token(tokens_, text, clock_);
  if (!token) return tl::make_unexpected(refused(token.error()));
  return begin_session(*token, by_tls);
}

Result<Access::MadeLink> Access::make_link(const std::string& token_id) {
  VACUFORM_TRY(token, tokens_.token(token_id));
  const Millis now = clock_();
  if (!usable(token, now))
    return fail(Code::conflict, "the token was revoked or has expired", token_id, "make another token");
  MadeLink link{random_hex(32), now + link_seconds * 1000};
  VACUFORM_CHECK(sessions_.add_link({text_hash(link.code), token.id, link.expires}));
  return link;
}

Result<std::string> Access::sign_in_by_link(std::string_view code, bool by_tls) {
  auto token = sessions_.use_link(text_hash(code));
  if (!token && token.error().code != Code::not_found) return tl::make_unexpected(token.error());
  if (!token || !usable(*token, clock_()))
    return tl::make_unexpected(
        refused({Code::unauthorized, "the link is wrong, was used, or has expired", "link",
                 "ask the administrator for another one; deploy/start prints one, too"}));
  return begin_session(*token, by_tls);
}

Result<std::string> Access::sign_out(const http::Request& request) {
  VACUFORM_CHECK(sessions_.end_session(text_hash(cookie_of(request))));
  return set_cookie(request.by_front, "", 0);
}

}  // namespace vacuform
