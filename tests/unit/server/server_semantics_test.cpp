// What HTTP (RFC 9110) asks of answers, whatever they are about: methods, preconditions, ranges, heads, media types.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <thread>

#include "server_fixture.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

using ServerSemantics = ServerTest;

TEST_F(ServerSemantics, UnknownMethodsAreNotImplementedAndOthersNotAllowed) {
  for (const char* method : {"FOO", "get", "PROPFIND"}) {
    const Answer answer = ask(method, "/api/v1/jobs");
    EXPECT_EQ(answer.status, 501) << method;
    EXPECT_NE(answer.body.find("no such method"), std::string::npos);
  }
  for (const char* method : {"PUT", "PATCH", "DELETE", "OPTIONS", "TRACE"}) {
    const Answer answer = ask(method, "/api/v1/jobs");
    EXPECT_EQ(answer.status, 405) << method;
    EXPECT_EQ(answer.header("Allow"), "POST, GET, HEAD");
  }
  EXPECT_EQ(raw("G@T / HTTP/1.1\r\nHost: localhost\r\n\r\n").status, 400);
}

TEST_F(ServerSemantics, AHeadSaysWhatTheAnswerWouldHaveSaid) {
  const std::string id = json::parse(submit().body)["id"];
  for (const std::string& path :
       {std::string("/api/v1/jobs"), "/api/v1/jobs/" + id, "/api/v1/jobs/" + id + "/log",
        std::string("/api/v1/limits"), std::string("/api/v1/openapi.yaml"), std::string("/style.css")}) {
    const Answer whole = ask("GET", path), head = ask("HEAD", path);
    EXPECT_EQ(head.status, 200) << path;
    EXPECT_EQ(head.body, "");
    for (const char* name : {"Content-Length", "Content-Type", "ETag", "Accept-Ranges", "Cache-Control"})
      EXPECT_EQ(head.header(name), whole.header(name)) << path << " " << name;
    EXPECT_EQ(ask("HEAD", path, "", "{}").body, "") << path;  // a body of its own changes nothing
  }
}

TEST_F(ServerSemantics, AnswersWithoutABodySayNothingOfItsLength) {
  const std::string path = "/api/v1/jobs/" + json::parse(submit().body)["id"].get<std::string>();
  const Answer same = ask("GET", path, "If-None-Match: *\r\n");
  EXPECT_EQ(same.status, 304);
  EXPECT_EQ(same.header("Content-Length"), "");
  ask("POST", path + "/cancel");
  const Answer deleted = ask("DELETE", path);
  EXPECT_EQ(deleted.status, 204);
  EXPECT_EQ(deleted.header("Content-Length"), "");
}

TEST_F(ServerSemantics, LetOneOfTwoPutsWithOneTagWin) {
  const std::string at = "/api/v1/profiles/shared", as_admin = bearer(admin_);
  for (int round = 0; round < 10; ++round) {
    const std::string width = std::to_string(400 + 10 * round);
    ASSERT_EQ(ask("PUT", at, as_admin, R"({"sheet":{"width_mm":)" + width + "}}").status / 100, 2);
    const std::string tag = ask("GET", at).header("ETag");
    std::array<int, 2> statuses{};
    std::vector<std::thread> clients;
    for (std::size_t i = 0; i < 2; ++i)
      clients.emplace_back([&, i] {
        statuses[i] =
            ask("PUT", at, as_admin + "If-Match: " + tag + "\r\n",
                R"({"sheet":{"width_mm":)" + std::to_string(401 + 10 * round + static_cast<int>(i)) + "}}")
                .status;
      });
    for (auto& client : clients) client.join();
    std::sort(statuses.begin(), statuses.end());
    EXPECT_EQ(statuses, (std::array<int, 2>{200, 412}));
  }
}

