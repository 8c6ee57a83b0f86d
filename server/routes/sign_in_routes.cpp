// Signing in and out, without scripts: a form sends the token or the code of a link once, then a cookie is used.
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

// The one field of the form: `token` or `link`.
class SignInForm : public http::PartSink {
 public:
  Result<void> begin(const std::string& name, const std::string&) override {
    if ((name == "token" || name == "link") && field.empty()) {
      field = name;
      return {};
    }
    return fail(Code::bad_usage, "an unknown part of the form: " + name.substr(0, 64), "request body",
                "send the token or the link alone");
  }
  Result<void> data(std::string_view bytes) override {
    value += bytes;
    if (value.size() <= longest_token) return {};
    return fail(Code::too_large, "the " + field + " is longer than it can be", field, "send it alone");
  }
  Result<void> end() override { return {}; }

  std::string field, value;
};

Response signed_in(const std::string& cookie) {
  Response response = see_other("/");
  response.set("Set-Cookie", cookie);
  return response;
}

Response sign_in_by_link(Service& service, const Request& request, std::string_view link) {
  const auto cookie = service.access.sign_in_by_link(link, request.by_front);
  if (cookie) return signed_in(*cookie);
  // A person who opens a link again has signed in with it.
  if (service.access.check(request, Scope::read)) return see_other("/");
  return html_response(sign_in_page(cookie.error()));
}

Result<Response> sign_in(Service& service, Request& request) {
  SignInForm form;
  VACUFORM_CHECK(http::read_multipart(request, form));
  if (form.field == "link") return sign_in_by_link(service, request, trimmed(form.value));
  const auto cookie = service.access.sign_in(trimmed(form.value), request.by_front);
  return cookie ? signed_in(*cookie) : html_response(sign_in_page(cookie.error()));
}

// Whether a link signs in by a click only. Browsers fetch pages ahead, and programs that check mail open its links; a link on
// loopback, as deploy/start prints it, goes through no mail. When the link is on a page of another site, the browser does not
// send a new SameSite=Strict cookie to the page that we redirect to.
bool waits_for_click(const Request& request) {
  const std::string_view from = request.header("Sec-Fetch-Site");
  return request.by_front || request.head_only || !request.header("Sec-Purpose").empty() ||
         from == "cross-site" || from == "same-site";
}

Result<Response> sign_in_form(Service& service, Request& request) {
  const std::string link = request.query_value("link");
  if (link.empty()) return html_response(sign_in_page());
  if (waits_for_click(request)) return html_response(sign_in_page({}, link));
  return sign_in_by_link(service, request, link);
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
  add_public(router, "GET", "/sign-in?link", [s](Request& request) { return sign_in_form(*s, request); });
  add_public(
      router, "POST", "/sign-in", [s](Request& request) { return sign_in(*s, request); }, largest_sign_in);
  add_public(
      router, "POST", "/sign-out", [s](Request& request) { return sign_out(*s, request); }, largest_sign_in);
}

}  // namespace vacuform
