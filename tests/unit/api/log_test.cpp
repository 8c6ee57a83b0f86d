#include "api/base/log.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "api/base/clock.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

const std::string outer(32, 'a'), inner(32, 'b');

template <class F>
json logged(const F& say) {
  testing::internal::CaptureStderr();
  say();
  return json::parse(testing::internal::GetCapturedStderr());  // also: that it is one line
}

TEST(Log, IsOneJsonObjectALineWithItsRequest) {
  const json plain = logged([] { log_event("job-created", {{"job", "j1"}}); });
  EXPECT_EQ(plain["event"], "job-created");
  EXPECT_EQ(plain["job"], "j1");
  EXPECT_FALSE(plain.contains("request"));
  EXPECT_EQ(plain["time"].get<std::string>().size(), 24u);

  const LoggedRequest request(outer);
  EXPECT_EQ(logged([] { log_event("e", {{"a", 1}}); })["request"], outer);
  {
    const LoggedRequest nested(inner);
    EXPECT_EQ(logged([] { log_event("e", {{"a", 1}}); })["request"], inner);
    std::thread([] { EXPECT_EQ(logged_request(), ""); }).join();  // another thread works for nobody yet
  }
  EXPECT_EQ(logged_request(), outer);
}

TEST(Log, AFileStaysBelowItsBoundAndKeepsWhatWasBeforeIt) {
  std::string name = (std::filesystem::temp_directory_path() / "log-test-XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  const std::filesystem::path log = std::filesystem::path(name) / "server.log";
  const int before = ::dup(STDERR_FILENO);
  ASSERT_TRUE(log_into(log));
  for (int i = 0; i < 100; ++i) {
    log_event("e", {{"number", i}});
    bound_log(log, 1000);
  }
  ::dup2(before, STDERR_FILENO);
  ::close(before);
  EXPECT_LT(std::filesystem::file_size(log), 1100u);
  EXPECT_GE(std::filesystem::file_size(log.string() + ".1"), 1000u);
  EXPECT_LT(std::filesystem::file_size(log.string() + ".1"), 1100u);
  EXPECT_FALSE(log_into(log / "nowhere"));
  std::filesystem::remove_all(name);
}

TEST(Log, BytesOfScansCannotBreakALine) {
  const json line = logged([] { log_event("e", {{"stderr", "a\nb\xff\"}"}}); });
  EXPECT_EQ(line["stderr"], "a\nb\xEF\xBF\xBD\"}");
}

TEST(Log, AnIdCannotSpellAName) {
  EXPECT_TRUE(is_request_id("4bf92f3577b34da6a3ce929d0e0e4736"));
  for (const char* text :
       {"", "jane-doe", "4BF92F3577B34DA6A3CE929D0E0E4736", "4bf92f3577b34da6a3ce929d0e0e473",
        "4bf92f3577b34da6a3ce929d0e0e47360", "4bf92f3577b34da6a3ce929d0e0e473\n"})
    EXPECT_FALSE(is_request_id(text)) << text;
}

TEST(Clock, WritesTimesAsRfc3339) {
  EXPECT_EQ(rfc3339(0), "1970-01-01T00:00:00.000Z");
  EXPECT_EQ(rfc3339(1'709'208'000'123), "2024-02-29T12:00:00.123Z");
}

}  // namespace
}  // namespace vacuform
