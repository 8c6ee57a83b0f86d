// Who is let in, to what, and what a token and a session leave behind.
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <thread>

#include "server/routes/guard.hpp"
#include "server_fixture.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

TEST(ScopesTest, AreReadAndWritten) {
  EXPECT_EQ(Scopes::from("read,submit")->text(), "submit,read");
  for (const char* text : {"", "root", "submit,", ",read", "submit read", "Submit"})
    EXPECT_FALSE(Scopes::from(text)) << text;
  const Scopes admin{Scope::admin};
  EXPECT_TRUE(admin.allow(Scope::submit) && admin.allow(Scope::read) && admin.allow(Scope::admin));
  EXPECT_FALSE(admin.allow(Scope::work));
  EXPECT_FALSE(Scopes{Scope::submit}.allow(Scope::read));
}

class ServerAccess : public ServerTest {
 protected:
  // What the problem of an answer is, by the last piece of its type.
  static std::string problem(const Answer& answer) {
    const json body = json::parse(answer.body, nullptr, false);
    return body.is_object() ? body.value("type", "").substr(std::string("/problems/").size()) : "";
  }
  std::string created(const std::string& token) {
    const Answer made = ask("POST", "/api/v1/jobs", bearer(token) + form_type, form);
    EXPECT_EQ(made.status, 202) << made.body;
    return json::parse(made.body)["id"];
  }
  std::vector<std::string> listed(const std::string& token) {
    std::vector<std::string> ids;
    const json page = json::parse(ask("GET", "/api/v1/jobs", bearer(token)).body);
    for (const json& job : page["jobs"]) ids.push_back(job["id"]);
    return ids;
  }
  // The cookie of someone who signed in, as a browser sends it back.
  std::string signed_in(const std::string& token) {
    const Answer answer =
        ask("POST", "/sign-in", anonymous + std::string(form_type), part("token", "", token) + "--XX--\r\n");
    EXPECT_EQ(answer.status, 303) << answer.body;
    const std::string cookie = answer.header("Set-Cookie");
    return "Cookie: theme=dark; " + cookie.substr(0, cookie.find(';')) + "\r\n";
  }
  std::string origin() const { return "Origin: http://" + host() + "\r\n"; }

  const std::string form = part("scan", "a.stl", "solid") + part("pattern", "p.svg", "<svg/>") + "--XX--\r\n";
};

// The scope that a route needs, by the rules of the API, if it is not public.
Scope needed(const http::Route& route) {
  if (route.pattern.starts_with("/api/v1/leases")) return Scope::work;
  if (route.pattern.starts_with("/api/v1/tokens")) return Scope::admin;
  if (route.pattern == "/api/v1/backup" || route.pattern == "/api/v1/orphans" ||
      route.pattern == "/api/v1/service")
    return Scope::admin;
  if (route.pattern.starts_with("/api/v1/profiles") && route.method != "GET") return Scope::admin;
  if (route.pattern.starts_with("/api/v1/uploads")) return Scope::submit;
  return route.method == "GET" ? Scope::read : Scope::submit;
}

bool is_public(const http::Route& route) { return route.admits.starts_with("everybody: "); }

std::string path_of(const http::Route& route) {
  return std::regex_replace(route.pattern, std::regex("\\{[a-z]+\\}"), "none");
}

TEST_F(ServerAccess, TheNameOfTheSchemeHasNoCase) {
  for (const char* scheme : {"bearer ", "BEARER "})
    EXPECT_EQ(ask("GET", "/api/v1/jobs", std::string("Authorization: ") + scheme + user_ + "\r\n").status,
              200)
        << scheme;
  EXPECT_EQ(ask("GET", "/api/v1/jobs", "Authorization: Basic " + user_ + "\r\n").status, 401);
}

