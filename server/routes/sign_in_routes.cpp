// Signing in and out, without scripts: a form sends the token once, then a cookie is used.
#include "api/base/text.hpp"
#include "server/messages/multipart.hpp"
#include "server/pages/pages.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;

namespace {

constexpr std::size_t longest_token = 200;
constexpr std::uint64_t largest_sign_in = 4 << 10;  // of a form with a token, for every client

// The one field of the form.
class TokenForm : public http::PartSink {
 public:
  Result<void> begin(const std::string& name, const std::string&) override {
    if (name == "token" && token.empty()) return {};
    return fail(Code::bad_usage, "an unknown part of the form: " + name.substr(0, 64), "request body",
                "send the token alone");
  }
  Result<void> data(std::string_view bytes) override {
    token += bytes;
    if (token.size() <= longest_token) return {};
    return fail(Code::too_large, "the token is longer than a token can be", "token", "send the token alone");
  }
  Result<void> end() override { return {}; }

  std::string token;
};

Result<Response> sign_in(Service& service, Request& request) {
  TokenForm form;
  VACUFORM_CHECK(http::read_multipart(request, form));
  const auto cookie = service.access.sign_in(trimmed(form.token), request.by_front);
  if (!cookie) return html_response(sign_in_page(cookie.error()));
  Response response = see_other("/");
  response.set("Set-Cookie", *cookie);
  return response;
}

Result<Response> sign_out(Service& service, Request& request) {
  VACUFORM_TRY(cookie, service.access.sign_out(request));
  Response response = see_other("/sign-in");
  response.set("Set-Cookie", cookie);
  return response;
}

}  // namespace

void add_sign_in_routes(http::Router& router, Service& service) {
  Service* const s = &service;
  add_public(router, "GET", "/sign-in",
             [](Request&) -> Result<Response> { return html_response(sign_in_page()); });
  add_public(
      router, "POST", "/sign-in", [s](Request& request) { return sign_in(*s, request); }, largest_sign_in);
  add_public(
      router, "POST", "/sign-out", [s](Request& request) { return sign_out(*s, request); }, largest_sign_in);
}

}  // namespace vacuform
