// What a hostile or broken client can send to a real server, byte by byte.
#include <nlohmann/json.hpp>
#include <thread>

#include "server_fixture.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

class ServerLimits : public ServerTest {
 protected:
  // Every refusal is a complete problem.
  void expect_problem(const Answer& answer, int status, const std::string& what) {
    EXPECT_EQ(answer.status, status) << answer.body;
    EXPECT_EQ(answer.header("Content-Type"), "application/problem+json");
    EXPECT_EQ(answer.header("Connection"), "close");
    const json problem = json::parse(answer.body, nullptr, false);
    ASSERT_TRUE(problem.is_object()) << answer.body;
    EXPECT_EQ(problem["status"], status);
    EXPECT_EQ(problem["what"], what);
    EXPECT_TRUE(problem["type"].get<std::string>().starts_with("/problems/"));
    EXPECT_FALSE(problem["mend"].get<std::string>().empty());
  }
  int jobs() { return static_cast<int>(store_->list(100, "")->jobs.size()); }
};

TEST_F(ServerLimits, ChunkedBodiesAreRefused) {
  expect_problem(ask("POST", "/api/v1/jobs", std::string("Transfer-Encoding: chunked\r\n") + form_type), 411,
                 "a body without Content-Length is not accepted");
  expect_problem(raw("POST /api/v1/jobs HTTP/1.1\r\nHost: " + host() +
                     "\r\nTransfer-Encoding: chunked\r\nContent-Length: 5\r\n\r\n0\r\n\r\n"),
                 411, "a body without Content-Length is not accepted");
  expect_problem(ask("POST", "/api/v1/jobs", "Content-Encoding: gzip\r\n", "x"), 501,
                 "an encoded body is not accepted");
}

TEST_F(ServerLimits, HeadsAreBoundedInBytesAndLines) {
  expect_problem(ask("GET", "/healthz", "X: " + std::string(10 << 20, 'x') + "\r\n"), 431,
                 "the head of the request is longer than 32768 bytes");
  std::string lines;
  for (int i = 0; i < 200; ++i) lines += "A: b\r\n";
  expect_problem(ask("GET", "/healthz", lines), 431, "the request has more than 100 header lines");
  expect_problem(raw("GET /" + std::string(5000, 'x') + " HTTP/1.1\r\nHost: localhost\r\n\r\n"), 414,
                 "the address is too long");
}

TEST_F(ServerLimits, MalformedHeadsAreRefused) {
  expect_problem(ask("GET", "/healthz", "no colon\r\n"), 400, "a header line is malformed");
  expect_problem(ask("GET", "/healthz", "Spaced : x\r\n"), 400, "a header line is malformed");
  expect_problem(ask("GET", "/healthz", std::string("X: a\0b\r\n", 8)), 400, "a header line is malformed");
  expect_problem(ask("GET", "/healthz", " folded: x\r\n"), 400, "a header line is malformed");
  expect_problem(ask("GET", "/healthz", "Content-Length: -1\r\n"), 400,
                 "Content-Length is not one whole number");
  expect_problem(ask("GET", "/healthz", "Content-Length: 1\r\nContent-Length: 2\r\n"), 400,
                 "Content-Length is not one whole number");
  expect_problem(ask("GET", "/healthz", "Content-Length: 99999999999999999999\r\n"), 400,
                 "Content-Length is not one whole number");
  expect_problem(raw("GET /healthz HTTP/1.1\r\n\r\n"), 400, "there is no Host");
  expect_problem(ask("GET", "/healthz", "Host: localhost\r\n"), 400, "there is more than one Host");
  expect_problem(raw("complete nonsense\r\n\r\n"), 400, "there is no Host");
  expect_problem(raw("complete nonsense\r\nHost: localhost\r\n\r\n"), 400, "the request line is malformed");
}

TEST_F(ServerLimits, ASlowHeadIsEnded) {
  const int socket = connected();
  send_all(socket, "GET /healthz HTTP/1.1\r\n");
  expect_problem(parsed(receive_all(socket)), 408, "the head of the request took too long");
}

TEST_F(ServerLimits, ASlowBodyIsEndedAndLeavesNothing) {
  const int socket = connected();
  send_all(socket, "POST /api/v1/jobs HTTP/1.1\r\nHost: " + host() + "\r\n" + bearer(user_) + form_type +
                       "Content-Length: 1000\r\n\r\n" + part("scan", "a.stl", "half"));
  expect_problem(parsed(receive_all(socket)), 422, "the body of the request came too slowly");
  EXPECT_TRUE(std::filesystem::is_empty(data_ / "incoming"));
}

TEST_F(ServerLimits, ABodyThatBreaksOffMakesNoJob) {
  const int socket = connected();
  send_all(socket, "POST /api/v1/jobs HTTP/1.1\r\nHost: " + host() + "\r\n" + bearer(user_) + form_type +
                       "Content-Length: 1000\r\n\r\n" + part("scan", "a.stl", "half"));
  ::shutdown(socket, SHUT_WR);
  EXPECT_EQ(parsed(receive_all(socket)).status, 400);
  EXPECT_EQ(jobs(), 0);
  EXPECT_TRUE(std::filesystem::is_empty(data_ / "incoming"));
}

TEST_F(ServerLimits, AFormThatAnnouncesTooMuchIsRefusedBeforeItsBytes) {
  expect_problem(raw("POST /api/v1/jobs HTTP/1.1\r\nHost: " + host() + "\r\n" + bearer(user_) + form_type +
                     "Content-Length: 3000000000\r\n\r\n"),
                 413, "the form is larger than 1409 MiB");
}

