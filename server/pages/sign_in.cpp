// Signing in and out, without scripts: the token in a form once, a cookie after that.
#include "api/base/log.hpp"
#include "api/problem.hpp"
#include "server/http/multipart.hpp"
#include "server/pages/pages.hpp"
#include "server/routes/service.hpp"

namespace vacuform {

using http::Request;
using http::Response;

namespace {

constexpr std::size_t longest_token = 200;
constexpr std::uint64_t largest_sign_in = 4 << 10;  // of a form with a token, whoever sends it

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

// As it is copied from somewhere, with blanks and line ends around it.
std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(" \t\r\n") + 1 - begin);
}

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
  Response response = see_other("/sign-in");
  response.set("Set-Cookie", service.access.sign_out(request));
  return response;
}

}  // namespace

Page sign_in_page(const std::optional<Error>& error) {
  Page page;
  page.title = "Sign in";
  page.status = error ? meaning(error->code).http_status : 200;
  page.main = "<h1>Sign in</h1>\n";
  if (error) page.main += problem_box(*error);
  page.main +=
      "<form method=\"post\" action=\"/sign-in\" enctype=\"multipart/form-data\">\n<div "
      "class=\"field\"><label "
      "for=\"token\">Token</label><input id=\"token\" name=\"token\" type=\"password\" "
      "autocomplete=\"current-password\" "
      "required aria-describedby=\"token-hint\"><p class=\"hint\" id=\"token-hint\">It begins with vft_. On "
      "the machine "
      "that runs the service, deploy/start has said in which file yours is; elsewhere, ask whoever runs "
      "it.</p></div>\n"
      "<p><button type=\"submit\">Sign in</button></p>\n</form>\n";
  return page;
}

void add_sign_in_routes(http::Router& router, Service& service) {
  Service* const s = &service;
  router.add("GET", "/sign-in", [](Request&) -> Result<Response> { return html_response(sign_in_page()); });
  router.add({"POST", "/sign-in", [s](Request& request) { return sign_in(*s, request); }, largest_sign_in});
  router.add({"POST", "/sign-out", [s](Request& request) { return sign_out(*s, request); }, largest_sign_in});
}

}  // namespace vacuform
