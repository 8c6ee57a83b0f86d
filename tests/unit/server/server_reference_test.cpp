// A reference belongs to one head: it follows to no other scan, and is corrected with a trace.
#include <nlohmann/json.hpp>

#include "server_fixture.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

// Heads that differ in what is no name.
const std::string one = "solid\nfacet normal 0 0 1\n", two = "solid\nfacet normal 0 0 2\n",
                  three = "solid\nfacet normal 0 0 3\n";

class ServerReference : public ServerTest {
 protected:
  // A print of a scan with these bytes.
  Answer print_of(const std::string& scan, const std::string& more = "",
                  const std::string& path = "/api/v1/jobs") const {
    return ask("POST", path, form_type,
               part("scan", "head.stl", scan) + part("pattern", "p.svg", "<svg/>") + more + "--XX--\r\n");
  }
  static std::string reference(const std::string& text) { return part("reference", "", text); }
  Answer change(const json& job, const json& body, const std::string& headers = "") const {
    return ask("PATCH", "/api/v1/jobs/" + job["id"].get<std::string>(), headers, body.dump());
  }
};

TEST_F(ServerReference, DoesNotFollowToAnotherScan) {
  const json first = json::parse(print_of(one, reference("CASE-2000")).body);
  const std::string from = part("from", "", first["id"]);
  EXPECT_EQ(json::parse(print_of(one, from).body)["reference"], "CASE-2000");
  EXPECT_EQ(json::parse(print_of(two, from).body)["reference"], "");
  EXPECT_EQ(json::parse(print_of(two, from, "/api/v1/validate").body)["reference"], "");
  for (const char* path : {"/api/v1/jobs", "/api/v1/validate"}) {
    for (const std::string& origin : {from, std::string()}) {
      const Answer refused = print_of(two, origin + reference("CASE-2000"), path);
      EXPECT_EQ(refused.status, 422) << path;
      const json problem = json::parse(refused.body);
      EXPECT_EQ(problem["where"], "reference");
      EXPECT_NE(problem["type"].get<std::string>().find("conflict"), std::string::npos);
      EXPECT_NE(problem["fix"].get<std::string>().find("rescan=true"), std::string::npos);
      EXPECT_EQ(print_of(two, origin + reference("CASE-2000") + part("rescan", "", "false"), path).status,
                422);
    }
    EXPECT_EQ(print_of(two, reference("CASE-2001"), path).status / 100, 2);
  }
  const Answer confirmed = print_of(three, from + reference("CASE-2000") + part("rescan", "", "true"));
  EXPECT_EQ(confirmed.status, 202);
  EXPECT_EQ(json::parse(confirmed.body)["reference"], "CASE-2000");
  EXPECT_EQ(print_of("solid", part("rescan", "", "perhaps")).status, 400);
  EXPECT_EQ(ask("POST", "/api/v1/jobs", "", json{{"from", first["id"]}, {"rescan", "true"}}.dump()).status,
            400);
  EXPECT_EQ(ask("POST", "/api/v1/jobs", "", json{{"from", first["id"]}, {"rescan", true}}.dump()).status,
            202);
}

TEST_F(ServerReference, IsCorrectedWithATrace) {
  const json job = json::parse(print_of(one, reference("CASE-2000")).body);
  EXPECT_EQ(job["reference_changes"], json::array());
  EXPECT_TRUE(job["printed_reference"].is_null());
  const std::string tag = ask("GET", "/api/v1/jobs/" + job["id"].get<std::string>()).header("ETag");
  EXPECT_EQ(change(job, {{"reference", "X"}}, "If-Match: \"99\"\r\n").status, 412);
  const Answer changed = change(job, {{"reference", " CASE-2001 "}}, "If-Match: " + tag + "\r\n");
  ASSERT_EQ(changed.status, 200) << changed.body;
  EXPECT_NE(changed.header("ETag"), tag);
  const json now = json::parse(changed.body);
  EXPECT_EQ(now["reference"], "CASE-2001");
  ASSERT_EQ(now["reference_changes"].size(), 1u);
  const json& trace = now["reference_changes"][0];
  EXPECT_EQ(trace["owner"], "station-1");
  EXPECT_FALSE(trace["token"].get<std::string>().empty());
  EXPECT_EQ(trace["old"], "CASE-2000");
  EXPECT_EQ(trace["new"], "CASE-2001");
  EXPECT_TRUE(trace["time"].get<std::string>().ends_with("Z"));
  // The worker gets the corrected one; a later correction does not reach what it prints.
  EXPECT_EQ(
      json::parse(ask("POST", "/api/v1/leases", worker_headers(), R"({"protocol":2})").body)["reference"],
      "CASE-2001");
  const json later = json::parse(change(job, {{"reference", "CASE-2002"}}).body);
  EXPECT_EQ(later["printed_reference"], "CASE-2001");
  EXPECT_EQ(later["reference_changes"].size(), 2u);
  const std::string page = ask("GET", "/jobs/" + job["id"].get<std::string>()).body;
  EXPECT_NE(page.find("<strong>CASE-2001</strong>"), std::string::npos) << page;
  EXPECT_NE(page.find("by station-1"), std::string::npos);

  const json other = json::parse(print_of(two).body);
  EXPECT_EQ(change(other, {{"reference", "CASE-2002"}}).status, 409);
  EXPECT_EQ(change(other, {{"reference", "CASE-2002"}, {"rescan", true}}).status, 200);
  for (const json& bad :
       {json{{"note", "x"}}, json{{"reference", 5}}, json{{"reference", "x"}, {"rescan", "true"}},
        json{{"reference", "x"}, {"note", "y"}}, json{{"reference", std::string(65, 'x')}}})
    EXPECT_EQ(change(other, bad).status, 400) << bad;
  EXPECT_EQ(ask("PATCH", "/api/v1/jobs/" + job["id"].get<std::string>(),
                bearer(token("station-2", {Scope::submit})), R"({"reference":"X"})")
                .status,
            404);
  EXPECT_EQ(ask("PATCH", "/api/v1/jobs/" + job["id"].get<std::string>(),
                bearer(token("station-1", {Scope::read})), R"({"reference":"X"})")
                .status,
            403);
}

}  // namespace
}  // namespace vacuform
