// A submission that is only validated, and what the server takes files for by their first bytes.
#include <nlohmann/json.hpp>

#include "api/problem.hpp"
#include "server/jobs/formats.hpp"
#include "server_fixture.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

std::string seems(const std::string& input, const std::string& bytes, const std::string& extension = "") {
  const auto format = format_of(input, bytes, bytes.size(), extension);
  return format ? std::string(*format) : std::string(meaning(format.error().code).slug);
}

TEST(Formats, AreRecognisedForScans) {
  const std::string binary_stl =
      std::string("solid by name only").append(62, ' ').append("\x01\0\0\0", 4).append(50, 'x');
  EXPECT_EQ(seems("scan", binary_stl), "stl");
  EXPECT_EQ(seems("scan", std::string(84, '\0')), "stl");  // no triangles, but true to its form
  EXPECT_EQ(seems("scan", std::string(90, '\0')), "unsupported-format");
  EXPECT_EQ(seems("scan", std::string(90, '\0'), "stl"),
            "stl");  // perhaps a damaged one: the reader says more
  EXPECT_EQ(seems("scan", "\n solid head\n facet"), "stl");
  EXPECT_EQ(seems("scan", "glTF\x02"), "glb");
  EXPECT_EQ(seems("scan", "ply\r\nformat ascii 1.0"), "ply");
  EXPECT_EQ(seems("scan", "COFF\n3 1 0"), "off");
  EXPECT_EQ(seems("scan", "# a comment\nv 1 2 3", "obj"), "obj");
  EXPECT_EQ(seems("scan", "v 1 2 3"), "obj");
  EXPECT_EQ(seems("scan", "once upon a time"), "unsupported-format");
  EXPECT_EQ(seems("scan", std::string("\x89PNG\r\n\x1a\n").append(90, 'x'), "stl"), "unsupported-format");
  EXPECT_EQ(seems("scan", std::string("PK\x03\x04").append(90, 'x'), "stl"), "unsupported-format");
  EXPECT_EQ(seems("scan", std::string(128, '\0').append("DICM...."), "stl"), "unsupported-format");
}

TEST(Formats, AreRecognisedForDrawingsAndTemperatures) {
  for (const char* input : {"pattern", "weights"}) {
    EXPECT_EQ(seems(input, "\x89PNG\r\n\x1a\n...."), "png");
    EXPECT_EQ(seems(input, "\xff\xd8\xff\xe0...."), "jpeg");
    EXPECT_EQ(seems(input, "\xef\xbb\xbf \n<?xml version=\"1.0\"?><svg/>"), "svg");
    EXPECT_EQ(seems(input, "<html>"), "unsupported-format");
    EXPECT_EQ(seems(input, "\x1f\x8b\x08"), "unsupported-format");
    EXPECT_EQ(seems(input, "GIF89a"), "unsupported-format");
  }
  EXPECT_EQ(seems("pattern", "  0\r\nSECTION\r\n  2\r\nHEADER\r\n"), "dxf");
  EXPECT_EQ(seems("pattern", "999\n\n0\nSECTION\n"), "dxf");
  EXPECT_EQ(seems("weights", "0\nSECTION\n"), "unsupported-format");
  EXPECT_EQ(seems("pattern", "AutoCAD Binary DXF\r\n"), "unsupported-format");
  EXPECT_EQ(seems("temperature", "140,141\n"), "csv");
  EXPECT_EQ(seems("temperature", "\x89PNG\r\n\x1a\n...."), "png");
  EXPECT_EQ(seems("temperature", "\xff\xd8\xff\xe0...."), "unsupported-format");
  EXPECT_EQ(seems("icc", std::string(36, '\0') + "acsp"), "icc");
  EXPECT_EQ(seems("icc", std::string(36, '\0') + "acs"), "unsupported-format");
  EXPECT_EQ(seems("icc", "\x89PNG\r\n\x1a\n...."), "unsupported-format");
}

TEST(Formats, OfAZipAreToldFromItsRedactedCopy) {
  const std::string packed = std::string("PK\x03\x04").append(90, 'x'),
                    drawn = "<svg xmlns=\"http://www.w3.org/2000/svg\">";
  EXPECT_EQ(seems("scan", packed, "zip"), "zip");
  EXPECT_EQ(seems("pattern", drawn, "zip"), "svg");
  const auto message = [](const std::string& input, const std::string& bytes) {
    const auto format = format_of(input, bytes, bytes.size(), "zip");
    return format ? std::string(*format) : format.error().text();
  };
  EXPECT_NE(message("pattern", packed).find("holds a model"), std::string::npos);
  EXPECT_NE(message("scan", drawn).find("holds drawings"), std::string::npos);
}

