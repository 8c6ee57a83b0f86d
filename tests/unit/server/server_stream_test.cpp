// Responses that stream or wait: how they end, and that they do not block other requests.
#include <atomic>
#include <semaphore>
#include <thread>

#include "server_fixture.hpp"

namespace vacuform {
namespace {

using http::Request;
using http::Response;
using namespace std::chrono_literals;

Response streamed(http::Producer producer) {
  Response response;
  response.media_type = "text/event-stream";
  response.stream = std::move(producer);
  return response;
}

class ServerStream : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    http::Router router;
    const auto add = [&](const char* client, const char* pattern, http::Handler handler) {
      router.add({"GET", pattern, [client, handler](const Request&) -> Result<http::Admitted> {
                    return http::Admitted{client, handler};
                  }});
    };
    add("a third one", "/three", [](Request&) -> Result<Response> {
      return streamed([n = 0]() mutable -> std::optional<std::string> {
        if (n++ == 6) return std::nullopt;
        return n % 2 ? "piece " : "";  // no data in the meantime
      });
    });
    add("someone", "/endless", [](Request&) -> Result<Response> {
      return streamed([]() -> std::optional<std::string> {
        std::this_thread::sleep_for(1ms);
        return "again ";
      });
    });
    add("someone", "/silent", [](Request&) -> Result<Response> {
      return streamed([]() -> std::optional<std::string> {
        std::this_thread::sleep_for(1ms);
        return "";
      });
    });
    for (const char* client : {"/station-1", "/station-2", "/station-3"})
      add(client, client, [](Request&) -> Result<Response> {
        return streamed([]() -> std::optional<std::string> {
          std::this_thread::sleep_for(1ms);
          return "";
        });
      });
    add("someone", "/broken", [](Request&) -> Result<Response> {
      return streamed([]() -> std::optional<std::string> { throw std::runtime_error("secret text"); });
    });
    add("another", "/late", [this](Request&) -> Result<Response> {
      Response response;
      response.waiter = [this](const http::Going& going) -> Result<Response> {
        while (going() && !known_.try_acquire_for(1ms)) continue;
        return http::text_response("text/plain", "it is known");
      };
      return response;
    });
    add("someone", "/never", [](Request&) -> Result<Response> {
      Response response;
      response.waiter = [](const http::Going&) -> Result<Response> {
        return fail(Code::gone, "it has expired", "there", "look elsewhere");
      };
      return response;
    });
    router.add("GET", "/quick",
               [](Request&) -> Result<Response> { return http::text_response("text/plain", "quick"); });
    http::ServerOptions options;
    options.refuse = refuse;
    options.streams = 3;
    options.streams_of_one = 2;
    auto server = http::Server::start(std::move(options), std::move(router));
    ASSERT_TRUE(server) << server.error().text();
    streams_ = std::move(*server);
  }
  void TearDown() override {
    streams_.reset();
    ServerTest::TearDown();
  }

  int sent(const std::string& path, const std::string& method = "GET") {
    const int socket = connected_to(*streams_);
    send_all(socket, method + " " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    return socket;
  }
  Answer get(const std::string& path, const std::string& method = "GET") {
    return parsed(receive_all(sent(path, method)));
  }
  void await_streams(int number) const {
    ASSERT_TRUE(eventually([&] { return streams_->streams() == number; })) << streams_->streams();
  }

  std::unique_ptr<http::Server> streams_;
  std::counting_semaphore<> known_{0};
};

TEST_F(ServerStream, EndsWithItsProducer) {
  const Answer answer = get("/three");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.header("Content-Type"), "text/event-stream");
  EXPECT_EQ(answer.header("Content-Length"), "");
  EXPECT_EQ(answer.header("Connection"), "close");
  EXPECT_EQ(answer.body, "piece piece piece ");
  await_streams(0);
}

TEST_F(ServerStream, EndsWhenTheClientLeaves) {
  for (const char* path : {"/endless", "/silent", "/late"}) {
    const int socket = sent(path);
    await_streams(1);
    ::close(socket);
    await_streams(0);
  }
}

TEST_F(ServerStream, EndsWhenTheServerStops) {
  const std::array<int, 3> sockets{sent("/endless"), sent("/silent"), sent("/late")};
  await_streams(3);
  std::thread reader([&] { EXPECT_TRUE(receive_all(sockets[0]).starts_with("HTTP/1.1 200 OK\r\n")); });
  streams_.reset();
  reader.join();
  EXPECT_EQ(parsed(receive_all(sockets[1])).body, "");
  EXPECT_EQ(parsed(receive_all(sockets[2])).status, 200);
}

TEST_F(ServerStream, NobodyTakesThePlacesOfTheOthers) {
  const std::array<int, 2> sockets{sent("/station-1"), sent("/station-1")};
  await_streams(2);
  const Answer refused = get("/station-1");
  EXPECT_EQ(refused.status, 429);
  EXPECT_FALSE(refused.header("Retry-After").empty());
  EXPECT_NE(refused.body.find("of yours"), std::string::npos);
  const int other = sent("/station-2");
  await_streams(3);
  EXPECT_EQ(get("/station-3").status, 503);
  ::close(sockets[0]);
  await_streams(2);
  const int again = sent("/station-1");
  await_streams(3);
  for (const int socket : {sockets[1], other, again}) ::close(socket);
  await_streams(0);
}

TEST_F(ServerStream, MoreThanThereArePlacesAreRefusedAndOthersGoOn) {
  const std::array<int, 3> sockets{sent("/silent"), sent("/silent"), sent("/late")};
  await_streams(3);
  for (const char* path : {"/silent", "/late"}) {
    const Answer refused = get(path);
    EXPECT_EQ(refused.status, 503);
    EXPECT_EQ(refused.header("Retry-After"), "5");
    EXPECT_NE(refused.body.find("/problems/busy"), std::string::npos);
  }
  EXPECT_EQ(get("/quick").body, "quick");
  const Answer head = get("/silent", "HEAD");
  EXPECT_EQ(head.status, 200);  // a HEAD request occupies no slot
  EXPECT_EQ(head.header("Content-Length"), "");
  known_.release();
  EXPECT_EQ(parsed(receive_all(sockets[2])).body, "it is known");
  await_streams(2);
  EXPECT_EQ(get("/three").status, 200);
  ::close(sockets[0]);
  ::close(sockets[1]);
}

TEST_F(ServerStream, AWaiterMayRefuse) {
  const Answer answer = get("/never");
  EXPECT_EQ(answer.status, 410);
  EXPECT_NE(answer.body.find("it has expired"), std::string::npos);
}

TEST_F(ServerStream, AFaultInAProducerEndsItsConnectionAlone) {
  EXPECT_EQ(get("/broken").body, "");
  await_streams(0);
  EXPECT_EQ(get("/quick").status, 200);
}

}  // namespace
}  // namespace vacuform