TEST_F(ServerLimits, SettingsAreBounded) {
  expect_problem(submit(part("settings", "", std::string(70'000, ' '))), 413,
                 "the settings are longer than 64 KiB");
  expect_problem(submit(part("print.dpi", "", "300") + part("print.dpi", "", "300")), 400,
                 "an unknown or doubled part of the form: print.dpi");
  expect_problem(submit(part("virus", "x.exe", "MZ")), 400, "an unknown or doubled part of the form: virus");
  expect_problem(submit(part("scan", "again.stl", "x")), 400, "there is more than one scan");
  EXPECT_EQ(jobs(), 0);
}

// The bytes behind a refused or unread body must never become a request.
TEST_F(ServerLimits, NothingBehindARequestIsReadAsAnother) {
  const std::string second =
      "POST /api/v1/jobs HTTP/1.1\r\nHost: " + host() + "\r\n" + bearer(user_) + form_type;
  const std::string body = part("scan", "a.stl", "x") + part("pattern", "p.svg", "x") + "--XX--\r\n";
  const std::string smuggled = second + "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
  for (const std::string& first :
       {"GET /nowhere HTTP/1.1\r\nHost: " + host() +
            "\r\nContent-Length: " + std::to_string(smuggled.size()) + "\r\n\r\n",
        "GET /healthz HTTP/1.1\r\nHost: " + host() + "\r\nConnection: keep-alive\r\n\r\n",
        "POST /api/v1/jobs HTTP/1.1\r\nHost: " + host() + "\r\nTransfer-Encoding: chunked\r\n\r\n",
        "POST /api/v1/jobs HTTP/1.1\r\nHost: " + host() + "\r\nContent-Length: 9000000000\r\n" +
            bearer(user_) + form_type + "\r\n"}) {
    const int socket = connected();
    send_all(socket, first + smuggled);
    const std::string all = receive_all(socket);
    EXPECT_EQ(all.find("HTTP/1.1", 8), std::string::npos) << all;  // one answer
  }
  EXPECT_EQ(jobs(), 0);
}

TEST_F(ServerLimits, NamesThatPointHereAreNotBelieved) {
  expect_problem(raw("GET /api/v1/jobs HTTP/1.1\r\nHost: rebound.example.org\r\n\r\n"), 421,
                 "this server answers on loopback only");
  expect_problem(ask("POST", "/api/v1/jobs", "Origin: http://example.org\r\n"), 403,
                 "the request comes from a page of another origin");
  EXPECT_EQ(ask("GET", "/healthz", "REMOTE_ADDR: 1.2.3.4\r\n").status, 200);
}

TEST_F(ServerLimits, PathsLeadNowhereElse) {
  const json job = json::parse(submit().body);
  const std::string base = "/api/v1/jobs/" + job["id"].get<std::string>() + "/artifacts/";
  for (const char* name : {"..%2f..%2fworker-token", "%2e%2e/%2e%2e/jobs.sqlite", "../../../jobs.sqlite",
                           "print.png%00", "print.png/", "%2fetc%2fpasswd", "report.json"})
    EXPECT_EQ(ask("GET", base + name).status, 404) << name;
  for (const char* name : {"..%2f..%2fevil", "evil.sh", "print.png%00.sh", "%2ftmp%2fevil"}) {
    const int status = ask("PUT", "/api/v1/leases/" + job["id"].get<std::string>() + "/artifacts/" + name,
                           worker_headers(std::string(64, 'b')), "x")
                           .status;
    EXPECT_TRUE(status == 400 || status == 404) << name << " " << status;
  }
}

TEST_F(ServerLimits, AFaultKeepsItsTextToItself) {
  const Answer answer = ask("GET", "/fault");
  expect_problem(answer, 500, "the server met a fault of its own");
  EXPECT_EQ((answer.head + answer.body).find("secret"), std::string::npos);
}

TEST_F(ServerLimits, MethodsThatAPathDoesNotKnow) {
  const Answer answer = ask("DELETE", "/api/v1/jobs");
  expect_problem(answer, 405, "this address does not answer to that method");
  EXPECT_EQ(answer.header("Allow"), "POST, GET, HEAD");
}

// Clients that send bodies without end hold every thread of the one listener; the other one has its own.
TEST_F(ServerLimits, HealthAnswersWhileEveryThreadIsHeld) {
  std::vector<int> stalled;
  const int threads = http::ServerOptions{}.threads + http::ServerOptions{}.streams;
  for (int i = 0; i < threads; ++i) {
    stalled.push_back(connected());
    send_all(stalled.back(), "POST /api/v1/jobs HTTP/1.1\r\nHost: " + host() + "\r\n" + bearer(user_) +
                                 form_type + "Content-Length: 1000000\r\n\r\n" +
                                 part("scan", "a.stl", "half"));
  }
  while (server_->connections() < threads) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  for (const char* path : {"/healthz", "/readyz", "/metrics"}) {
    const auto begun = std::chrono::steady_clock::now();
    EXPECT_EQ(status(path).status, 200) << path;
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(1)) << path;
  }
  EXPECT_NE(status("/metrics").body.find("\nvacuform_http_connections " + std::to_string(threads) + "\n"), std::string::npos);
  for (const int socket : stalled) ::close(socket);
}

TEST_F(ServerLimits, StalledConnectionsDoNotBlockOthers) {
  std::vector<int> stalled;
  for (int i = 0; i < 200; ++i) stalled.push_back(connected());  // more than there are threads
  for (int i = 0; i < 128; ++i) send_all(stalled[static_cast<std::size_t>(i)], "GET / HTTP/1.1\r\n");
  const auto begun = std::chrono::steady_clock::now();
  EXPECT_EQ(ask("GET", "/healthz").status, 200);
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(3));
  for (const int socket : stalled) ::close(socket);
}

}  // namespace
}  // namespace vacuform
