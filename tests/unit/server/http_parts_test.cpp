// The pieces of server/http that work on text alone: forms, ranges, hosts, routes.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "api/base/log.hpp"
#include "server/messages/multipart.hpp"
#include "server/messages/origin.hpp"
#include "server/messages/range.hpp"
#include "server/messages/request_id.hpp"
#include "server/messages/router.hpp"

namespace vacuform::http {
namespace {

struct Collected : PartSink {
  std::vector<std::pair<std::string, std::string>> parts;  // name, bytes
  std::vector<std::string> file_names;
  int ended = 0;
  Result<void> begin(const std::string& name, const std::string& file_name) override {
    parts.emplace_back(name, "");
    file_names.push_back(file_name);
    return {};
  }
  Result<void> data(std::string_view bytes) override {
    parts.back().second += bytes;
    return {};
  }
  Result<void> end() override { return ++ended, Result<void>(); }
};

const std::string form =
    "--B\r\nContent-Disposition: form-data; name=\"scan\"; filename=\"a \\\"b\\\".stl\"\r\nContent-Type: "
    "model/stl\r\n\r\n"
    "line\r\n--bogus\r\n--\r\n-B\r\n--B\r\nContent-Disposition: form-data; name=\"empty\"\r\n\r\n\r\n"
    "--B\r\ncontent-disposition: form-data; name=print.dpi\r\n\r\n600\r\n--B--\r\nepilogue";

TEST(Multipart, GivesTheSamePartsHoweverTheBytesArrive) {
  for (std::size_t step = 1; step <= form.size(); ++step) {
    Collected sink;
    MultipartParser parser("B", sink);
    for (std::size_t at = 0; at < form.size(); at += step)
      ASSERT_TRUE(parser.feed(std::string_view(form).substr(at, step))) << step;
    ASSERT_TRUE(parser.finish()) << step;
    ASSERT_EQ(sink.parts.size(), 3u) << step;
    EXPECT_EQ(sink.parts[0], std::make_pair(std::string("scan"), std::string("line\r\n--bogus\r\n--\r\n-B")))
        << step;
    EXPECT_EQ(sink.parts[1], std::make_pair(std::string("empty"), std::string())) << step;
    EXPECT_EQ(sink.parts[2], std::make_pair(std::string("print.dpi"), std::string("600"))) << step;
    EXPECT_EQ(sink.file_names[0], "a \"b\".stl");
    EXPECT_EQ(sink.ended, 3);
  }
}

TEST(Multipart, EveryCutOfAFormIsRefused) {
  for (std::size_t length = 0; length + 12 < form.size(); ++length) {
    Collected sink;
    MultipartParser parser("B", sink);
    const bool fed = parser.feed(std::string_view(form).substr(0, length)).has_value();
    EXPECT_FALSE(fed && parser.finish()) << length;
  }
}

TEST(Multipart, RefusesHostileHeads) {
  const auto refuse = [](const std::string& text) {
    Collected sink;
    MultipartParser parser("B", sink);
    auto fed = parser.feed(text);
    if (fed) fed = parser.finish();
    return fed ? "" : fed.error().what;
  };
  EXPECT_EQ(refuse("--B\r\nContent-Disposition: form-data\r\n\r\nx\r\n--B--"), "a part has no name");
  EXPECT_EQ(refuse("--B\r\nContent-Disposition: form-data; name=a\r\n\r\nx\r\n--Bogus\r\n--B--"),
            "a boundary is followed by neither a line end nor \"--\"");
  EXPECT_EQ(refuse("--B\r\nno colon here\r\n\r\nx\r\n--B--"), "a line in the head of a part has no colon");
  EXPECT_EQ(refuse("--B\r\nX: " + std::string(20000, 'x')), "the head of a part is too long");
  EXPECT_EQ(refuse("--B\r\nContent-Disposition: form-data; name=\"a\r\n\r\nx\r\n--B--"),
            "a part has no name");
  EXPECT_EQ(refuse("--B\r\nContent-Disposition: form-data; name=a\r\nContent-Transfer-Encoding: "
                   "base64\r\n\r\nx\r\n--B--"),
            "a part has a transfer encoding");
  const std::string part = "--B\r\nContent-Disposition: form-data; name=a\r\n\r\nx\r\n";
  const std::string junk(10'000, 'x');
  EXPECT_EQ(refuse(junk + "\r\n" + part + "--B--"),
            "there is too much before the first part or behind the last");
  EXPECT_EQ(refuse(part + "--B--" + junk), "there is too much before the first part or behind the last");
  std::string many;
  for (int i = 0; i < 200; ++i) many += "--B\r\nContent-Disposition: form-data; name=a\r\n\r\nx\r\n";
  EXPECT_EQ(refuse(many + "--B--"), "the form has more than 128 parts");
}

TEST(Multipart, FindsTheBoundaryOfAContentType) {
  EXPECT_EQ(multipart_boundary("multipart/form-data; boundary=abc").value(), "abc");
  EXPECT_EQ(multipart_boundary("Multipart/Form-Data; charset=utf-8; Boundary=\"a b;c\"").value(), "a b;c");
  EXPECT_EQ(multipart_boundary("application/json").error().code, Code::unsupported_format);
  EXPECT_EQ(multipart_boundary("multipart/form-data").error().code, Code::unsupported_format);
  EXPECT_EQ(multipart_boundary("multipart/form-data; boundary=" + std::string(71, 'x')).error().code,
            Code::unsupported_format);
}

TEST(Multipart, KeepsNothingOfAFileNameButASafeExtension) {
  EXPECT_EQ(safe_extension("C:\\scans\\Jane Doe 3.STL"), "stl");
  EXPECT_EQ(safe_extension("../../etc/passwd"), "");
  EXPECT_EQ(safe_extension("head"), "");
  EXPECT_EQ(safe_extension("x.p/y"), "");
  EXPECT_EQ(safe_extension("x.\"><script>"), "");
  EXPECT_EQ(safe_extension("x.123456789"), "");
  EXPECT_EQ(safe_extension(std::string("x.st\0l", 6)), "");
}

TEST(Range, FollowsTheSpecification) {
  const auto answer = [](std::string_view header, std::uint64_t bytes) {
    const RangeAnswer a = byte_range(header, bytes);
    if (a.kind == RangeAnswer::whole) return std::string("whole");
    if (a.kind == RangeAnswer::unsatisfiable) return std::string("unsatisfiable");
    return std::to_string(a.first) + "-" + std::to_string(a.last);
  };
  EXPECT_EQ(answer("", 100), "whole");
  EXPECT_EQ(answer("bytes=0-0", 100), "0-0");
  EXPECT_EQ(answer("bytes=10-", 100), "10-99");
  EXPECT_EQ(answer("bytes=10-1000", 100), "10-99");
  EXPECT_EQ(answer("bytes=-10", 100), "90-99");
  EXPECT_EQ(answer("bytes=-1000", 100), "0-99");
  EXPECT_EQ(answer("bytes=100-", 100), "unsatisfiable");
  EXPECT_EQ(answer("bytes=-0", 100), "unsatisfiable");
  EXPECT_EQ(answer("bytes=0-", 0), "unsatisfiable");
  for (const char* malformed : {"bytes=", "bytes=-", "bytes=5-4", "bytes=a-b", "bytes=1-2x", "items=0-1",
                                "bytes=0-1,3-4", "bytes=99999999999999999999-", "bytes=+1-2"})
    EXPECT_EQ(answer(malformed, 100), "whole") << malformed;
}

TEST(Range, ReadsListsOfEntityTags) {
  EXPECT_TRUE(names_etag("\"a\"", "\"a\""));
  EXPECT_TRUE(names_etag("\"b\", W/\"a\"", "\"a\""));
  EXPECT_TRUE(names_etag("*", "\"a\""));
  EXPECT_FALSE(names_etag("", "\"a\""));
  EXPECT_FALSE(names_etag("\"b\",", "\"a\""));
}

TEST(Origin, OnlyLoopbackNamesAreBelieved) {
  for (const char* host :
       {"127.0.0.1", "127.0.0.1:8080", "127.1.2.3:1", "localhost", "localhost:80", "[::1]", "[::1]:8080"})
    EXPECT_TRUE(is_loopback_host(host)) << host;
  for (const char* host :
       {"", "example.org", "127.0.0.1.example.org", "localhost.example.org", "10.0.0.1", "0.0.0.0", "[::]",
        "[::1", "127.0.0.1:80x", "127.0.0.1:1234567", "2130706433", "127.1"})
    EXPECT_FALSE(is_loopback_host(host)) << host;
}

TEST(Origin, AFormOnAnotherPageIsRefused) {
  Request request;
  request.method = "POST";
  request.headers = {{"Host", "127.0.0.1:8080"}};
  EXPECT_FALSE(check_origin(request));  // a program
  request.headers.push_back({"Origin", "http://127.0.0.1:8080"});
  EXPECT_FALSE(check_origin(request));
  for (const char* origin : {"http://example.org", "null", "http://127.0.0.1:9999", "http://localhost:8080",
                             "https://127.0.0.1:8080"}) {
    request.headers.back().value = origin;
    EXPECT_EQ(check_origin(request).value().status, 403) << origin;
  }
  request.method = "GET";
  EXPECT_FALSE(check_origin(request));
}

TEST(Origin, TheSchemeIsThatOfTheConnection) {
  Request request;
  request.method = "POST";
  request.headers = {{"Host", "front.example.org"}, {"Origin", "https://front.example.org"}};
  EXPECT_FALSE(check_origin(request, "front.example.org"));
  request.headers.back().value = "http://front.example.org";
  EXPECT_EQ(check_origin(request, "front.example.org").value().status, 403);
}

// All that a server can see of a front: the name that it is asked under, and the mark that the front sets.
TEST(Origin, BeyondLoopbackOnlyWhatCarriesTheFrontsNameAndMarkIsServed) {
  Request request;
  request.method = "GET";
  request.beyond_loopback = true;
  const auto refused = [&](std::vector<Header> headers, std::string_view front = "front.example.org") {
    request.headers = std::move(headers);
    const auto refusal = check_origin(request, front);
    return refusal ? refusal->status : 0;
  };
  const Header name{"Host", "front.example.org"}, mark{"X-Forwarded-Proto", "https"};
  EXPECT_EQ(refused({name, mark}), 0);
  EXPECT_EQ(refused({name}), 421);
  EXPECT_EQ(refused({name, {"X-Forwarded-Proto", "http"}}), 421);
  EXPECT_EQ(refused({mark, {"Host", "localhost"}}), 421);
  EXPECT_EQ(refused({mark, {"Host", "192.0.2.1:8080"}}), 421);
  EXPECT_EQ(refused({name, mark}, ""), 421);
  request.beyond_loopback = false;
  EXPECT_EQ(refused({{"Host", "localhost"}}), 0);
  EXPECT_EQ(refused({name}), 0);
}

TEST(Origin, ASocketIsOnLoopbackByItsOwnAddress) {
  const auto on_loopback = [](auto address) {
    const int socket = ::socket(reinterpret_cast<const sockaddr&>(address).sa_family, SOCK_STREAM, 0);
    const bool bound = ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    const bool result = is_loopback_socket(socket);
    ::close(socket);
    EXPECT_TRUE(bound);
    return result;
  };
  sockaddr_in four{};
  four.sin_family = AF_INET;
  for (const auto& [text, wanted] : {std::pair{"127.0.0.1", true}, {"127.1.2.3", true}, {"0.0.0.0", false}}) {
    ASSERT_EQ(::inet_pton(AF_INET, text, &four.sin_addr), 1);
    EXPECT_EQ(on_loopback(four), wanted) << text;
  }
  EXPECT_FALSE(is_loopback_socket(-1));
}

TEST(RequestId, IsTheClientsWhenItIsAnId) {
  const auto id = [](const char* name, const char* value) { return request_id({{name, value}}); };
  const std::string trace = "4bf92f3577b34da6a3ce929d0e0e4736";
  EXPECT_EQ(id("traceparent", "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"), trace);
  EXPECT_EQ(id("x-request-id", "4BF92F35-77b3-4da6-a3ce-929d0e0e4736"), trace);
  for (const auto& [name, value] :
       {std::pair{"traceparent", "00-00000000000000000000000000000000-00f067aa0ba902b7-01"},
        std::pair{"traceparent", "4bf92f3577b34da6a3ce929d0e0e4736"}, std::pair{"X-Request-Id", "Jane Doe"},
        std::pair{"X-Request-Id", ""}, std::pair{"X-Other", "4bf92f3577b34da6a3ce929d0e0e4736"}}) {
    const std::string other = id(name, value);
    EXPECT_TRUE(is_request_id(other)) << value;
    EXPECT_NE(other, trace) << value;
    EXPECT_NE(other, id(name, value)) << value;
  }
}

TEST(Router, CapturesPiecesAndKnowsTheMethods) {
  Router router;
  const auto handler = [](Request&) -> Result<Response> { return Response(); };
  router.add("GET", "/jobs/{id}", handler);
  router.add("DELETE", "/jobs/{id}", handler);
  router.add("GET", "/jobs/{id}/artifacts/{name}", handler);
  router.add("GET", "/", handler);
  const auto match = router.match("GET", "/jobs/7/artifacts/print.png");
  ASSERT_TRUE(match.route);
  EXPECT_EQ(match.captures.at("id"), "7");
  EXPECT_EQ(match.captures.at("name"), "print.png");
  EXPECT_TRUE(router.match("GET", "/").route);
  EXPECT_FALSE(router.match("POST", "/jobs/7").route);
  EXPECT_EQ(router.match("POST", "/jobs/7").allowed, "GET, HEAD, DELETE");
  for (const char* path :
       {"", "/jobs", "/jobs/", "/jobs//", "/jobs/7/", "/jobs/7/8", "//", "/jobs/7/artifacts//"})
    EXPECT_FALSE(router.match("GET", path).route) << path;
}

}  // namespace
}  // namespace vacuform::http