TEST_F(ServerAccess, EveryRouteAsksForItsScopeAndForNoOther) {
  const http::Router router = all_routes(*service_);
  EXPECT_GT(router.routes().size(), 30u);
  for (const auto& route : router.routes()) {
    if (is_public(route)) continue;
    const std::string path = path_of(route);
    const Scope scope = needed(route);
    EXPECT_EQ(route.admits, name(scope)) << route.method << " " << path;
    const Answer nobody = ask(route.method, path, anonymous);
    EXPECT_EQ(nobody.status, 401) << route.method << " " << path;
    EXPECT_EQ(problem(nobody), "unauthorized") << path;
    EXPECT_EQ(nobody.header("WWW-Authenticate"), "Bearer realm=\"vacuform\"") << path;
    for (std::size_t i = 0; i < scope_names.size(); ++i) {
      const auto held = static_cast<Scope>(i);
      const Answer answer = ask(route.method, path, bearer(token("scoped", {held})));
      const bool passes = held == scope || (held == Scope::admin && scope != Scope::work);
      EXPECT_EQ(answer.status != 403, passes) << route.method << " " << path << " with " << name(held);
      if (passes) continue;
      EXPECT_EQ(problem(answer), "forbidden");
      EXPECT_EQ(answer.header("WWW-Authenticate"), "Bearer realm=\"vacuform\", error=\"insufficient_scope\"");
    }
  }
}

// All that answers without a token, on both listeners. A route that is added here needs a reason in routes/guard.cpp.
TEST_F(ServerAccess, ThePublicRoutesAreThese) {
  std::set<std::string> open;
  const http::Router routers[] = {all_routes(*service_), status_routes(*status_)};
  for (const http::Router& router : routers)
    for (const auto& route : router.routes()) {
      if (!is_public(route)) continue;
      open.insert(route.method + " " + route.pattern);
      EXPECT_GT(route.admits.size(), std::string("everybody: ").size() + 10) << route.pattern;
      if (&router == &routers[1]) continue;
      const int status = ask(route.method, path_of(route), anonymous).status;
      EXPECT_TRUE(status != 401 && status != 403) << route.method << " " << route.pattern << ": " << status;
    }
  for (const auto& route : routers[1].routes()) EXPECT_TRUE(is_public(route)) << route.pattern;
  EXPECT_EQ(open, (std::set<std::string>{"GET /healthz", "GET /readyz", "GET /metrics", "GET /sign-in",
                                         "POST /sign-in", "POST /sign-out", "GET /problems/",
                                         "GET /problems/{slug}", "GET /style.css", "GET /job.js",
                                         "GET /app/{name}", "GET /sample/head.stl", "GET /sample/pattern.svg",
                                         "GET /api/v1/openapi.yaml", "GET /api/v1/settings-schema",
                                         "OPTIONS /api/v1/uploads", "OPTIONS /api/v1/uploads/{id}"}));
  for (const char* path : {"/", "/api/v1/jobs", "/api/v1/tokens", "/jobs/none"})
    EXPECT_EQ(ask("OPTIONS", path, anonymous).status, 405) << path;  // no other route answers to it
  http::Router another;
  EXPECT_THROW(add_public(another, "GET", "/api/v1/new", [](http::Request&) { return http::Response(); }),
               std::logic_error);
}