class ServerSubmission : public ServerTest {
 protected:
  Answer validate(const std::string& more = "") { return submit(more, "/api/v1/validate"); }
  void expect_nothing_kept() {
    EXPECT_TRUE(store_->list(1, "")->jobs.empty());
    EXPECT_TRUE(std::filesystem::is_empty(data_ / "incoming"));
    EXPECT_TRUE(std::filesystem::is_empty(data_ / "blobs"));
  }
};

TEST_F(ServerSubmission, ValidatedOnlyTellsWhatItWouldBeAndKeepsNothing) {
  const Answer answer = validate(part("print.dpi", "", "200") + part("temperature", "t.csv", "140,141"));
  ASSERT_EQ(answer.status, 200) << answer.body;
  EXPECT_EQ(answer.header("Location"), "");
  const json plan = json::parse(answer.body);
  EXPECT_EQ(plan["settings"]["print"]["dpi"], 200);
  EXPECT_EQ(plan["settings"]["heat"]["source"], "measured");
  EXPECT_EQ(
      plan["inputs"],
      (json{{"scan", {{"bytes", 5}, {"sha256", text_hash("solid")}, {"extension", "stl"}, {"format", "stl"}}},
            {"pattern",
             {{"bytes", stored_svg().size()},
              {"sha256", text_hash(stored_svg())},
              {"extension", "svg"},
              {"format", "svg"}}},
            {"temperature",
             {{"bytes", 7}, {"sha256", text_hash("140,141")}, {"extension", "csv"}, {"format", "csv"}}}}));
  expect_nothing_kept();
}

TEST_F(ServerSubmission, ValidatedOnlyRefusesWhatASubmissionWould) {
  EXPECT_EQ(json::parse(validate(part("print.dpi", "", "9999")).body)["where"], "print.dpi");
  EXPECT_EQ(validate(part("heat.source", "", "measured")).status, 422);
  EXPECT_EQ(validate(part("virus", "x.exe", "MZ")).status, 400);
  const Answer foreign =
      ask("POST", "/api/v1/validate", form_type,
          part("scan", "head.3mf", "PK\x03\x04") + part("pattern", "p.svg", "<svg/>") + "--XX--\r\n");
  EXPECT_EQ(foreign.status, 415);
  EXPECT_EQ(json::parse(foreign.body)["what"], "the scan is a ZIP archive");
  expect_nothing_kept();
}

// A layout needs the scan alone. Its settings are refused in a print, and not taken over by one.
TEST_F(ServerSubmission, TheSettingsOfALayoutAreForLayoutsAlone) {
  const std::string nine = part("layout.count", "", "9");
  for (const std::string& other : {std::string(), part("kind", "", "inspection")}) {
    const Answer refused = submit(nine + other);
    EXPECT_EQ(refused.status, 422);
    EXPECT_EQ(json::parse(refused.body)["where"], "layout.count");
  }
  const auto post = [&](const std::string& parts) {
    const Answer answer = ask("POST", "/api/v1/jobs", form_type, parts + "--XX--\r\n");
    EXPECT_EQ(answer.status, 202) << answer.body;
    return json::parse(answer.body);
  };
  const json layout = post(part("kind", "", "layout") + part("scan", "a.stl", "solid") + nine);
  EXPECT_EQ(layout["kind"], "layout");
  EXPECT_EQ(layout["settings"]["layout"]["count"], 9);
  const std::string from = part("from", "", layout["id"].get<std::string>());
  const json print = post(from + part("pattern", "p.svg", "<svg/>") + part("print.dpi", "", "72"));
  EXPECT_EQ(print["kind"], "print");
  EXPECT_EQ(print["settings"]["layout"]["count"], 16);
  EXPECT_EQ(print["settings"]["print"]["dpi"], 72);
  EXPECT_EQ(post(from + part("kind", "", "layout"))["settings"]["layout"]["count"], 9);

  ASSERT_EQ(
      ask("PUT", "/api/v1/profiles/array", bearer(admin_) + json_type, R"({"layout":{"count":9}})").status,
      201);
  const std::string scan = part("scan", "a.stl", "solid") + part("profile", "", "array");
  EXPECT_EQ(post(scan + part("pattern", "p.svg", "<svg/>"))["settings"]["layout"]["count"], 16);
  EXPECT_EQ(post(scan + part("kind", "", "layout"))["settings"]["layout"]["count"], 9);
}

