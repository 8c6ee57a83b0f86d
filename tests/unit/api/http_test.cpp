#include "api/client/http.hpp"

#include <gtest/gtest.h>

namespace vacuform {
namespace {

TEST(Http, TakesOnlyAddressesOfServers) {
  for (const char* url : {"", "127.0.0.1:8080", "ftp://host", "http://", "https://", "file:///etc/passwd"}) {
    const auto http = Http::to(url);
    ASSERT_FALSE(http) << url;
    EXPECT_EQ(http.error().code, Code::bad_usage);
  }
  EXPECT_EQ(Http::to("http://127.0.0.1:8080//")->url(), "http://127.0.0.1:8080");
  EXPECT_FALSE(Http::to("https://host", "two\r\nlines"));
}

TEST(Http, KeepsATokenOffTheNetworkWithoutTls) {
  for (const char* url :
       {"http://example.org", "http://192.0.2.1:8080", "http://127.evil.example", "http://[2001:db8::1]",
        "http://localhost.example.org", "http://localhost@example.org", "http://127.0.0.1@192.0.2.1"}) {
    const auto refused = Http::to(url, "token");
    ASSERT_FALSE(refused) << url;
    EXPECT_NE(refused.error().what.find("plain HTTP"), std::string::npos);
    EXPECT_TRUE(Http::to(url)) << url;
  }
  for (const char* url :
       {"http://127.0.0.1:8080", "http://localhost:8080/", "http://[::1]:8080", "https://example.org"})
    EXPECT_TRUE(Http::to(url, "token")) << url;
}

TEST(Http, NobodyAtTheAddressIsUnavailable) {
  auto http = Http::to("http://127.0.0.1:1");
  ASSERT_TRUE(http);
  const auto response = http->send({});
  ASSERT_FALSE(response);
  EXPECT_EQ(response.error().code, Code::unavailable);
  EXPECT_EQ(response.error().where, "http://127.0.0.1:1");
}

TEST(Http, ProblemDocumentsBecomeErrors) {
  const Error error = error_of({422, {}, R"({"type":"/problems/ambiguous-units","title":"t","status":422,
    "what":"the unit cannot be told","where":"head.obj","fix":"give scan.units","proposals":[{"set":{"scan":{"units":"m"}},"text":"190 mm"}]})"});
  ASSERT_EQ(error.proposals.size(), 1u);
  EXPECT_EQ(options_of(error.proposals.front()), "--set scan.units=m");
  EXPECT_EQ(error.code, Code::ambiguous_units);
  EXPECT_EQ(error.text(), "the unit cannot be told (head.obj); give scan.units");
}

TEST(Http, AnswersWithoutAProblemKeepTheirStatus) {
  EXPECT_EQ(error_of({503, {}, "<html>"}).code, Code::unavailable);
  EXPECT_EQ(error_of({404, {}, ""}).code, Code::not_found);
  EXPECT_EQ(error_of({500, {}, "[]"}).code, Code::internal);
  EXPECT_EQ(error_of({418, {}, R"({"type":"/problems/teapot"})"}).code, Code::bad_usage);
  EXPECT_NE(error_of({418, {}, ""}).what.find("418"), std::string::npos);
}

}  // namespace
}  // namespace vacuform