TEST_F(ServerAccess, OnlyTheTokenItselfIsAToken) {
  const auto status = [&](const std::string& shown) { return ask("GET", "/api/v1/jobs", shown).status; };
  EXPECT_EQ(status(bearer(user_)), 200);
  std::string other = user_;
  other.back() = other.back() == '0' ? '1' : '0';
  for (const std::string& wrong :
       {other, user_ + "0", user_.substr(0, user_.size() - 1), std::string(), std::string("vft_"),
        user_.substr(0, 20) + worker_.substr(20), std::string(20'000, 'a')})
    EXPECT_EQ(status(bearer(wrong)), 401) << wrong.substr(0, 100);
  EXPECT_EQ(status("Authorization: Basic " + user_ + "\r\n"), 401);
  EXPECT_EQ(ask("GET", "/api/v1/jobs?token=" + user_, anonymous).status, 400);  // no route takes it

  const auto made = make_token(*store_, {"a", {Scope::read}, wall_clock() + 30});
  std::this_thread::sleep_for(std::chrono::milliseconds(40));
  const Answer expired = ask("GET", "/api/v1/jobs", bearer(made->text));
  EXPECT_EQ(expired.status, 401);
  EXPECT_NE(expired.body.find("expired"), std::string::npos);
}

TEST_F(ServerAccess, AWorkersTokenHasNoOtherScope) {
  for (const char* scopes : {R"(["work","admin"])", R"(["work","read"])"}) {
    const Answer made = ask("POST", "/api/v1/tokens", bearer(admin_),
                            std::string(R"({"owner":"a","scopes":)") + scopes + "}");
    EXPECT_EQ(made.status, 400) << scopes;
    EXPECT_EQ(json::parse(made.body)["what"], "a worker's token has the scope work alone");
  }
}

TEST_F(ServerAccess, ATokenEndsNoSessionOfAnother) {
  const auto cookie = [](const Result<std::string>& set) {
    return "Cookie: " + set->substr(0, set->find(';')) + "\r\n";
  };
  const auto status = [&](const std::string& shown) { return ask("GET", "/api/v1/jobs", shown).status; };
  const std::string other = cookie(access_->sign_in(admin_, false)),
                    first = cookie(access_->sign_in(user_, false));
  std::string last;
  for (int i = 0; i < 60; ++i) last = cookie(access_->sign_in(user_, false));
  EXPECT_EQ(status(other), 200);
  EXPECT_EQ(status(last), 200);
  EXPECT_EQ(status(first), 401);
}

TEST_F(ServerAccess, AdministratorsMakeListAndRevokeTokens) {
  const auto admin = [&](const std::string& method, const std::string& path, const std::string& body = "") {
    return ask(method, path, bearer(admin_), body);
  };
  const Answer made =
      admin("POST", "/api/v1/tokens", R"({"owner":"station-3","scopes":["read","submit"],"days":90})");
  ASSERT_EQ(made.status, 201) << made.body;
  const json token = json::parse(made.body);
  EXPECT_EQ(token["scopes"], (json{"submit", "read"}));
  EXPECT_FALSE(token["expires"].is_null());
  const std::string text = token["token"], id = token["id"];
  EXPECT_EQ(ask("GET", "/api/v1/jobs", bearer(text)).status, 200);

  const Answer list = admin("GET", "/api/v1/tokens");
  EXPECT_NE(list.body.find(id), std::string::npos);
  EXPECT_EQ(list.body.find(text.substr(text.size() - 64)), std::string::npos);  // shown once
  EXPECT_EQ(admin("DELETE", "/api/v1/tokens/" + id).status, 204);
  EXPECT_EQ(admin("DELETE", "/api/v1/tokens/" + id).status, 204);
  EXPECT_EQ(admin("DELETE", "/api/v1/tokens/none").status, 404);
  const Answer revoked = ask("GET", "/api/v1/jobs", bearer(text));
  EXPECT_EQ(revoked.status, 401);
  EXPECT_NE(revoked.body.find("revoked"), std::string::npos);

  for (const char* body :
       {"", "[]", "{}", R"({"owner":"a"})", R"({"owner":"Jane Doe","scopes":["read"]})",
        R"({"owner":"a","scopes":["root"]})", R"({"owner":"a","scopes":["read"],"days":0})",
        R"({"owner":"a","scopes":["read"],"days":1e9})", R"({"owner":"a","scopes":["read"],"x":1})"})
    EXPECT_EQ(admin("POST", "/api/v1/tokens", body).status, 400) << body;
}

TEST_F(ServerAccess, TheStoreKeepsNoSecret) {
  const std::string session = signed_in(user_), value = session.substr(session.rfind('=') + 1, 64);
  store_->status().value();
  for (const auto& entry : std::filesystem::recursive_directory_iterator(data_)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    for (const std::string& token : {user_, worker_, admin_})
      EXPECT_EQ(bytes.find(token.substr(token.size() - 64)), std::string::npos) << entry.path();
    EXPECT_EQ(bytes.find(value), std::string::npos) << entry.path();
  }
}

TEST_F(ServerAccess, EachSeesHisOwnJobsAndTheAdministratorAll) {
  const std::string other = token("station-2", {Scope::submit, Scope::read});
  const std::string mine = created(user_), his = created(other);
  EXPECT_EQ(listed(user_), std::vector<std::string>{mine});
  EXPECT_EQ(listed(other), std::vector<std::string>{his});
  EXPECT_EQ(listed(admin_), (std::vector<std::string>{his, mine}));
  EXPECT_EQ(listed(token("station-1", {Scope::read})), std::vector<std::string>{mine});  // as after a renewal
  for (const auto& [method, tail] :
       {std::pair{"GET", ""}, std::pair{"GET", "/artifacts"}, std::pair{"GET", "/artifacts.zip"},
        std::pair{"GET", "/artifacts/print.png"}, std::pair{"POST", "/cancel"}, std::pair{"DELETE", ""}}) {
    const std::string path = "/api/v1/jobs/" + his + tail;
    EXPECT_EQ(ask(method, path).status, 404) << method << " " << path;
    EXPECT_EQ(problem(ask(method, path)), "not-found") << path;
  }
  EXPECT_EQ(ask("GET", "/jobs/" + his).status, 404);
  EXPECT_EQ(ask("POST", "/jobs/" + his + "/cancel").status, 404);
  EXPECT_EQ(ask("GET", "/jobs").body.find(his), std::string::npos);
  EXPECT_EQ(ask("POST", "/api/v1/jobs/" + his + "/cancel", bearer(admin_)).status, 200);
}

TEST_F(ServerAccess, IdempotencyKeysOfTwoOwnersNeverMeet) {
  const std::string key = "Idempotency-Key: scan-000001\r\n",
                    other = token("station-2", {Scope::submit, Scope::read});
  const auto id = [&](const std::string& token) {
    return json::parse(ask("POST", "/api/v1/jobs", key + bearer(token) + form_type, form).body)["id"]
        .get<std::string>();
  };
  const std::string mine = id(user_);
  EXPECT_EQ(id(user_), mine);
  EXPECT_NE(id(other), mine);
}

TEST_F(ServerAccess, WrongTokensAreTurnedAwayAndRightOnesNever) {
  const auto wrong = [&] { return ask("GET", "/api/v1/jobs", bearer("vft_wrong")); };
  for (int i = 0; i < 20; ++i) EXPECT_EQ(wrong().status, 401) << i;
  Answer answer = wrong();
  for (int i = 0; i < 20 && answer.status == 401; ++i) answer = wrong();  // one more is allowed each second
  EXPECT_EQ(answer.status, 429);
  EXPECT_EQ(problem(answer), "too-many-attempts");
  EXPECT_EQ(answer.header("Retry-After"), "60");
  EXPECT_EQ(ask("GET", "/api/v1/jobs").status, 200);
  EXPECT_EQ(ask("GET", "/api/v1/jobs", anonymous).status, 401);  // to show none is no attempt
  signed_in(user_);
}

TEST_F(ServerAccess, ABrowserSignsInAndOut) {
  const std::string html = "Accept: text/html\r\n";
  const Answer stranger = ask("GET", "/", anonymous + html);
  EXPECT_EQ(stranger.status, 303);
  EXPECT_EQ(stranger.header("Location"), "/sign-in");
  const Answer page = ask("GET", "/sign-in", anonymous);
  EXPECT_NE(page.body.find("name=\"token\" type=\"password\""), std::string::npos);
  EXPECT_EQ(page.body.find("Sign out"), std::string::npos);

  const Answer wrong = ask("POST", "/sign-in", anonymous + std::string(form_type),
                           part("token", "", "nonsense") + "--XX--\r\n");
  EXPECT_EQ(wrong.status, 401);
  EXPECT_NE(wrong.body.find("role=\"alert\""), std::string::npos);
  EXPECT_TRUE(wrong.header("Set-Cookie").empty());

  const Answer right = ask("POST", "/sign-in", anonymous + std::string(form_type),
                           part("token", "", " " + user_ + "\n") + "--XX--\r\n");
  EXPECT_EQ(right.header("Location"), "/");
  const std::string cookie = right.header("Set-Cookie");
  for (const char* attribute : {"; HttpOnly", "; SameSite=Strict", "; Path=/", "; Max-Age=43200"})
    EXPECT_NE(cookie.find(attribute), std::string::npos) << cookie;
  EXPECT_EQ(cookie.find(user_.substr(user_.size() - 64)),
            std::string::npos);  // a browser never holds the token

  const std::string session = signed_in(user_);
  EXPECT_NE(ask("GET", "/jobs", session).body.find("Sign out"), std::string::npos);
  const Answer made = ask("POST", "/api/v1/jobs", session + origin() + form_type, form);
  EXPECT_EQ(made.status, 202) << made.body;
  const std::string id = json::parse(made.body)["id"];
  EXPECT_EQ(ask("GET", "/jobs/" + id, session).status, 200);
  EXPECT_EQ(ask("GET", "/api/v1/jobs/" + id, session).status, 200);

  const Answer out = ask("POST", "/sign-out", session + origin());
  EXPECT_EQ(out.header("Location"), "/sign-in");
  EXPECT_NE(out.header("Set-Cookie").find("Max-Age=0"), std::string::npos);
  EXPECT_EQ(ask("GET", "/api/v1/jobs", session).status, 401);
}

TEST_F(ServerAccess, ALinkSignsABrowserInOnce) {
  const std::string links = "/api/v1/tokens/" + user_.substr(4, 16) + "/link", html = "Accept: text/html\r\n";
  const auto link = [&] {
    const Answer made = ask("POST", links, bearer(admin_));
    EXPECT_EQ(made.status, 201) << made.body;
    return json::parse(made.body)["path"].get<std::string>();
  };
  const std::string first = link();
  // A browser that fetches ahead, or comes from another site, gets a page with a button, and the link stays good.
  for (const char* ahead : {"Sec-Purpose: prefetch\r\n", "Sec-Purpose: prefetch;prerender\r\n",
                            "Sec-Fetch-Site: cross-site\r\n"}) {
    const Answer page = ask("GET", first, anonymous + html + ahead);
    EXPECT_EQ(page.status, 200);
    EXPECT_NE(page.body.find("It works once."), std::string::npos) << page.body;
    EXPECT_TRUE(page.header("Set-Cookie").empty());
    EXPECT_EQ(page.header("Cache-Control"), "no-store");
  }
  EXPECT_EQ(ask("HEAD", first, anonymous).status, 200);
  const Answer in = ask("GET", first, signed_in(admin_) + html + "Sec-Fetch-Site: none\r\n");  // over another
  EXPECT_EQ(in.status, 303) << in.body;
  EXPECT_EQ(in.header("Location"), "/");
  const std::string cookie = in.header("Set-Cookie");
  EXPECT_NE(cookie.find("; HttpOnly; SameSite=Strict"), std::string::npos) << cookie;
  const std::string session = "Cookie: " + cookie.substr(0, cookie.find(';')) + "\r\n";
  EXPECT_EQ(json::parse(ask("GET", "/api/v1/session", session).body)["owner"], "station-1");

  const Answer again = ask("GET", first, anonymous + html);
  EXPECT_EQ(again.status, 401);
  EXPECT_NE(again.body.find("the link is wrong, was used, or has expired"), std::string::npos) << again.body;
  EXPECT_TRUE(again.header("Set-Cookie").empty());
  EXPECT_EQ(ask("GET", first, session + html).header("Location"), "/");  // who is signed in sees no error

  const std::string second = link(), code = second.substr(second.find('=') + 1);
  const std::string body = part("link", "", code) + "--XX--\r\n";
  EXPECT_EQ(
      ask("POST", "/sign-in", anonymous + std::string("Origin: http://example.org\r\n") + form_type, body)
          .status,
      403);
  EXPECT_EQ(ask("POST", "/sign-in", anonymous + std::string(form_type), body).status, 303);
  EXPECT_EQ(ask("POST", "/sign-in", anonymous + std::string(form_type), body).status, 401);
  EXPECT_EQ(ask("POST", links, bearer(user_)).status, 403);
  EXPECT_EQ(ask("POST", "/api/v1/tokens/0123456789abcdef/link", bearer(admin_)).status, 404);
}

TEST_F(ServerAccess, WrongLinksCountAsWrongTokens) {
  Answer answer;
  for (int i = 0; i < 30 && answer.status != 429; ++i)
    answer = ask("GET", "/sign-in?link=" + std::string(64, 'a'), anonymous);
  EXPECT_EQ(answer.status, 429);
  signed_in(user_);
}

TEST_F(ServerAccess, TheSignInPageSaysWhenToTryAgain) {
  Answer answer;
  for (int i = 0; i < 30 && answer.status != 429; ++i)
    answer = ask("POST", "/sign-in", anonymous + std::string(form_type),
                 part("token", "", "wrong") + "--XX--\r\n");
  EXPECT_EQ(answer.status, 429);
  EXPECT_EQ(answer.header("Retry-After"), "60");
}

// The prefix makes a browser accept the cookie only by TLS and for this host alone.
TEST_F(ServerAccess, TellsWhoAsksAndUntilWhen) {
  const auto session = [&](const std::string& headers) {
    const Answer answer = ask("GET", "/api/v1/session", headers);
    EXPECT_EQ(answer.status, 200) << answer.body;
    return json::parse(answer.body);
  };
  const json by_token = session(bearer(user_));
  EXPECT_EQ(by_token["owner"], "station-1");
  EXPECT_EQ(by_token["token"], user_.substr(4, 16));
  EXPECT_EQ(by_token["scopes"], (json{"submit", "read"}));
  EXPECT_EQ(by_token["expires"], nullptr);
  EXPECT_EQ(by_token["session_ends"], nullptr);

  constexpr Millis minute = 60'000, hour = 60 * minute;
  const Millis before = wall_clock();
  const json by_cookie = session(signed_in(user_));
  EXPECT_EQ(by_cookie["owner"], "station-1");
  EXPECT_EQ(by_cookie["expires"], nullptr);
  const Millis ends = from_rfc3339(by_cookie["session_ends"].get<std::string>()).value();
  EXPECT_GE(ends, before + 12 * hour - 1000);
  EXPECT_LE(ends, wall_clock() + 12 * hour);

  // A token that ends before its session ends the session, too.
  const auto brief = make_token(*store_, {"station-2", {Scope::read}, before + 5 * minute});
  const json short_one = session(signed_in(brief->text));
  EXPECT_EQ(short_one["expires"], rfc3339(before + 5 * minute));
  EXPECT_EQ(short_one["session_ends"], short_one["expires"]);
  EXPECT_EQ(ask("GET", "/api/v1/session", anonymous).status, 401);
}

TEST_F(ServerAccess, TheCookieIsForTlsAloneBehindAFront) {
  http::ServerOptions options;
  options.refuse = refuse;
  options.front_host = "front.example.org";
  const auto server = http::Server::start(std::move(options), all_routes(*service_));
  ASSERT_TRUE(server);
  const auto by_front = [&](const std::string& line, const std::string& headers, const std::string& body) {
    const int socket = connected_to(**server);
    send_all(socket, line + " HTTP/1.1\r\nHost: front.example.org\r\nConnection: close\r\n" + headers +
                         "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
    return parsed(receive_all(socket));
  };
  const std::string body = part("token", "", user_) + "--XX--\r\n";
  const Answer in = by_front("POST /sign-in", form_type, body);
  const std::string cookie = in.header("Set-Cookie"), pair = cookie.substr(0, cookie.find(';'));
  EXPECT_TRUE(cookie.starts_with("__Host-vacuform-session=")) << cookie;
  EXPECT_NE(cookie.find("; Secure"), std::string::npos);
  EXPECT_NE(cookie.find("; Path=/;"), std::string::npos);
  EXPECT_EQ(by_front("GET /api/v1/jobs", "Cookie: " + pair + "\r\n", "").status, 200);
  EXPECT_EQ(by_front("GET /api/v1/jobs", "Cookie: " + pair.substr(7) + "\r\n", "").status, 401);
  EXPECT_EQ(
      by_front("POST /sign-out", "Origin: http://front.example.org\r\nCookie: " + pair + "\r\n", "").status,
      403);
  // Through a front, a link waits for a click: programs that check mail open it before its reader does.
  const std::string link = json::parse(
                        ask("POST", "/api/v1/tokens/" + user_.substr(4, 16) + "/link", bearer(admin_))
                            .body)["path"],
                    code = link.substr(link.find('=') + 1);
  const Answer page = by_front("GET " + link, "", "");
  EXPECT_EQ(page.status, 200);
  EXPECT_TRUE(page.header("Set-Cookie").empty());
  EXPECT_NE(page.body.find("name=\"link\" value=\"" + code + "\""), std::string::npos) << page.body;
  EXPECT_EQ(by_front("POST /sign-in", form_type, part("link", "", code) + "--XX--\r\n").status, 303);
  const Answer out =
      by_front("POST /sign-out", "Origin: https://front.example.org\r\nCookie: " + pair + "\r\n", "");
  EXPECT_TRUE(out.header("Set-Cookie").starts_with("__Host-vacuform-session=;")) << out.header("Set-Cookie");
}

// A page of another origin can make a browser send the cookie's bearer somewhere; it cannot make it send our Origin.
TEST_F(ServerAccess, ACookieAloneChangesNothing) {
  const std::string session = signed_in(user_), id = created(user_), path = "/api/v1/jobs/" + id + "/cancel";
  EXPECT_EQ(ask("POST", path, session).status, 400);
  EXPECT_EQ(ask("POST", "/jobs/" + id + "/cancel", session).status, 400);
  EXPECT_EQ(ask("POST", path, session + "Origin: http://example.org\r\n").status, 403);
  EXPECT_EQ(ask("POST", path, session + "Origin: null\r\n").status, 403);
  EXPECT_EQ(ask("POST", "/sign-in", anonymous + std::string("Origin: http://example.org\r\n") + form_type,
                part("token", "", user_) + "--XX--\r\n")
                .status,
            403);
  EXPECT_EQ(json::parse(ask("GET", "/api/v1/jobs/" + id).body)["state"], "queued");
  EXPECT_EQ(ask("POST", path, session + origin()).status, 200);
}

TEST_F(ServerAccess, ASessionEndsWithItsToken) {
  const std::string session = signed_in(user_);
  EXPECT_EQ(ask("GET", "/api/v1/jobs", session).status, 200);
  ASSERT_TRUE(store_->revoke_token(user_.substr(4, 16)));
  EXPECT_EQ(ask("GET", "/api/v1/jobs", session).status, 401);
  EXPECT_EQ(ask("GET", "/api/v1/jobs", "Cookie: vacuform-session=" + std::string(64, '0') + "\r\n").status,
            401);
}

}  // namespace
}  // namespace vacuform
