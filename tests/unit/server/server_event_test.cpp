// A job as it changes: entity tags, waiting, server-sent events that go on where they broke off.
#include <nlohmann/json.hpp>
#include <thread>

#include "server_fixture.hpp"
#include "tests/unit/server/eventually.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

class ServerEvent : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    id_ = json::parse(submit().body)["id"];
    path_ = "/api/v1/jobs/" + id_;
  }
  json lease() {
    return json::parse(ask("POST", "/api/v1/leases", worker_headers(), R"({"protocol":2})").body);
  }
  Answer worker(const json& lease, const std::string& tail, const std::string& body = "{}") {
    return ask("POST", "/api/v1/leases/" + id_ + tail, worker_headers(lease["lease"].get<std::string>()),
               body);
  }
  struct Event {
    std::string name, id;
    json data;
  };
  static std::vector<Event> events(const std::string& body) {
    std::vector<Event> all;
    for (std::size_t at = 0, end; (end = body.find("\n\n", at)) != std::string::npos; at = end + 2) {
      const std::string text = body.substr(at, end - at);
      const auto field = [&](const std::string& name) {
        const auto begin = ("\n" + text).find("\n" + name + ": ");
        const auto from = begin + name.size() + 2;
        return begin == std::string::npos ? "" : text.substr(from, text.find('\n', from) - from);
      };
      if (text.starts_with(":")) continue;
      all.push_back({field("event"), field("id"), json::parse(field("data"))});
    }
    return all;
  }
  int following(const std::string& last = "") {
    const int socket = connected();
    send_all(socket, "GET " + path_ + "/events HTTP/1.1\r\nHost: " + host() + "\r\nConnection: close\r\n" +
                         bearer(user_) + (last.empty() ? "" : "Last-Event-ID: " + last + "\r\n") + "\r\n");
    return socket;
  }

  std::string id_, path_;
};

TEST_F(ServerEvent, AnEntityTagNamesTheStateOfAJob) {
  const Answer first = ask("GET", path_);
  const std::string tag = first.header("ETag"), known = "If-None-Match: " + tag + "\r\n";
  EXPECT_FALSE(tag.empty());
  EXPECT_EQ(ask("GET", path_, known).status, 304);
  EXPECT_EQ(ask("GET", path_, known).header("ETag"), tag);
  EXPECT_EQ(ask("GET", path_ + "?wait=1", known).status, 304);  // nothing happens
  lease();
  EXPECT_EQ(ask("GET", path_ + "?wait=60", known).status, 200);  // it has happened already
  EXPECT_NE(ask("GET", path_).header("ETag"), tag);
  EXPECT_EQ(ask("GET", path_ + "?wait=61", known).status, 400);
}

TEST_F(ServerEvent, TellsTheFrontOfTheQueueAndTheUsualTime) {
  const auto shown = [&] { return json::parse(ask("GET", path_).body); };
  json job = shown();
  EXPECT_EQ(job["queue_position"], 1);
  EXPECT_EQ(job["seconds_expected"], nullptr);
  EXPECT_NE(ask("GET", "/jobs/" + id_).body.find("Number 1 in the queue."), std::string::npos);
  // A job that goes first moves it, without a change of its own.
  const std::string tag = ask("GET", path_).header("ETag");
  const json raised = json::parse(
      ask("POST", "/api/v1/jobs", bearer(admin_), json{{"from", id_}, {"priority", 5}}.dump()).body);
  EXPECT_EQ(shown()["queue_position"], 2);
  EXPECT_EQ(ask("GET", path_).header("ETag"), tag);
  const json held = lease();
  ASSERT_EQ(held["job"], raised["id"]);
  finish({held["job"], held["lease"]});
  job = shown();
  EXPECT_EQ(job["queue_position"], 1);
  EXPECT_TRUE(job["seconds_expected"].is_number());
  EXPECT_NE(ask("GET", "/jobs/" + id_).body.find("Such a job usually takes"), std::string::npos);
  lease();
  EXPECT_EQ(shown()["queue_position"], nullptr);
  EXPECT_FALSE(json::parse(ask("GET", "/api/v1/jobs").body)["jobs"][0].contains("queue_position"));
}

TEST_F(ServerEvent, AnEntityTagThatMustMatchIsLookedAt) {
  const std::string tag = ask("GET", path_).header("ETag");
  for (const std::string& good : {tag, std::string("*"), "\"0\", " + tag})
    EXPECT_EQ(ask("GET", path_, "If-Match: " + good + "\r\n").status, 200) << good;
  for (const std::string& bad : {std::string("\"0\""), "W/" + tag})
    for (const auto& [method, path] :
         {std::pair{"GET", path_}, {"POST", path_ + "/cancel"}, {"DELETE", path_}})
      EXPECT_EQ(ask(method, path, "If-Match: " + bad + "\r\n").status, 412) << method << bad;
  EXPECT_EQ(ask("POST", path_ + "/cancel", "If-Match: " + tag + "\r\n").status, 200);
}

// The store may be older than what a client has heard: a copy that was put in its place.
TEST_F(ServerEvent, IgnoresEventsOfALaterStore) {
  ask("POST", path_ + "/cancel");
  for (const char* last : {"999.0", "9223372036854775807.9223372036854775807"}) {
    const Answer answer = parsed(receive_all(following(last)));
    EXPECT_EQ(answer.status, 200) << last;
    EXPECT_EQ(events(answer.body).back().data["state"], "cancelled");
  }
}

