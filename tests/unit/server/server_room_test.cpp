// What clients are told, by the routes that they use, when there is no room for them.
#include <nlohmann/json.hpp>

#include "server_fixture.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

class ServerQueue : public ServerTest {
 protected:
  StoreOptions store_options() const override {
    StoreOptions options;
    options.most_queued_by_owner = 2;
    return options;
  }
};

TEST_F(ServerQueue, WhoFindsItFullIsToldWhenToComeAgain) {
  for (int i = 0; i < 2; ++i) ASSERT_EQ(submit().status, 202);
  const Answer refused = submit();
  EXPECT_EQ(refused.status, 429);
  EXPECT_EQ(json::parse(refused.body)["type"], "/problems/busy");
  EXPECT_EQ(json::parse(refused.body)["what"], "2 of your jobs wait already");
  EXPECT_EQ(refused.header("Retry-After"), "60");  // no job has ended yet
  EXPECT_EQ(store_->list(100, "")->jobs.size(), 2u);

  const std::string other = bearer(token("station-2", {Scope::submit}));
  EXPECT_EQ(ask("POST", "/api/v1/jobs", other + form_type,
                part("scan", "a.stl", "solid") + part("pattern", "p.svg", "<svg/>") + "--XX--\r\n")
                .status,
            202);
}

class ServerDisk : public ServerTest {
 protected:
  StoreOptions store_options() const override {
    StoreOptions options;
    options.kept_free = std::uint64_t{1} << 60;
    return options;
  }
};

TEST_F(ServerDisk, WhoFindsItFullIsToldWhenToComeAgain) {
  const auto expect_full = [](const Answer& refused) {
    EXPECT_EQ(refused.status, 507) << refused.body;
    EXPECT_EQ(refused.header("Retry-After"), "60");
  };
  const Answer refused = submit();
  expect_full(refused);
  EXPECT_EQ(json::parse(refused.body)["type"], "/problems/disk-full");
  expect_full(ask("POST", "/api/v1/scans", form_type, part("scan", "a.stl", "solid") + "--XX--\r\n"));
  EXPECT_EQ(ask("GET", "/api/v1/jobs").status, 200);
}

}  // namespace
}  // namespace vacuform