// A worker gets what the job reads: for a layout the scan and the temperature.
TEST_F(ServerSubmission, AWorkerGetsTheFilesThatALayoutReads) {
  ASSERT_EQ(submit(part("kind", "", "layout") + part("temperature", "t.csv", "140,141")).status, 202);
  const json lease = json::parse(ask("POST", "/api/v1/leases", worker_headers(), R"({"protocol":2})").body);
  EXPECT_EQ(lease["kind"], "layout");
  EXPECT_TRUE(lease["inputs"].contains("scan") && lease["inputs"].contains("temperature"));
  EXPECT_FALSE(lease["inputs"].contains("pattern"));
  const Answer refused = submit(part("kind", "", "layout") + part("weights", "w.svg", "<svg/>"));
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(json::parse(refused.body)["where"], "flattening.weights");
}

TEST_F(ServerSubmission, AQueryThatTheRouteDoesNotTakeIsRefusedByName) {
  for (const char* query : {"?validate-only=true", "?validate_only=true", "?limit=1"}) {
    const Answer answer = submit("", std::string("/api/v1/jobs") + query);
    EXPECT_EQ(answer.status, 400) << query;
    EXPECT_EQ(json::parse(answer.body)["where"], "query");
  }
  expect_nothing_kept();
  EXPECT_NE(ask("GET", "/api/v1/jobs?stat=failed").body.find("unknown query parameter: stat"),
            std::string::npos);
  EXPECT_EQ(ask("GET", "/api/v1/jobs?limit=1&limit=2").status, 400);
  EXPECT_EQ(ask("GET", "/api/v1/jobs?limit=1").status, 200);
  EXPECT_EQ(ask("GET", "/healthz?x=1").status, 400);
}

TEST_F(ServerSubmission, AReferenceAndANoteStandWithTheJob) {
  const std::string texts =
      part("reference", "", " CASE-12 <ä> ") + part("note", "", "first\r\nsecond & last");
  const json plan = json::parse(validate(texts).body);
  EXPECT_EQ(plan["reference"], "CASE-12 <ä>");
  EXPECT_EQ(plan["note"], "first\nsecond & last");
  expect_nothing_kept();
  const json job = json::parse(submit(texts).body);
  EXPECT_EQ(job["reference"], "CASE-12 <ä>");
  EXPECT_EQ(job["note"], "first\nsecond & last");
  const json listed = json::parse(ask("GET", "/api/v1/jobs").body)["jobs"][0];
  EXPECT_EQ(listed["reference"], job["reference"]);
  EXPECT_EQ(listed["note"], job["note"]);
  const std::string page = ask("GET", "/jobs/" + job["id"].get<std::string>()).body;
  EXPECT_NE(page.find("<dd>CASE-12 &lt;ä&gt;</dd>"), std::string::npos) << page;
  EXPECT_NE(page.find("first\nsecond &amp; last</dd>"), std::string::npos);
  EXPECT_NE(ask("GET", "/jobs").body.find("CASE-12 &lt;ä&gt;"), std::string::npos);
  const json lease =
      json::parse(ask("POST", "/api/v1/leases", worker_headers(), R"({"worker":"test","protocol":2})").body);
  EXPECT_EQ(lease["reference"], "CASE-12 <ä>");
  EXPECT_FALSE(lease.contains("note"));

  for (const std::string& wrong :
       {part("reference", "", std::string(65, 'x')), part("reference", "", "two\nlines"),
        part("note", "", "bell\a"), part("note", "", std::string(501, 'x'))}) {
    const Answer refused = submit(wrong);
    EXPECT_EQ(refused.status, 400) << wrong;
    EXPECT_EQ(json::parse(refused.body)["fix"].get<std::string>().empty(), false);
  }
}

TEST_F(ServerSubmission, AJobFromAnotherTakesItsReferenceAndNotItsNote) {
  const json first =
      json::parse(submit(part("reference", "", "CASE-12") + part("note", "", "a remark")).body);
  const auto derive = [&](json body) {
    body["from"] = first["id"];
    return json::parse(ask("POST", "/api/v1/jobs", "", body.dump()).body);
  };
  const json same = derive({{"reference", ""}}), other = derive({{"reference", "CASE-13"}, {"note", "new"}});
  EXPECT_EQ(same["reference"], "CASE-12");
  EXPECT_EQ(same["note"], "");
  EXPECT_EQ(other["reference"], "CASE-13");
  EXPECT_EQ(other["note"], "new");
}

