// Sessions of browsers on a real store, as one server and another see them.
#include <gtest/gtest.h>

#include <filesystem>

#include "api/base/secrets.hpp"
#include "server/access/access.hpp"
#include "server/access/tokens.hpp"
#include "server_fixture.hpp"

namespace vacuform {
namespace {

constexpr Millis hour = 3'600'000;

class SessionTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    data_ = std::filesystem::temp_directory_path() / ("vacuform-session-" + random_hex(8));
    start();
    token_ = make_token(*store_, {"station-1", {Scope::read}, std::nullopt}, clock_)->text;
  }
  void TearDown() override {
    stop();
    std::filesystem::remove_all(data_);
  }
  // Two servers on one store.
  void start() {
    StoreOptions options;
    options.clock = clock_;
    store_ = std::move(*open_store(data_, options));
    one_ = std::make_unique<Access>(*store_, *store_, clock_);
    two_ = std::make_unique<Access>(*store_, *store_, clock_);
  }
  void stop() {
    one_.reset();
    two_.reset();
    store_.reset();
  }

  // A request of the browser that got this Set-Cookie.
  static http::Request request(const Result<std::string>& cookie, const std::string& method = "GET") {
    EXPECT_TRUE(cookie) << cookie.error().text();
    http::Request request;
    request.method = method;
    request.headers = {{"Cookie", cookie ? cookie->substr(0, cookie->find(';')) : ""}};
    if (method != "GET") request.headers.push_back({"Origin", "http://127.0.0.1"});
    return request;
  }
  // The owner that a server takes the browser for, or the reason for a refusal.
  static std::string seen(Access& server, const http::Request& request) {
    const auto caller = server.check(request, Scope::read);
    return caller ? caller->owner : caller.error().what;
  }

  std::filesystem::path data_;
  Millis now_ = 1'800'000'000'000;
  const Clock clock_ = [this] { return now_; };
  std::string token_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<Access> one_, two_;
};

TEST_F(SessionTest, OutlivesARestartOfTheServer) {
  const auto browser = request(one_->sign_in(token_, false));
  const Caller before = one_->check(browser, Scope::read).value();
  EXPECT_EQ(before.session_ends, now_ + 12 * hour);
  stop();
  now_ += hour;
  start();
  const Caller after = one_->check(browser, Scope::read).value();
  EXPECT_EQ(after.owner, "station-1");
  EXPECT_EQ(after.token, before.token);
  EXPECT_EQ(after.session_ends, before.session_ends);
}

TEST_F(SessionTest, IsKnownToEveryServerUntilOneOfThemEndsIt) {
  const auto cookie = one_->sign_in(token_, false);
  const auto browser = request(cookie);
  EXPECT_EQ(seen(*one_, browser), "station-1");
  EXPECT_EQ(seen(*two_, browser), "station-1");
  const auto taken = two_->sign_out(request(cookie, "POST"));
  ASSERT_TRUE(taken) << taken.error().text();
  EXPECT_NE(taken->find("Max-Age=0"), std::string::npos);
  EXPECT_EQ(seen(*one_, browser), "the session has ended");
  EXPECT_EQ(seen(*two_, browser), "the session has ended");
}

TEST_F(SessionTest, EndsAfterTwelveHours) {
  const auto cookie = one_->sign_in(token_, false);
  const std::string value = cookie->substr(cookie->find('=') + 1, 64);
  now_ += 12 * hour - 1;
  EXPECT_EQ(seen(*two_, request(cookie)), "station-1");
  now_ += 1;
  EXPECT_EQ(seen(*two_, request(cookie)), "the session has ended");
  EXPECT_TRUE(store_->find_session(text_hash(value)));
  ASSERT_TRUE(one_->sign_in(token_, false));  // which deletes it
  EXPECT_FALSE(store_->find_session(text_hash(value)));
}

TEST_F(SessionTest, EndsWithItsToken) {
  const auto brief = make_token(*store_, {"station-2", {Scope::read}, now_ + hour}, clock_);
  const auto first = request(one_->sign_in(brief->text, false)),
             second = request(one_->sign_in(token_, false));
  now_ += hour - 1;
  EXPECT_EQ(seen(*two_, first), "station-2");
  now_ += 1;
  EXPECT_EQ(seen(*two_, first), "the session has ended");
  EXPECT_EQ(seen(*two_, second), "station-1");
  ASSERT_TRUE(store_->revoke_token(token_.substr(4, 16)));
  EXPECT_EQ(seen(*two_, second), "the session has ended");
}