// The bounds are those of a service as it is: so many of one owner, and places for the others.
TEST_F(ServerEvent, WhoFollowsAndWaitsLeavesPlacesForTheOthers) {
  const http::ServerOptions usual;
  const std::string known = "If-None-Match: " + ask("GET", path_).header("ETag") + "\r\n";
  std::vector<int> sockets;
  for (int i = 0; i < usual.streams_of_one / 2; ++i) sockets.push_back(following());
  while (sockets.size() < static_cast<std::size_t>(usual.streams_of_one)) {
    sockets.push_back(connected());
    send_all(sockets.back(), "GET " + path_ + "?wait=60 HTTP/1.1\r\nHost: " + host() + "\r\n" +
                                 bearer(user_) + known + "\r\n");
  }
  ASSERT_TRUE(eventually([&] { return server_->streams() == usual.streams_of_one; })) << server_->streams();
  for (const char* tail : {"/events", "?wait=60"}) {
    const Answer refused = ask("GET", path_ + tail, known);
    EXPECT_EQ(refused.status, 429) << tail;
    EXPECT_EQ(json::parse(refused.body)["type"], "/problems/busy");
    EXPECT_EQ(refused.header("Retry-After"), "60");
  }
  EXPECT_EQ(ask("GET", path_).status, 200);  // to ask without waiting takes no place
  const int other = connected();
  send_all(other, "GET " + path_ + "/events HTTP/1.1\r\nHost: " + host() + "\r\n" + bearer(admin_) + "\r\n");
  EXPECT_TRUE(eventually([&] { return server_->streams() == usual.streams_of_one + 1; }));
  sockets.push_back(other);
  for (const int socket : sockets) ::close(socket);
  EXPECT_TRUE(eventually([&] { return server_->streams() == 0; }));
}

TEST_F(ServerEvent, AWaitEndsWithTheChange) {
  const std::string tag = ask("GET", path_).header("ETag");
  Answer answer;
  std::thread waiting([&] { answer = ask("GET", path_ + "?wait=60", "If-None-Match: " + tag + "\r\n"); });
  EXPECT_TRUE(eventually([&] { return server_->streams() == 1; }));
  ask("POST", path_ + "/cancel");
  waiting.join();
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(json::parse(answer.body)["state"], "cancelled");
  // Of a job that has ended nobody waits for more.
  const std::string last = "If-None-Match: " + answer.header("ETag") + "\r\n";
  EXPECT_EQ(ask("GET", path_ + "?wait=60", last).status, 304);
}

TEST_F(ServerEvent, AStreamTellsEverythingOnceAndEndsWithTheJob) {
  const int socket = following();
  const json held = lease();
  worker(held, "/heartbeat", R"({"stage":"forming","progress":0.5})");
  put_artifacts({held["job"], held["lease"]});
  worker(held, "/complete");
  const Answer answer = parsed(receive_all(socket));
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.header("Content-Type"), "text/event-stream");
  const auto all = events(answer.body);
  ASSERT_FALSE(all.empty());
  EXPECT_EQ(all.back().name, "job");
  EXPECT_EQ(all.back().data["state"], "succeeded");
  std::int64_t line = 0;
  std::size_t lines = 0;
  for (const Event& event : all)
    if (event.name == "log") {
      EXPECT_EQ(event.data["number"].get<std::int64_t>(), ++line);
      ++lines;
    }
  const json log = json::parse(ask("GET", path_ + "/log").body);
  EXPECT_EQ(lines, log["lines"].size());
  EXPECT_GT(lines, 0u);

  // From every place that a client may have reached, the rest and nothing else.
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    const auto rest = events(parsed(receive_all(following(all[i].id))).body);
    std::size_t heard = 0;
    for (std::size_t k = i + 1; k < all.size(); ++k) heard += all[k].name == "log";
    std::size_t told = 0;
    for (const Event& event : rest) told += event.name == "log";
    EXPECT_EQ(told, heard) << i;
    ASSERT_FALSE(rest.empty());
    EXPECT_EQ(rest.back().id, all.back().id);
  }
  EXPECT_EQ(parsed(receive_all(following(all.back().id))).status, 204);
  EXPECT_EQ(events(parsed(receive_all(following("nonsense"))).body).size(), lines + 1);
}

TEST_F(ServerEvent, AStreamEndsWhenTheJobIsDeleted) {
  ask("POST", path_ + "/cancel");
  const Answer gone = ask("DELETE", path_);
  EXPECT_EQ(gone.status, 204);
  EXPECT_EQ(ask("GET", path_ + "/events").status, 404);
}

TEST_F(ServerEvent, AStreamEndsSoonAfterItsTokenWasRevoked) {
  const int socket = following();
  char heard[4096];
  ASSERT_TRUE(eventually([&] {
    const ssize_t n = ::recv(socket, heard, sizeof heard, MSG_PEEK | MSG_DONTWAIT);
    return n > 0 &&
           std::string_view(heard, static_cast<std::size_t>(n)).find("event: job") != std::string_view::npos;
  }));
  ASSERT_TRUE(store_->revoke_token(user_.substr(4, 16)));
  const auto began = std::chrono::steady_clock::now();
  const auto answer = receive_all(socket);
  EXPECT_NE(answer.find("event: job"), std::string::npos);
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(8));
  EXPECT_EQ(ask("GET", path_).status, 401);
}

TEST_F(ServerEvent, StreamsAreTheOwnersAlone) {
  const std::string other = bearer(token("station-2", {Scope::read}));
  EXPECT_EQ(ask("GET", path_ + "/events", other).status, 404);
  EXPECT_EQ(ask("GET", path_ + "?wait=1", other).status, 404);
}

}  // namespace
}  // namespace vacuform
