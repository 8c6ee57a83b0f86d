// Input that a hostile or broken client can send to a real server, byte by byte.
#include <poll.h>

#include <atomic>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "server/http/admission.hpp"
#include "server/jobs/blob_response.hpp"
#include "server_fixture.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

class ServerLimits : public ServerTest {
 protected:
  // Every refusal is a complete problem document.
  void expect_problem(const Answer& answer, int status, const std::string& what) {
    EXPECT_EQ(answer.status, status) << answer.body;
    EXPECT_EQ(answer.header("Content-Type"), "application/problem+json");
    const json problem = json::parse(answer.body, nullptr, false);
    ASSERT_TRUE(problem.is_object()) << answer.body;
    EXPECT_EQ(problem["status"], status);
    EXPECT_EQ(problem["what"], what);
    EXPECT_TRUE(problem["type"].get<std::string>().starts_with("/problems/"));
    EXPECT_FALSE(problem["fix"].get<std::string>().empty());
  }
  int jobs() { return static_cast<int>(store_->list(100, "")->jobs.size()); }
};

// With time limits short enough for a test.
class ServerPatience : public ServerLimits {
 protected:
  http::Limits limits() const override {
    http::Limits short_ones;
    short_ones.head_time = short_ones.wait = std::chrono::seconds(1);
    return short_ones;
  }
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

TEST_F(ServerPatience, ASlowHeadIsEnded) {
  const int socket = connected();
  send_all(socket, "GET /healthz HTTP/1.1\r\n");
  expect_problem(parsed(receive_all(socket)), 408, "the head of the request took too long");
}

TEST_F(ServerPatience, ASlowBodyIsEndedAndLeavesNothing) {
  const int socket = connected();
  send_all(socket, "POST /api/v1/jobs HTTP/1.1\r\nHost: " + host() + "\r\n" + bearer(user_) + form_type +
                       "Content-Length: 1000\r\n\r\n" + part("scan", "a.stl", "half"));
  expect_problem(parsed(receive_all(socket)), 408, "the body of the request came too slowly");
  EXPECT_TRUE(std::filesystem::is_empty(data_ / "incoming"));
}

// The route reads a body that is too long for memory.
TEST_F(ServerPatience, ASlowLargeBodyIsEndedAndLeavesNothing) {
  for (const char* path : {"/api/v1/jobs", "/api/v1/validate", "/api/v1/scans"}) {
    const int socket = connected();
    send_all(socket, std::string("POST ") + path + " HTTP/1.1\r\nHost: " + host() + "\r\n" + bearer(user_) +
                         form_type + "Content-Length: 1000000\r\n\r\n" + part("scan", "a.stl", "half"));
    expect_problem(parsed(receive_all(socket)), 408, "the body of the request came too slowly");
  }
  EXPECT_TRUE(std::filesystem::is_empty(data_ / "incoming"));
}

TEST_F(ServerPatience, ABodyThatTricklesIsEnded) {
  for (const int length : {5000, 1000000}) {
    const int socket = connected();
    send_all(socket, "POST /api/v1/scans HTTP/1.1\r\nHost: " + host() + "\r\n" + bearer(user_) + form_type +
                         "Content-Length: " + std::to_string(length) + "\r\n\r\n");
    std::atomic<bool> over = false;
    std::thread trickle([&] {
      while (!over && send_all(socket, "-")) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    });
    const Answer answer = parsed(receive_one(socket));
    over = true;
    trickle.join();
    ::close(socket);
    expect_problem(answer, 408, "the body of the request came too slowly");
  }
}

// A client that reads its answer byte by byte is disconnected, and others are served meanwhile.
TEST_F(ServerLimits, AClientThatTakesItsAnswerTooSlowlyIsClosed) {
  Blob blob;
  {
    auto upload = store_->upload();
    ASSERT_TRUE(upload->write(std::string(8 << 20, 'x')));
    blob = upload->digest();
    ASSERT_TRUE(store_->add_scan("station-1", std::move(*upload), "stl"));
  }
  http::Router router;
  router.add("GET", "/large", [&](http::Request& request) -> Result<http::Response> {
    VACUFORM_TRY(reader, store_->open(blob));
    return blob_response(request, std::move(reader), "application/octet-stream", blob.sha256);
  });
  http::ServerOptions options;
  options.refuse = refuse;
  options.limits.wait = std::chrono::milliseconds(500);
  const auto server = http::Server::start(std::move(options), std::move(router));
  ASSERT_TRUE(server);
  std::vector<int> slow;
  for (int i = 0; i < 20; ++i) {
    slow.push_back(connected_to(**server));
    send_all(slow.back(), "GET /large HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  const int other = connected_to(**server);
  send_all(other, "GET /large HTTP/1.1\r\nHost: localhost\r\nRange: bytes=0-4\r\n\r\n");
  EXPECT_EQ(parsed(receive_one(other)).body, "xxxxx");
  ::close(other);
  EXPECT_TRUE(eventually([&] { return (*server)->connections() == 0; }));
  for (const int socket : slow) EXPECT_LT(receive_all(socket).size(), 8u << 20);
}

TEST_F(ServerLimits, TheSlowestMakeRoomForNewClients) {
  http::Router router;
  router.add("GET", "/", [](http::Request&) -> Result<http::Response> {
    return http::text_response("text/plain", "here");
  });
  http::ServerOptions options;
  options.refuse = refuse;
  options.connections = 20;
  const auto server = http::Server::start(std::move(options), std::move(router));
  ASSERT_TRUE(server);
  std::vector<int> stalled;
  for (int i = 0; i < 60; ++i) {
    stalled.push_back(connected_to(**server));
    send_all(stalled.back(), "GET / HT");
  }
  for (int i = 0; i < 30; ++i) {
    const int socket = connected_to(**server);
    send_all(socket, "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(parsed(receive_one(socket)).body, "here");
    ::close(socket);
    EXPECT_LE((*server)->connections(), 20);
  }
  for (const int socket : stalled) ::close(socket);
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
                 413, "the body is larger than 1413 MiB");
}

// A request is refused by its Content-Length alone, on every route and for every client.
TEST_F(ServerLimits, EveryRouteBoundsItsBodyBeforeItsBytes) {
  const std::string lease = "/api/v1/leases/" + std::string(26, '0');
  for (const auto& [line, most] : {std::pair<std::string, std::string>{"POST /sign-in", "4096 bytes"},
                                   {"POST /sign-out", "4096 bytes"},
                                   {"GET /healthz", "73728 bytes"},
                                   {"POST /api/v1/scans", "1025 MiB"},
                                   {"POST /api/v1/validate", "1413 MiB"},
                                   {"POST /api/v1/tokens", "73728 bytes"},
                                   {"PUT /api/v1/profiles/a", "73728 bytes"},
                                   {"POST /api/v1/leases", "73728 bytes"},
                                   {"PUT " + lease + "/artifacts/print.png", "2048 MiB"},
                                   {"POST /api/v1/uploads", "1024 MiB"},
                                   {"PATCH /api/v1/uploads/none", "1024 MiB"}})
    expect_problem(raw(line + " HTTP/1.1\r\nHost: " + host() + "\r\nContent-Length: 3000000000\r\n\r\n"), 413,
                   "the body is larger than " + most);
}

TEST_F(ServerLimits, TheTokenIsCheckedBeforeTheBody) {
  for (const char* length : {"100", "5000", "1000000000"})
    for (const char* line : {"POST /api/v1/jobs", "POST /api/v1/scans", "POST /api/v1/validate"})
      EXPECT_EQ(raw(std::string(line) + " HTTP/1.1\r\nHost: " + host() + "\r\n" + form_type +
                    "Content-Length: " + length + "\r\n\r\n")
                    .status,
                401)
          << line << " " << length;
}

TEST_F(ServerLimits, AHeaderWithOneValueMayNotBeRepeated) {
  expect_problem(ask("GET", "/healthz", bearer(user_) + bearer(admin_)), 400,
                 "there is more than one Authorization");
  for (const char* name : {"Range", "Content-Type", "Cookie", "If-Range", "Idempotency-Key", "Origin"})
    expect_problem(ask("GET", "/healthz", std::string(name) + ": a\r\n" + name + ": a\r\n"), 400,
                   std::string("there is more than one ") + name);
  EXPECT_EQ(ask("GET", "/healthz", "Accept: a/b\r\nAccept: text/html\r\n").status, 200);
}

TEST_F(ServerLimits, TheAddressMayBeInAbsoluteForm) {
  const std::string rest = " HTTP/1.1\r\nHost: " + host() + "\r\n\r\n";
  EXPECT_EQ(raw("GET http://" + host() + "/healthz" + rest).body, "{\"status\":\"ok\"}\n");
  EXPECT_EQ(raw("GET HTTP://" + host() + "/problems/?a=b" + rest).status, 400);  // its query is read
  EXPECT_EQ(raw("GET HTTP://" + host() + "/problems/" + rest).status, 200);
  EXPECT_EQ(raw("GET http://" + host() + rest).status, 401);  // the start page
  expect_problem(raw("GET http://example.org/healthz" + rest), 400,
                 "the address and Host name two different hosts");
}

TEST_F(ServerLimits, SettingsAreBounded) {
  expect_problem(submit(part("settings", "", std::string(70'000, ' '))), 413,
                 "the settings are longer than 64 KiB");
  expect_problem(submit(part("print.dpi", "", "300") + part("print.dpi", "", "300")), 400,
                 "an unknown or repeated part of the form: print.dpi");
  expect_problem(submit(part("virus", "x.exe", "MZ")), 400, "an unknown or repeated part of the form: virus");
  expect_problem(submit(part("scan", "again.stl", "x")), 400, "there is more than one scan");
  EXPECT_EQ(jobs(), 0);
}

// The bytes after a refused or unread body must never be parsed as a request.
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
    ::shutdown(socket, SHUT_WR);
    const std::string all = receive_all(socket);
    EXPECT_EQ(all.find("HTTP/1.1", 8), std::string::npos) << all;  // one answer
  }
  EXPECT_EQ(jobs(), 0);
}

TEST_F(ServerLimits, AConnectionServesOneRequest) {
  const std::string host_line = "Host: " + host() + "\r\n";
  for (const std::string& text :
       {"GET /healthz HTTP/1.1\r\n" + host_line + "Connection: keep-alive\r\n\r\n",
        "GET /healthz HTTP/1.0\r\n" + host_line + "\r\n", "GET /healthz HTTP/1.1\r\n" + host_line + "\r\nG",
        "POST /nowhere HTTP/1.1\r\n" + host_line + "Content-Length: 4\r\n\r\nGET ",
        "GET /healthz HTTP/1.1\r\n" + host_line + "Spaced : x\r\n\r\n",
        "POST /api/v1/jobs HTTP/1.1\r\n" + host_line + "Transfer-Encoding: chunked\r\n\r\n",
        "POST /api/v1/jobs HTTP/1.1\r\n" + host_line + "Content-Length: 100000000\r\n\r\n"}) {
    const int socket = connected();
    send_all(socket, text);
    const Answer answer = parsed(receive_all(socket));  // all bytes, until the connection is closed
    EXPECT_NE(answer.status, 0) << text;
    EXPECT_EQ(answer.header("Connection"), "close") << text;
  }
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
    EXPECT_EQ(ask("GET", base + name).status, std::string(name).find("%2f") == std::string::npos &&
                                                      std::string(name).find("%00") == std::string::npos
                                                  ? 404
                                                  : 400)
        << name;
  for (const char* name : {"..%2f..%2fevil", "evil.sh", "print.png%00.sh", "%2ftmp%2fevil"}) {
    const int status = ask("PUT", "/api/v1/leases/" + job["id"].get<std::string>() + "/artifacts/" + name,
                           worker_headers(std::string(64, 'b')), "x")
                           .status;
    EXPECT_TRUE(status == 400 || status == 404) << name << " " << status;
  }
}

TEST_F(ServerLimits, AFaultKeepsItsTextToItself) {
  const Answer answer = ask("GET", "/fault");
  expect_problem(answer, 500, "the server has an internal fault");
  EXPECT_EQ((answer.head + answer.body).find("secret"), std::string::npos);
}

TEST_F(ServerLimits, MethodsThatAPathDoesNotKnow) {
  const Answer answer = ask("DELETE", "/api/v1/jobs");
  expect_problem(answer, 405, "this address does not answer to that method");
  EXPECT_EQ(answer.header("Allow"), "POST, GET, HEAD");
}

// More large bodies of one owner than its share: the first ones are accepted, the others are refused. Other owners have
// theirs, and other requests still work.
TEST_F(ServerLimits, StalledUploadsHoldOnlyTheShareOfTheirOwner) {
  http::ServerOptions options;
  options.refuse = refuse;
  options.bodies = 6;
  options.bodies_of_one = 4;
  const auto server = http::Server::start(std::move(options), all_routes(*service_));
  ASSERT_TRUE(server);
  const auto upload = [&](const std::string& owner) {
    return "POST /api/v1/scans HTTP/1.1\r\nHost: localhost\r\n" + bearer(owner) + form_type +
           "Content-Length: 1000000\r\n";
  };
  const auto answer = [&](const std::string& text) {
    const int socket = connected_to(**server);
    send_all(socket, text);
    const Answer got = parsed(receive_one(socket));
    ::close(socket);
    return got;
  };
  std::vector<int> stalled;
  const auto stall = [&](const std::string& owner) {
    stalled.push_back(connected_to(**server));
    send_all(stalled.back(), upload(owner) + "Expect: 100-continue\r\n\r\n");
    char interim[100];
    EXPECT_GT(::recv(stalled.back(), interim, sizeof interim, 0), 0);  // it has its share of the limit
  };
  for (int i = 0; i < 4; ++i) stall(user_);
  const Answer refused = answer(upload(user_) + "\r\n");
  expect_problem(refused, 429, "too many large bodies of yours at this moment");
  EXPECT_FALSE(refused.header("Retry-After").empty());
  const std::string body = part("scan", "a.stl", std::string(1000000, '-')).substr(0, 1000000);
  const std::string second = token("station-2", {Scope::submit, Scope::read});
  EXPECT_EQ(answer(upload(second) + "\r\n" + body).status,
            400);  // read to its end, where the form is cut off
  for (const char* path : {"/healthz", "/api/v1/jobs"})
    EXPECT_EQ(answer(std::string("GET ") + path + " HTTP/1.1\r\nHost: localhost\r\n" + bearer(user_) + "\r\n")
                  .status,
              200);
  for (int i = 0; i < 2; ++i) stall(second);
  const Answer none_left = answer(upload(second) + "\r\n");
  expect_problem(none_left, 503, "too many large bodies at this moment");
  EXPECT_EQ(none_left.header("Retry-After"), "5");
  for (const int socket : stalled) ::close(socket);
}

// Requests of one owner that take long leave half of the turns to the others, and their slots, too.
TEST_F(ServerLimits, AGreedyOwnerLeavesTurnsToTheOthers) {
  std::atomic<bool> over = false;
  http::Router router;
  router.add({"GET", "/{owner}", [&over](const http::Request& asked) -> Result<http::Admitted> {
                return http::Admitted{asked.path, [&over](http::Request& request) -> Result<http::Response> {
                                        while (request.at("owner") == "greedy" && !over)
                                          std::this_thread::sleep_for(std::chrono::milliseconds(1));
                                        return http::text_response("text/plain", request.at("owner"));
                                      }};
              }});
  http::ServerOptions options;
  options.refuse = refuse;
  options.requests_of_one = 30;
  options.limits.wait = std::chrono::minutes(2);  // none gives up while the machine does other work
  const auto server = http::Server::start(std::move(options), std::move(router));
  ASSERT_TRUE(server);
  std::vector<pollfd> greedy;
  const auto get = [&](const std::string& path) {
    const int socket = connected_to(**server);
    send_all(socket, "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    return socket;
  };
  for (int i = 0; i < 31; ++i) greedy.push_back({get("/greedy"), POLLIN, 0});
  ASSERT_EQ(::poll(greedy.data(), greedy.size(), 30000), 1);  // one too many: it is refused at once
  const int other = get("/other");
  EXPECT_EQ(parsed(receive_all(other)).body, "other");
  ::close(other);
  over = true;
  int refused = 0;
  for (const pollfd& asked : greedy) {
    const Answer answer = parsed(receive_all(asked.fd));
    ::close(asked.fd);
    if (answer.status == 429)
      ++refused;
    else
      EXPECT_EQ(answer.body, "greedy");
  }
  EXPECT_EQ(refused, 1);
}

// Of two owners that wait, each is next in its turn, however many requests one has.
TEST(FairQueue, OwnersTakeTurns) {
  using namespace std::chrono_literals;
  http::FairQueue queue(1);
  std::mutex mutex;
  std::string order;
  std::vector<std::thread> waiting;
  http::Slot first = queue.take("a", 1s);
  ASSERT_TRUE(first);
  EXPECT_FALSE(queue.take("b", 1ms));  // none is left
  for (const char* owner : {"a", "a", "a", "b", "b"}) {
    waiting.emplace_back([&, owner] {
      const http::Slot turn = queue.take(owner, 10s);
      const std::lock_guard hold(mutex);
      order += turn ? owner : "-";
    });
    std::this_thread::sleep_for(50ms);  // they queue up in this order
  }
  first.reset();
  for (std::thread& thread : waiting) thread.join();
  EXPECT_EQ(order, "ababa");
}

TEST_F(ServerLimits, StalledConnectionsDoNotBlockOthers) {
  std::vector<int> stalled;
  for (int i = 0; i < 200; ++i) stalled.push_back(connected());
  for (int i = 0; i < 128; ++i) send_all(stalled[static_cast<std::size_t>(i)], "GET / HTTP/1.1\r\n");
  const auto started = std::chrono::steady_clock::now();
  EXPECT_EQ(ask("GET", "/healthz").status, 200);
  EXPECT_LT(std::chrono::steady_clock::now() - started, http::Limits{}.head_time - std::chrono::seconds(2));
  for (const int socket : stalled) ::close(socket);
}

}  // namespace
}  // namespace vacuform