TEST_F(SessionTest, ATokenWithTooManySessionsLosesItsOldest) {
  std::vector<http::Request> browsers;
  for (int i = 0; i < most_sessions_of_token + 1; ++i, ++now_)
    browsers.push_back(request((i % 2 == 0 ? one_ : two_)->sign_in(token_, false)));
  EXPECT_EQ(seen(*one_, browsers[0]), "the session has ended");
  for (std::size_t i = 1; i < browsers.size(); ++i) EXPECT_EQ(seen(*one_, browsers[i]), "station-1") << i;
}

TEST_F(SessionTest, ALinkSignsInOnceWithinAnHour) {
  const std::string id = token_.substr(4, 16);
  const auto link = one_->make_link(id), late = one_->make_link(id);
  ASSERT_TRUE(link && late);
  EXPECT_EQ(link->expires, now_ + hour);
  EXPECT_EQ(link->code.size(), 64u);
  stop();  // the links outlive a restart
  start();
  now_ += hour - 1;
  EXPECT_EQ(seen(*one_, request(two_->sign_in_by_link(link->code, false))), "station-1");
  const auto again = one_->sign_in_by_link(link->code, false);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, Code::unauthorized);
  now_ += 1;
  EXPECT_FALSE(one_->sign_in_by_link(late->code, false));
}

TEST_F(SessionTest, ALinkEndsWithItsToken) {
  const auto brief = make_token(*store_, {"station-2", {Scope::read}, now_ + hour / 2}, clock_);
  const auto first = one_->make_link(token_.substr(4, 16)), second = one_->make_link(brief->token.id);
  ASSERT_TRUE(first && second);
  ASSERT_TRUE(store_->revoke_token(token_.substr(4, 16)));
  EXPECT_FALSE(one_->sign_in_by_link(first->code, false));
  EXPECT_EQ(one_->make_link(token_.substr(4, 16)).error().code, Code::conflict);
  EXPECT_EQ(one_->make_link("0123456789abcdef").error().code, Code::not_found);
  now_ += hour / 2;
  EXPECT_FALSE(one_->sign_in_by_link(second->code, false));
}

// The sessions of a server that cannot reach its database.
class NoSessions : public SessionTable {
 public:
  Result<void> add_session(const Session&) override { return away(); }
  Result<FoundSession> find_session(const std::string&) override { return away(); }
  Result<void> end_session(const std::string&) override { return away(); }
  Result<void> add_link(const SignInLink&) override { return away(); }
  Result<Token> use_link(const std::string&) override { return away(); }

 private:
  static tl::unexpected<Error> away() { return fail(Code::unavailable, "the database cannot be reached"); }
};

class ServerSession : public ServerTest {};

TEST_F(ServerSession, WithoutADatabaseABrowserKeepsItsCookie) {
  NoSessions none;
  Access access(*store_, none);
  Service service{*store_, access, workers_, *uploads_, 30, 1};
  http::ServerOptions options;
  options.refuse = refuse;
  const auto server = http::Server::start(std::move(options), all_routes(service));
  ASSERT_TRUE(server) << server.error().text();
  const std::string address = "127.0.0.1:" + std::to_string((*server)->port());
  const auto answer = [&](const std::string& line, const std::string& headers, const std::string& body = "") {
    const int socket = connected_to(**server);
    send_all(socket, line + " HTTP/1.1\r\nHost: " + address + "\r\nConnection: close\r\n" + headers +
                         "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
    return parsed(receive_all(socket));
  };
  const std::string cookie = "Cookie: vacuform-session=" + std::string(64, 'a') + "\r\n",
                    origin = "Origin: http://" + address + "\r\n";
  for (const Answer& refused :
       {answer("GET /api/v1/session", cookie), answer("POST /sign-out", cookie + origin),
        answer("POST /sign-out", cookie + origin + "Accept: text/html\r\n"),
        answer("POST /sign-in", form_type, part("token", "", user_) + "--XX--\r\n")}) {
    EXPECT_EQ(refused.status, 503) << refused.head << refused.body;
    EXPECT_EQ(refused.header("Set-Cookie"), "") << refused.head;
    EXPECT_NE(refused.body.find("the database cannot be reached"), std::string::npos) << refused.body;
  }
}

}  // namespace
}  // namespace vacuform