TEST_F(ServerSemantics, ARangeThatIsNotThereAndATagThatDoesNotMatchAreProblems) {
  const std::string id = json::parse(submit().body)["id"],
                    path = "/api/v1/jobs/" + id + "/artifacts/print.png";
  const json held = json::parse(ask("POST", "/api/v1/leases", worker_headers(), R"({"protocol":2})").body);
  ask("PUT", "/api/v1/leases/" + id + "/artifacts/print.png",
      worker_headers(held["lease"].get<std::string>()) + "Content-Type: application/octet-stream\r\n", "ink");
  finish({id, held["lease"]}, {"print.png"});
  const std::string tag = ask("GET", path).header("ETag");
  const Answer beyond = ask("GET", path, "Range: bytes=3-\r\n");
  EXPECT_EQ(beyond.status, 416);
  EXPECT_EQ(beyond.header("Content-Range"), "bytes */3");
  EXPECT_EQ(beyond.header("Content-Type"), "application/problem+json");
  EXPECT_EQ(json::parse(beyond.body)["where"], "Range");
  const Answer other = ask("GET", path, "If-Match: \"other\"\r\n");
  EXPECT_EQ(other.status, 412);
  EXPECT_EQ(json::parse(other.body)["where"], "If-Match");
  EXPECT_EQ(ask("GET", path, "If-Match: " + tag + "\r\n").body, "ink");
  const Answer head = ask("HEAD", path, "Range: bytes=0-1\r\n");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.header("Content-Length"), "3");
}

// Two administrators who change one profile: the second learns of the first.
TEST_F(ServerSemantics, AProfileIsReplacedOnlyWhereItIsWhatIsExpected) {
  const std::string path = "/api/v1/profiles/house", as_admin = bearer(admin_);
  EXPECT_EQ(ask("PUT", path, as_admin + "If-Match: *\r\n", "{}").status, 412);
  const Answer made = ask("PUT", path, as_admin + "If-None-Match: *\r\n", "{}");
  EXPECT_EQ(made.status, 201);
  EXPECT_EQ(ask("PUT", path, as_admin + "If-None-Match: *\r\n", "{}").status, 412);
  const std::string tag = "If-Match: " + made.header("ETag") + "\r\n";
  EXPECT_EQ(ask("GET", path, "If-None-Match: " + made.header("ETag") + "\r\n").status, 304);
  EXPECT_EQ(ask("PUT", path, as_admin + tag, R"({"print":{"dpi":600}})").status, 200);
  EXPECT_EQ(ask("PUT", path, as_admin + tag, R"({"print":{"dpi":100}})").status, 412);
  EXPECT_EQ(ask("DELETE", path, as_admin + tag).status, 412);
  EXPECT_EQ(json::parse(ask("GET", path).body)["settings"]["print"]["dpi"], 600);
  EXPECT_EQ(ask("DELETE", path, as_admin + "If-Match: " + ask("GET", path).header("ETag") + "\r\n").status,
            204);
}

TEST_F(ServerSemantics, JsonIsTakenAsJsonAloneAndNotTooDeep) {
  const std::string token = R"({"owner":"a","scopes":["read"]})";
  const auto post = [&](const std::string& type, const std::string& body) {
    return ask("POST", "/api/v1/tokens",
               bearer(admin_) + (type.empty() ? "" : "Content-Type: " + type + "\r\n"), body)
        .status;
  };
  EXPECT_EQ(post("text/plain", token), 415);
  EXPECT_EQ(post("application/x-www-form-urlencoded", token), 415);
  EXPECT_EQ(post("application/jsonx", token), 415);
  EXPECT_EQ(post("Application/JSON; charset=utf-8", token), 201);
  const std::string deep = "{\"owner\":" + std::string(1000, '[') + std::string(1000, ']') + "}";
  EXPECT_EQ(post("application/json", deep), 400);
  EXPECT_EQ(ask("PUT", "/api/v1/profiles/x", bearer(admin_) + "Content-Type: text/plain\r\n", "{}").status,
            415);
}

TEST_F(ServerSemantics, TheNameOfTheHostHasNoCase) {
  EXPECT_EQ(raw("GET /healthz HTTP/1.1\r\nHost: LocalHost:1\r\n\r\n").status, 200);
}

}  // namespace
}  // namespace vacuform