TEST_F(ServerSubmission, JobsAreFoundByAPartOfTheirText) {
  const std::string koeln = json::parse(submit(part("reference", "", "KÖLN 100%")).body)["id"],
                    plus = json::parse(submit(part("note", "", "a+b_c")).body)["id"];
  const auto found = [&](const std::string& query, const std::string& headers = "") {
    const Answer answer = ask("GET", "/api/v1/jobs?" + query, headers);
    EXPECT_EQ(answer.status, 200) << answer.body;
    std::vector<std::string> ids;
    const json page = json::parse(answer.body);
    for (const json& job : page["jobs"]) ids.push_back(job["id"]);
    return ids;
  };
  using Ids = std::vector<std::string>;
  EXPECT_EQ(found("text=k%C3%B6ln+100%25"), Ids{koeln});
  EXPECT_EQ(found("text=_"), Ids{plus});
  EXPECT_EQ(found("text=A%2Bb"), Ids{plus});
  EXPECT_EQ(found("text=" + koeln.substr(18)), Ids{koeln});
  EXPECT_EQ(found("text=+"), (Ids{plus, koeln}));
  EXPECT_EQ(found("text=k%C3%B6ln&state=failed"), Ids{});
  EXPECT_EQ(found("text=k%C3%B6ln", bearer(token("station-2", {Scope::read}))), Ids{});  // of another owner
  EXPECT_EQ(ask("GET", "/api/v1/jobs?text=" + std::string(101, 'a')).status, 400);
  EXPECT_EQ(json::parse(ask("GET", "/api/v1/jobs?text=%FF").body)["where"], "text");
}

TEST_F(ServerSubmission, AReferenceIsPartOfWhatAKeyNames) {
  const auto send = [&](const std::string& reference) {
    return ask("POST", "/api/v1/jobs", form_type + std::string("Idempotency-Key: 12345678\r\n"),
               part("scan", "a.stl", "solid") + part("pattern", "p.svg", "<svg/>") +
                   part("reference", "", reference) + "--XX--\r\n");
  };
  const json first = json::parse(send("CASE-12").body);
  EXPECT_EQ(json::parse(send(" CASE-12 ").body)["id"], first["id"]);
  EXPECT_EQ(send("CASE-13").status, 422);
  for (const char* key : {"Idempotency-Key:\r\n", "Idempotency-Key: \r\n"})  // it would not protect
    EXPECT_EQ(ask("POST", "/api/v1/jobs", form_type + std::string(key),
                  part("scan", "a.stl", "solid") + part("pattern", "p.svg", "<svg/>") + "--XX--\r\n")
                  .status,
              400);
}

TEST_F(ServerSubmission, AJsonBodyIsReadStrictly) {
  const auto problem_of = [&](const std::string& body) {
    const Answer answer = ask("POST", "/api/v1/jobs", "", body);
    EXPECT_EQ(answer.status / 100, 4) << body;
    return json::parse(answer.body)["detail"].get<std::string>();
  };
  EXPECT_NE(problem_of(R"({"kind": "print", "kind": "inspection"})").find("\"kind\" twice"),
            std::string::npos);
  EXPECT_NE(problem_of(R"({"settings": {"print": {"dpi": 72, "dpi": 600}}})").find("\"dpi\" twice"),
            std::string::npos);
  EXPECT_NE(problem_of("{\"kind\": ").find("not valid JSON, near byte"), std::string::npos);
  for (const char* body : {R"({"scan_upload": 5})", R"({"from": 5})", R"({"profile": 1})", R"({"kind": 0})"})
    EXPECT_NE(problem_of(body).find("not a string"), std::string::npos) << body;
  EXPECT_NE(problem_of(R"({"priority": "1"})").find("not a whole number"), std::string::npos);
  EXPECT_NE(problem_of(R"({"settings": "{}"})").find("not an object"), std::string::npos);
  EXPECT_NE(validate(part("settings", "", R"({"print": {"dpi": 72}, "print": {}})")).body.find("twice"),
            std::string::npos);
  expect_nothing_kept();
}

}  // namespace
}  // namespace vacuform
