// The API, the worker protocol and the pages through a real server.
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "api/problem.hpp"
#include "server/pages/assets.hpp"
#include "server/pages/pages.hpp"
#include "server_fixture.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

class ServerApi : public ServerTest {
 protected:
  std::string created() {
    const Answer answer = submit();
    EXPECT_EQ(answer.status, 202) << answer.body;
    return json::parse(answer.body)["id"];
  }
  json show(const std::string& id) { return json::parse(ask("GET", "/api/v1/jobs/" + id).body); }
  json lease() {
    return json::parse(
        ask("POST", "/api/v1/leases", worker_headers(), R"({"worker":"test","protocol":2})").body);
  }
  Answer worker(const std::string& method, const json& lease, const std::string& path,
                const std::string& body = "{}") {
    return ask(method, "/api/v1/leases/" + lease["job"].get<std::string>() + path,
               worker_headers(lease["lease"].get<std::string>()), body);
  }
};

TEST_F(ServerApi, AJobFromItsFormToItsZip) {
  const Answer made = submit(part("settings", "", R"({"print":{"dpi":150},"scan":{"units":"mm"}})") +
                             part("print.dpi", "", "200") + part("pattern.offset_mm", "", " 3, -4 ") +
                             part("pattern.scale", "", ""));
  ASSERT_EQ(made.status, 202) << made.body;
  const std::string id = json::parse(made.body)["id"];
  EXPECT_EQ(made.header("Location"), "/api/v1/jobs/" + id);
  json job = show(id);
  EXPECT_EQ(job["state"], "queued");
  EXPECT_EQ(job["settings"]["print"]["dpi"], 200);  // a field goes before the JSON text
  EXPECT_EQ(job["settings"]["scan"]["units"], "mm");
  EXPECT_EQ(job["settings"]["pattern"]["offset_mm"], (json{3, -4}));
  EXPECT_EQ(job["settings"]["pattern"]["scale"], 1);
  EXPECT_EQ(job["inputs"]["scan"]["extension"], "stl");
  EXPECT_EQ(job["inputs"]["scan"]["bytes"], 5);

  const json held = lease();
  EXPECT_EQ(held["job"], id);
  EXPECT_EQ(held["settings"], job["settings"]);
  EXPECT_EQ(held["lease_seconds"], 30);
  EXPECT_EQ(worker("GET", held, "/inputs/scan", "").body, "solid");
  EXPECT_EQ(worker("GET", held, "/inputs/pattern", "").body, stored_svg());
  EXPECT_EQ(worker("GET", held, "/inputs/database", "").status, 404);
  EXPECT_EQ(
      json::parse(worker("POST", held, "/heartbeat", R"({"stage":"forming","progress":0.5})").body)["cancel"],
      false);
  job = show(id);
  EXPECT_EQ(job["state"], "running");
  EXPECT_EQ(job["stage"], "forming");
  EXPECT_DOUBLE_EQ(job["stage_progress"], 0.5);
  EXPECT_DOUBLE_EQ(job["progress"], 0.325);
  EXPECT_EQ(worker("POST", held, "/heartbeat", R"({"stage":"cooking"})").status, 400);
  EXPECT_EQ(worker("POST", held, "/heartbeat", "[").status, 400);
  EXPECT_EQ(worker("PUT", held, "/artifacts/report.json", R"({"figures":{}})").status, 200);
  EXPECT_EQ(worker("PUT", held, "/artifacts/print.png", std::string(200'000, 'p')).status, 200);
  const Answer early = worker("POST", held, "/complete");
  EXPECT_EQ(early.status, 409);
  EXPECT_NE(json::parse(early.body)["what"].get<std::string>().find("print.svg, print.pdf"),
            std::string::npos);
  put_artifacts({held["job"], held["lease"]}, {"report.json", "print.png"});
  EXPECT_TRUE(show(id)["artifacts"].empty());  // until it has succeeded
  EXPECT_EQ(ask("GET", "/api/v1/jobs/" + id + "/artifacts/print.png").status, 404);
  EXPECT_EQ(ask("GET", "/api/v1/jobs/" + id + "/artifacts.zip").status, 404);
  EXPECT_EQ(show(id)["serious_warnings"], nullptr);
  for (const char* wrong :
       {R"({"serious_warnings":-1})", R"({"serious_warnings":"2"})", R"({"serious_warnings":1001})"})
    EXPECT_EQ(worker("POST", held, "/complete", wrong).status, 400) << wrong;
  EXPECT_EQ(json::parse(worker("POST", held, "/complete", R"({"serious_warnings":2})").body)["state"],
            "succeeded");
  EXPECT_EQ(show(id)["serious_warnings"], 2);
  EXPECT_EQ(worker("POST", held, "/complete").status, 200);
  EXPECT_EQ(worker("PUT", held, "/artifacts/print.svg", "late").status, 409);

  job = show(id);
  EXPECT_EQ(job["state"], "succeeded");
  EXPECT_EQ(job["progress"], 1);
  ASSERT_EQ(job["artifacts"].size(), 21u);
  EXPECT_EQ(job["artifacts"][0]["name"], "print.png");
  EXPECT_EQ(job["artifacts"][0]["bytes"], 200'000);
  const Answer zip = ask("GET", "/api/v1/jobs/" + id + "/artifacts.zip"),
               again = ask("GET", "/api/v1/jobs/" + id + "/artifacts.zip");
  EXPECT_EQ(zip.status, 200);
  EXPECT_EQ(zip.body.substr(0, 4), "PK\x03\x04");
  EXPECT_EQ(zip.body, again.body);
  const Answer head = ask("HEAD", "/api/v1/jobs/" + id + "/artifacts.zip"),
               part = ask("GET", "/api/v1/jobs/" + id + "/artifacts.zip", "Range: bytes=5-\r\n");
  EXPECT_EQ(head.header("Content-Length"), std::to_string(zip.body.size()));
  EXPECT_EQ(head.header("ETag"), zip.header("ETag"));
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, zip.body.substr(5));
  EXPECT_TRUE(std::filesystem::is_empty(data_ / "incoming"));
  EXPECT_EQ(ask("DELETE", "/api/v1/jobs/" + id).status, 204);
  EXPECT_EQ(ask("GET", "/api/v1/jobs/" + id).status, 404);
}

TEST_F(ServerApi, TheRequestThatMadeAJobIsKnownToItsWorker) {
  const std::string id = "4bf92f3577b34da6a3ce929d0e0e4736";
  const Answer made = ask("POST", "/api/v1/jobs", form_type + ("X-Request-Id: " + id + "\r\n"),
                          part("scan", "a.stl", "solid") + part("pattern", "p.svg", "<svg/>") + "--XX--\r\n");
  EXPECT_EQ(made.header("X-Request-Id"), id);
  EXPECT_EQ(lease()["request"], id);
  EXPECT_EQ(ask("GET", "/nowhere").header("X-Request-Id").size(), 32u);
  EXPECT_EQ(raw("nonsense\r\n\r\n").header("X-Request-Id").size(), 32u);
}

TEST_F(ServerApi, AWorkerOfAnotherProtocolGetsNoJob) {
  const json made =
      json::parse(ask("POST", "/api/v1/jobs", form_type,
                      part("scan", "a.stl", "solid") + part("pattern", "p.svg", "<svg/>") + "--XX--\r\n")
                      .body);
  for (const char* body :
       {"{}", R"({"protocol":1})", R"({"protocol":3,"version":"9.9 <b>"})", R"({"protocol":"2"})"}) {
    const auto refused = ask("POST", "/api/v1/leases", worker_headers(), body);
    EXPECT_EQ(refused.status, 409) << body;
    EXPECT_EQ(json::parse(refused.body)["where"], "protocol");
    EXPECT_EQ(refused.body.find('<'), std::string::npos);
  }
  EXPECT_EQ(json::parse(ask("GET", "/api/v1/jobs/" + made["id"].get<std::string>()).body)["attempt"], 0);
}

TEST_F(ServerApi, SaysItsLimitsAndWhatKeepsJobsIn) {
  const std::string ask_for_job =
      R"({"worker":"w1","protocol":2,"sandbox":["seccomp","namespaces","magic"]})";
  EXPECT_EQ(ask("POST", "/api/v1/leases", worker_headers(), ask_for_job).status, 204);
  EXPECT_EQ(ask("POST", "/api/v1/leases", worker_headers(), R"({"worker":"w2","protocol":2})").status, 204);
  for (const char* wrong : {R"({"worker":5})", R"({"sandbox":"seccomp"})", R"({"sandbox":[7]})"})
    EXPECT_EQ(ask("POST", "/api/v1/leases", worker_headers(), wrong).status, 400) << wrong;
  const json limits = json::parse(ask("GET", "/api/v1/limits").body);
  EXPECT_EQ(limits["scan_bytes"], 1 << 30);
  EXPECT_EQ(limits["head_lines"], 100);
  ASSERT_EQ(limits["workers"].size(), 2u);
  EXPECT_EQ(
      limits["workers"][0],
      (json{{"worker", "w1"}, {"sandbox", {"namespaces", "seccomp"}}, {"lacks", json::array({"landlock"})}}));
  EXPECT_EQ(limits["workers"][1]["lacks"].size(), 3u);
}

TEST_F(ServerApi, ListsAreShortAndFiltered) {
  const std::string queued = created(), cancelled = created();
  ask("POST", "/api/v1/jobs/" + cancelled + "/cancel");
  const auto list = [&](const std::string& query, const std::string& who = "") {
    return json::parse(ask("GET", "/api/v1/jobs" + query, who).body)["jobs"];
  };
  const json brief = list("?state=queued");
  ASSERT_EQ(brief.size(), 1u);
  EXPECT_EQ(brief[0]["id"], queued);
  EXPECT_EQ(brief[0]["owner"], "station-1");
  for (const char* key : {"settings", "inputs", "artifacts", "links"})
    EXPECT_FALSE(brief[0].contains(key)) << key;
  json alone = show(cancelled);
  for (const char* estimate : {"queue_position", "seconds_expected"})  // of a single job alone
    EXPECT_EQ(alone.erase(estimate), 1u) << estimate;
  EXPECT_EQ(list("?full=true&limit=1")[0], alone);
  EXPECT_EQ(list("?state=queued,cancelled").size(), 2u);
  EXPECT_EQ(list("?state=running").size(), 0u);
  EXPECT_EQ(list("?kind=inspection").size(), 0u);
  const std::string created = show(queued)["created"];
  EXPECT_EQ(list("?created_after=" + created).size(),
            list("?created_after=" + created + "&state=cancelled").size());
  EXPECT_EQ(list("?created_before=" + created).size(), 0u);
  EXPECT_EQ(list("?created_before=2100-01-01T00:00:00%2B02:00").size(), 2u);
  EXPECT_EQ(list("?owner=station-1").size(), 2u);
  EXPECT_EQ(list("?owner=station-1", bearer(admin_)).size(), 2u);
  EXPECT_EQ(list("?owner=station-2", bearer(admin_)).size(), 0u);
  EXPECT_EQ(ask("GET", "/api/v1/jobs?owner=station-2").status, 403);
  for (const char* query : {"state=waiting", "state=queued,", "kind=video", "created_after=yesterday",
                            "full=1", "created_before=2026-02-30T00:00:00Z"})
    EXPECT_EQ(ask("GET", std::string("/api/v1/jobs?") + query).status,
              std::string(query) == "state=queued," ? 200 : 400)
        << query;
}

TEST_F(ServerApi, DownloadsKnowRangesAndEntityTags) {
  const std::string id = created(), path = "/api/v1/jobs/" + id + "/artifacts/formed.ply";
  const json held = lease();
  std::string bytes;
  for (std::uint32_t i = 0; i < 300'000; ++i) bytes += static_cast<char>(i * 7919u >> 3);
  ASSERT_EQ(worker("PUT", held, "/artifacts/formed.ply", bytes).status, 200);
  finish({held["job"], held["lease"]}, {"formed.ply"});
  const Answer whole = ask("GET", path);
  EXPECT_EQ(whole.body, bytes);
  EXPECT_EQ(whole.header("ETag"), "\"" + text_hash(bytes) + "\"");
  EXPECT_EQ(whole.header("Content-Length"), "300000");
  EXPECT_EQ(whole.header("X-Content-Type-Options"), "nosniff");
  const Answer part = ask("GET", path, "Range: bytes=100000-299998\r\n");
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.header("Content-Range"), "bytes 100000-299998/300000");
  EXPECT_EQ(part.body, bytes.substr(100'000, 199'999));
  const Answer beyond = ask("GET", path, "Range: bytes=300000-\r\n");
  EXPECT_EQ(beyond.status, 416);
  EXPECT_EQ(beyond.header("Content-Range"), "bytes */300000");
  const std::string tag = whole.header("ETag");
  const Answer known = ask("GET", path, "If-None-Match: " + tag + "\r\n");
  EXPECT_EQ(known.status, 304);
  EXPECT_TRUE(known.body.empty());
  EXPECT_EQ(ask("GET", path, "Range: bytes=0-9\r\nIf-Range: " + tag + "\r\n").status, 206);
  EXPECT_EQ(ask("GET", path, "Range: bytes=0-9\r\nIf-Range: \"old\"\r\n").status, 200);
  const Answer head = ask("HEAD", path);
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.header("Content-Length"), "300000");
  EXPECT_TRUE(head.body.empty());
}

TEST_F(ServerApi, DownloadsAreNamedForPeople) {
  const auto named = [&](const std::string& more, const std::string& name) {
    const std::string id = json::parse(submit(more).body)["id"];
    const json held = lease();
    finish({held["job"], held["lease"]});
    const std::string disposition = ask("GET", "/api/v1/jobs/" + id + name).header("Content-Disposition");
    EXPECT_EQ(ask("HEAD", "/api/v1/jobs/" + id + name).header("Content-Disposition"), disposition);
    return std::pair(id.substr(18), disposition);
  };
  EXPECT_EQ(named(part("reference", "", "CASE-12"), "/artifacts/print.pdf").second,
            "inline; filename=\"CASE-12-outer-print.pdf\"");
  EXPECT_EQ(
      named(part("reference", "", "Köln 7") + part("pattern.inked_face", "", "inner"), "/artifacts/print.svg")
          .second,
      "inline; filename=\"K-ln-7-inner-print.svg\"; filename*=UTF-8''K%C3%B6ln%207-inner-print.svg");
  const auto [id, mold] = named("", "/artifacts/mold.stl");
  EXPECT_EQ(mold, "inline; filename=\"" + id + "-mold.stl\"");
  EXPECT_EQ(named(part("reference", "", "CASE-12"), "/artifacts.zip").second,
            "attachment; filename=\"CASE-12-artifacts.zip\"");
}

TEST_F(ServerApi, AFailureReachesTheUserWithItsReason) {
  const std::string id = created();
  const json held = lease();
  EXPECT_EQ(worker("POST", held, "/fail", R"({"code":"nonsense","what":"x"})").status, 400);
  EXPECT_EQ(worker("POST", held, "/fail", R"({"code":"ambiguous-units","what":"x","proposals":[{"set":3}]})")
                .status,
            400);
  EXPECT_EQ(
      worker(
          "POST", held, "/fail",
          R"({"code":"ambiguous-units","what":"cm or in","where":"scan","fix":"set <scan.units>","retry":false,)"
          R"("proposals":[{"set":{"scan":{"units":"cm"}},"text":"100 mm"}]})")
          .status,
      200);
  const json job = show(id);
  EXPECT_EQ(job["state"], "failed");
  EXPECT_EQ(job["problem"]["type"], "/problems/ambiguous-units");
  EXPECT_EQ(job["problem"]["fix"], "set <scan.units>");
  EXPECT_EQ(job["problem"]["proposals"], json::parse(R"([{"set":{"scan":{"units":"cm"}},"text":"100 mm"}])"));
  const Answer page = ask("GET", "/jobs/" + id);
  EXPECT_NE(page.body.find("set &lt;scan.units&gt;"), std::string::npos);
  EXPECT_EQ(page.body.find("refresh"), std::string::npos);
  EXPECT_EQ(ask("GET", "/problems/ambiguous-units").status, 200);
}

TEST_F(ServerApi, ARepeatedSubmissionMakesOneJob) {
  const std::string form = part("scan", "a.stl", "solid") + part("pattern", "p.svg", "<svg/>") + "--XX--\r\n";
  const auto send = [&](const std::string& key) {
    return ask("POST", "/api/v1/jobs", form_type + ("Idempotency-Key: " + key + "\r\n"), form);
  };
  EXPECT_EQ(json::parse(send("3f0c9a52").body)["id"], json::parse(send("3f0c9a52").body)["id"]);
  EXPECT_EQ(send("short").status, 400);
  const Answer other =
      ask("POST", "/api/v1/jobs", form_type + std::string("Idempotency-Key: 3f0c9a52\r\n"),
          part("scan", "a.stl", "other") + part("pattern", "p.svg", "<svg/>") + "--XX--\r\n");
  EXPECT_EQ(other.status, 422);
  EXPECT_EQ(json::parse(other.body)["type"], "/problems/conflict");
  EXPECT_EQ(json::parse(ask("GET", "/api/v1/jobs").body)["jobs"].size(), 1u);
}

TEST_F(ServerApi, BadSettingsAreNamedBeforeAJobExists) {
  const Answer answer = submit(part("print.dpi", "", "9999"));
  EXPECT_EQ(answer.status, 422);
  EXPECT_EQ(json::parse(answer.body)["where"], "print.dpi");
  EXPECT_EQ(json::parse(answer.body)["what"], "out of range: 9999");
  EXPECT_EQ(submit(part("settings", "", "{\"a\":" + std::string(5000, '['))).status, 422);
  EXPECT_EQ(submit(part("settings", "", "\xff\xfe")).status, 422);
  EXPECT_EQ(submit(part("print.\xff", "", "1")).status, 422);
  EXPECT_TRUE(json::parse(ask("GET", "/api/v1/jobs").body)["jobs"].empty());
}

TEST_F(ServerApi, CancellingThroughApiAndPage) {
  const std::string first = created(), second = created();
  const json held = lease();
  EXPECT_EQ(json::parse(ask("POST", "/api/v1/jobs/" + first + "/cancel").body)["state"], "cancelling");
  EXPECT_EQ(json::parse(worker("POST", held, "/heartbeat").body)["cancel"], true);
  EXPECT_EQ(json::parse(worker("POST", held, "/cancelled").body)["state"], "cancelled");
  const Answer page = ask("POST", "/jobs/" + second + "/cancel", "Origin: http://" + host() + "\r\n");
  EXPECT_EQ(page.status, 303);
  EXPECT_EQ(page.header("Location"), "/jobs/" + second);
  EXPECT_EQ(show(second)["state"], "cancelled");
  EXPECT_EQ(ask("POST", "/jobs/" + second + "/delete").header("Location"), "/jobs");
  EXPECT_EQ(ask("GET", "/jobs/" + second, "Accept: text/html\r\n").status, 404);
}

TEST_F(ServerApi, ListsInPages) {
  for (int i = 0; i < 3; ++i) created();
  const json first = json::parse(ask("GET", "/api/v1/jobs?limit=2").body);
  ASSERT_EQ(first["jobs"].size(), 2u);
  const json second =
      json::parse(ask("GET", "/api/v1/jobs?limit=2&cursor=" + first["next"].get<std::string>()).body);
  EXPECT_EQ(second["jobs"].size(), 1u);
  EXPECT_TRUE(second["next"].is_null());
  for (const char* limit : {"0", "101", "x", "-1", "2x"})
    EXPECT_EQ(ask("GET", std::string("/api/v1/jobs?limit=") + limit).status, 400) << limit;
}

TEST_F(ServerApi, ThePlainPagesShowAJobAndLetNoScriptIn) {
  const Answer made = submit(part("reference", "", "\"><script>alert(1)</script>"));
  ASSERT_EQ(made.status, 202) << made.body;
  const std::string id = json::parse(made.body)["id"];
  const Answer list = ask("GET", "/jobs"), job = ask("GET", "/jobs/" + id);
  EXPECT_EQ(list.header("Content-Type"), "text/html; charset=utf-8");
  EXPECT_EQ(list.body.find("<script"), std::string::npos);
  EXPECT_NE(list.body.find("<a href=\"/jobs/" + id + "\">"), std::string::npos);
  EXPECT_NE(list.body.find("<a href=\"/api/v1/openapi.yaml\">description of the API</a>"), std::string::npos);
  EXPECT_NE(list.header("Content-Security-Policy").find("script-src 'none';"), std::string::npos);
  EXPECT_EQ(job.body.find("<script>alert"), std::string::npos);
  for (const Answer* page : {&list, &job})
    EXPECT_NE(page->body.find("&quot;&gt;&lt;script&gt;"), std::string::npos) << page->body;
  EXPECT_NE(job.body.find("<noscript><meta http-equiv=\"refresh\" content=\"2\">"), std::string::npos);
  EXPECT_NE(job.body.find("data-events=\"/api/v1/jobs/" + id + "/events\""), std::string::npos);
  EXPECT_NE(job.header("Content-Security-Policy").find("script-src 'self';"), std::string::npos);
  EXPECT_EQ(ask("GET", "/job.js").header("Content-Type"), "text/javascript; charset=utf-8");
  EXPECT_NE(job.header("Content-Security-Policy").find("frame-ancestors 'none'"), std::string::npos);
  EXPECT_EQ(submit("", "/jobs").status, 405);
}

TEST_F(ServerApi, MeasuredTemperaturesReachTheWorker) {
  const Answer made =
      submit(part("temperature", "camera.CSV", "140,141") + part("heat.source", "", "uniform"));
  ASSERT_EQ(made.status, 202) << made.body;
  const json job = json::parse(made.body);
  EXPECT_EQ(job["settings"]["heat"]["source"], "measured");
  EXPECT_EQ(job["inputs"]["temperature"]["bytes"], 7);
  EXPECT_EQ(job["inputs"]["temperature"]["extension"], "csv");
  const json held = lease();
  EXPECT_EQ(held["inputs"], job["inputs"]);
  EXPECT_EQ(worker("GET", held, "/inputs/temperature", "").body, "140,141");
  EXPECT_NE(
      ask("GET", "/jobs/" + job["id"].get<std::string>()).body.find("<dt>Temperature, where measured</dt>"),
      std::string::npos);

  // A browser sends a file that nobody chose as an empty one.
  const Answer without = submit(part("temperature", "", ""));
  ASSERT_EQ(without.status, 202) << without.body;
  EXPECT_FALSE(json::parse(without.body)["inputs"].contains("temperature"));
  EXPECT_EQ(worker("GET", lease(), "/inputs/temperature", "").status, 404);

  const Answer missing = submit(part("heat.source", "", "measured"));
  EXPECT_EQ(missing.status, 422);
  EXPECT_EQ(json::parse(missing.body)["where"], "heat.source");
  const std::string heated = R"({"machine":{"heaters":[{"celsius":500}]},"heat":{"source":"heaters"}})";
  EXPECT_EQ(submit(part("settings", "", heated)).status, 202);
  const Answer both = submit(part("settings", "", heated) + part("temperature", "a.csv", "140"));
  EXPECT_EQ(both.status, 422);
  EXPECT_EQ(json::parse(both.body)["where"], "heat.source");
  // Painted weights likewise.
  const Answer painted = submit(part("weights", "w.PNG", "paint"));
  ASSERT_EQ(painted.status, 202) << painted.body;
  EXPECT_EQ(json::parse(painted.body)["settings"]["flattening"]["weights"], "painted");
  EXPECT_EQ(json::parse(painted.body)["inputs"]["weights"]["extension"], "png");
  EXPECT_EQ(json::parse(submit(part("flattening.weights", "", "painted")).body)["where"],
            "flattening.weights");
  EXPECT_EQ(submit(part("flattening.weights", "", "ink") + part("weights", "w.png", "paint")).status, 422);
  // Lists and objects as a field of the form carries them.
  const Answer fields =
      submit(part("machine.heaters", "", R"([{"celsius":500,"zone":"a"},{"celsius":400,"x_mm":200}])") +
             part("heat.gains", "", R"({"a":0.9,"":1})"));
  EXPECT_EQ(fields.status, 202) << fields.body;
}

TEST_F(ServerApi, AJobsLogIsReadWhileItGrows) {
  const std::string id = created();
  const auto log = [&](const std::string& query) {
    return json::parse(ask("GET", "/api/v1/jobs/" + id + "/log" + query).body);
  };
  const json held = lease();
  EXPECT_EQ(worker("POST", held, "/log", R"({"first":0,"lines":["stage scan","stage forming"]})").status,
            200);
  EXPECT_EQ(worker("POST", held, "/log", R"({"lines":["no number"]})").status, 400);
  const json first = log("?limit=3");
  ASSERT_EQ(first["lines"].size(), 3u);
  EXPECT_EQ(first["lines"][0]["text"], "queued");
  EXPECT_EQ(first["lines"][2]["text"], "stage scan");
  EXPECT_EQ(first["next"], 3);
  EXPECT_EQ(first["ended"], false);
  put_artifacts({held["job"], held["lease"]});
  EXPECT_EQ(worker("POST", held, "/complete").status, 200);
  const json rest = log("?after=3");
  EXPECT_EQ(rest["lines"].back()["text"], "succeeded");
  EXPECT_EQ(rest["lines"].back()["number"], 5);
  EXPECT_EQ(rest["ended"], true);
  EXPECT_EQ(log("?after=-1")["where"], "after");
  EXPECT_EQ(ask("GET", "/api/v1/jobs/" + id + "/log", bearer(token("other", {Scope::read}))).status, 404);
}

TEST_F(ServerApi, AJobBeginsWithAnother) {
  const json first =
      json::parse(submit(part("settings", "", R"({"print":{"dpi":150},"sheet":{"material":"pc"}})") +
                         part("temperature", "a.csv", "140"))
                      .body);
  const std::string id = first["id"];
  const auto derive = [&](const std::string& body, const std::string& headers = "") {
    return ask("POST", "/api/v1/jobs", "Content-Type: application/json\r\n" + headers, body);
  };
  const Answer moved =
      derive(json{{"from", id}, {"settings", {{"pattern", {{"offset_mm", {3, 4}}}}}}}.dump());
  ASSERT_EQ(moved.status, 202) << moved.body;
  const json second = json::parse(moved.body);
  EXPECT_EQ(second["inputs"], first["inputs"]);
  EXPECT_EQ(second["derived_from"], id);
  EXPECT_EQ(second["settings"]["pattern"]["offset_mm"], (json{3, 4}));
  EXPECT_EQ(second["settings"]["print"]["dpi"], 150);
  EXPECT_EQ(second["settings"]["heat"]["source"], "measured");

  const std::string page = ask("GET", "/jobs/" + second["id"].get<std::string>()).body;
  EXPECT_NE(page.find("<a href=\"/jobs/" + id + "\">"), std::string::npos);
  EXPECT_NE(page.find("</time> queued</li>"), std::string::npos);

  // A file that is sent replaces that of the other job; one that the settings no longer ask for is left out.
  const json drawn = json::parse(ask("POST", "/api/v1/jobs", form_type,
                                     part("from", "", id) + part("pattern", "q.PNG", "new") +
                                         part("heat.source", "", "uniform") + "--XX--\r\n")
                                     .body);
  EXPECT_EQ(drawn["inputs"]["scan"], first["inputs"]["scan"]);
  EXPECT_EQ(drawn["inputs"]["pattern"]["extension"], "png");
  EXPECT_FALSE(drawn["inputs"].contains("temperature"));
  EXPECT_EQ(drawn["settings"]["sheet"]["material"], "pc");

  EXPECT_EQ(derive(R"({"from":"nobody"})").status, 404);
  EXPECT_EQ(derive(json{{"from", id}}.dump(), bearer(token("other", {Scope::submit}))).status, 404);
  EXPECT_EQ(derive(json{{"from", id}}.dump(), bearer(admin_)).status, 202);
  EXPECT_EQ(derive(json{{"from", id}, {"scans", "x"}}.dump()).status, 400);
  EXPECT_EQ(derive(json{{"from", id}, {"settings", {{"print", {{"dpi", 1}}}}}}.dump()).status, 422);
  EXPECT_EQ(derive("[]").status, 400);
  EXPECT_EQ(derive("{}").status, 400);  // no files
}

TEST_F(ServerApi, OnlyAdministratorsRaiseAJob) {
  const std::string low = json::parse(submit(part("priority", "", "-3")).body)["id"];
  EXPECT_EQ(show(low)["priority"], -3);
  EXPECT_EQ(submit(part("priority", "", "1")).status, 403);
  EXPECT_EQ(submit(part("priority", "", "high")).status, 400);
  EXPECT_EQ(submit(part("priority", "", "-11")).status, 400);
  const Answer raised = ask("POST", "/api/v1/jobs", bearer(admin_) + "Content-Type: application/json\r\n",
                            json{{"from", low}, {"priority", 10}}.dump());
  ASSERT_EQ(raised.status, 202) << raised.body;
  EXPECT_EQ(lease()["job"], json::parse(raised.body)["id"]);
}

TEST_F(ServerApi, ABackupNeedsAnEmptyFolderOfTheServersOwn) {
  const auto backup = [&](const std::string& body) {
    return ask("POST", "/api/v1/backup", bearer(admin_) + "Content-Type: application/json\r\n", body);
  };
  created();
  const std::filesystem::path to = data_ / "copy";
  EXPECT_EQ(backup(json{{"to", to}}.dump()).status, 400);
  EXPECT_EQ(backup("{}").status, 400);
  std::filesystem::create_directory(to);
  std::filesystem::permissions(to, std::filesystem::perms::owner_all);
  const Answer made = backup(json{{"to", to}}.dump());
  ASSERT_EQ(made.status, 200) << made.body;
  EXPECT_EQ(json::parse(made.body), (json{{"jobs", 1}, {"files", 2}, {"damaged", json::array()}}));
  EXPECT_EQ((*open_store(to))->list(10, "")->jobs.size(), 1u);
}

TEST_F(ServerApi, FilesInTheDataFolderHaveNoOrphans) {
  const auto orphans = [&](const std::string& body) {
    return ask("POST", "/api/v1/orphans", bearer(admin_) + "Content-Type: application/json\r\n", body);
  };
  const Answer none = orphans("{}");
  EXPECT_EQ(none.status, 400) << none.body;
  EXPECT_TRUE(json::parse(none.body)["what"].get<std::string>().starts_with("there is no bucket"));
  for (const char* wrong :
       {R"({"delete": "yes"})", R"({"older_than_hours": -1})", R"({"most_percent": 101})"})
    EXPECT_NE(json::parse(orphans(wrong).body)["where"], "") << wrong;
}

TEST_F(ServerApi, AdministratorsSeeTheStateOfTheService) {
  EXPECT_EQ(ask("GET", "/api/v1/service").status, 403);
  const auto service = [&] { return json::parse(ask("GET", "/api/v1/service", bearer(admin_)).body); };
  const json empty = service();
  EXPECT_EQ(empty["version"], VACUFORM_VERSION);
  EXPECT_GE(empty["uptime_seconds"], 0);
  EXPECT_LT(empty["uptime_seconds"], 600);
  EXPECT_EQ(empty["schema"], 1);
  EXPECT_EQ(empty["queue"], (json{{"length", 0}, {"oldest_seconds", nullptr}}));
  EXPECT_EQ(empty["workers"], json::array());
  EXPECT_EQ(empty["last_backup"], nullptr);
  EXPECT_GT(empty["disk"]["total_bytes"], empty["disk"]["kept_free_bytes"]);

  const std::string id = created();
  created();
  EXPECT_EQ(
      ask("POST", "/api/v1/leases", worker_headers(), R"({"worker":"w1","protocol":2,"sandbox":["seccomp"]})")
          .status,
      200);
  const auto held = store_->lease("w0");  // by a worker that has not asked this server
  ASSERT_TRUE(held && *held);
  const json busy = service();
  EXPECT_EQ(busy["jobs"]["running"], 2);
  EXPECT_EQ(busy["jobs"]["queued"], 0);
  ASSERT_EQ(busy["workers"].size(), 2u);
  EXPECT_EQ(busy["workers"][0]["worker"], "w0");
  EXPECT_EQ(busy["workers"][0]["job"], (*held)->job.id);
  EXPECT_EQ(busy["workers"][0]["sandbox"], nullptr);
  EXPECT_EQ(busy["workers"][1]["job"], id);
  EXPECT_EQ(busy["workers"][1]["sandbox"], json{"seccomp"});
  EXPECT_EQ(busy["workers"][1]["lacks"], (json{"namespaces", "landlock"}));
  EXPECT_TRUE(from_rfc3339(busy["workers"][1]["last_seen"].get<std::string>()));
}

TEST_F(ServerApi, TheQueueIsCountedForAReaderOfNoJobs) {
  const std::string scaler = bearer(token("scaler", {Scope::read}));
  const auto queue = [&] { return json::parse(ask("GET", "/api/v1/queue", scaler).body); };
  EXPECT_EQ(queue(),
            (json{{"queued", 0}, {"running", 0}, {"oldest_seconds", nullptr}, {"wanted_workers", 0}}));
  for (int i = 0; i < 3; ++i) created();
  ASSERT_TRUE(store_->lease("w0"));
  const json busy = queue();
  EXPECT_EQ(busy["queued"], 2);
  EXPECT_EQ(busy["running"], 1);
  EXPECT_EQ(busy["wanted_workers"], 3);
  EXPECT_GE(busy["oldest_seconds"], 0);
  EXPECT_EQ(ask("GET", "/api/v1/queue", worker_headers()).status, 403);
}

TEST_F(ServerApi, ServesItsDescriptionAndEveryProblemPage) {
  EXPECT_TRUE(ask("GET", "/api/v1/openapi.yaml").body.starts_with("openapi: 3.1.0\n"));
  EXPECT_EQ(ask("GET", "/style.css").header("Content-Type"), "text/css; charset=utf-8");
  for (int i = 0; i <= static_cast<int>(Code::internal); ++i)
    EXPECT_EQ(ask("GET", "/problems/" + std::string(meaning(static_cast<Code>(i)).slug)).status, 200);
  EXPECT_EQ(ask("GET", "/problems/none").status, 404);
  EXPECT_EQ(ask("GET", "/nowhere", "Accept: text/html\r\n").header("Content-Type"),
            "text/html; charset=utf-8");
}

// The addresses of the built-in files that a page names.
std::vector<std::string> app_files_of(const std::string& page) {
  std::vector<std::string> files;
  for (std::size_t at = 0; (at = page.find("/app/", at)) != std::string::npos;) {
    const std::size_t end = page.find('"', at);
    files.push_back(page.substr(at, end - at));
    at = end;
  }
  return files;
}

TEST_F(ServerApi, TheApplicationLoadsFilesOfThisServerAlone) {
  const Answer page = ask("GET", "/");
  ASSERT_EQ(page.status, 200) << page.body;
  EXPECT_EQ(page.header("Cache-Control"), "no-store");
  const std::string policy = page.header("Content-Security-Policy");
  for (const char* rule : {"default-src 'none'", "script-src 'self';", "style-src 'self';",
                           "frame-ancestors 'none'", "require-trusted-types-for 'script'"})
    EXPECT_NE(policy.find(rule), std::string::npos) << rule << " in " << policy;
  EXPECT_EQ(policy.find("unsafe"), std::string::npos) << policy;
  const auto files = app_files_of(page.body);
  EXPECT_EQ(files.size(), 3u);  // the program, its worker, the style
  for (const auto& file : files) {
    const Answer plain = ask("GET", file), packed = ask("GET", file, "Accept-Encoding: br, gzip;q=0.5\r\n"),
                 refused = ask("GET", file, "Accept-Encoding: gzip;q=0\r\n");
    EXPECT_EQ(plain.status, 200) << file;
    EXPECT_EQ(plain.header("Cache-Control"), "public, max-age=31536000, immutable");
    EXPECT_EQ(plain.header("Content-Encoding"), "");
    EXPECT_EQ(packed.header("Content-Encoding"), "gzip");
    EXPECT_TRUE(packed.body.starts_with("\x1f\x8b")) << file;
    EXPECT_EQ(refused.body, plain.body);
  }
  EXPECT_EQ(ask("GET", "/app/none.js").status, 404);
  EXPECT_EQ(ask("GET", "/sample/head.stl").header("Content-Type"), "model/stl");
  EXPECT_NE(ask("GET", "/sample/pattern.svg").body.find("<svg"), std::string::npos);
}

// The choices of an enumeration among the schemas of api/openapi.yaml.
std::set<std::string> described(const std::string& schema) {
  std::istringstream text{std::string(asset("openapi.yaml"))};
  std::set<std::string> choices;
  bool schemas = false, inside = false;
  for (std::string line; std::getline(text, line);) {
    if (line == "  schemas:") schemas = true;
    if (line.starts_with("    ") && line[4] != ' ') inside = schemas && line == "    " + schema + ":";
    if (inside && line.starts_with("        - ")) choices.insert(line.substr(10));
  }
  return choices;
}

TEST_F(ServerApi, TheDescriptionNamesEveryRouteAndNoOther) {
  std::set<std::string> real, written;
  const http::Router router = all_routes(*service_);
  for (const auto& route : router.routes())
    if (route.pattern.starts_with("/api/") || route.pattern == "/healthz")
      real.insert(route.method + " " + route.pattern);
  std::istringstream text{std::string(asset("openapi.yaml"))};
  std::string path;
  for (std::string line; std::getline(text, line) && line != "components:";) {
    if (line.starts_with("  /")) path = line.substr(2, line.size() - 3);
    for (const auto& [word, method] :
         {std::pair{"    get:", "GET"}, std::pair{"    post:", "POST"}, std::pair{"    put:", "PUT"},
          std::pair{"    delete:", "DELETE"}, std::pair{"    patch:", "PATCH"},
          std::pair{"    options:", "OPTIONS"}})
      if (line == word) written.insert(std::string(method) + " " + path);
  }
  EXPECT_EQ(written, real);
}

TEST(Description, NamesEveryArtifactAndEveryProblem) {
  std::set<std::string> names, slugs;
  for (const auto& kind : artifact_kinds) names.insert(std::string(kind.name));
  for (int i = 0; i <= static_cast<int>(Code::internal); ++i)
    slugs.insert(std::string(meaning(static_cast<Code>(i)).slug));
  EXPECT_EQ(described("ArtifactName"), names);
  EXPECT_EQ(described("ProblemSlug"), slugs);
}

TEST(Pages, AnHostileReportIsShownAsText) {
  Job job;
  job.id = "x";
  job.state = JobState::succeeded;
  job.settings = "{}";
  const json marks = {{{"place_mm", {1.25, "<b>", 3}}, {"size_mm", 4.5}}, 7, {{"place_mm", {1}}}};
  const json report = {{"warnings",
                        {{{"what", "<img src=x onerror=alert(1)>"},
                          {"severity", "<b>"},
                          {"place", "<b>"},
                          {"fix", "<b>"},
                          {"marks", marks}},
                         7,
                         nullptr}},
                       {"figures", {{"with", {{"shape", {{"mean", "</td>"}}}}}}}};
  const std::string html = job_page(job, report).main;
  EXPECT_EQ(html.find("<img src=x"), std::string::npos);
  EXPECT_NE(html.find("&lt;img src=x onerror=alert(1)&gt;"), std::string::npos);
  EXPECT_EQ(html.find("<b>"), std::string::npos);
  EXPECT_EQ(job_page(job, json::array({1, 2})).main.find("Figures"), std::string::npos);
}

TEST(Pages, AWarningListsItsPlaces) {
  Job job;
  job.id = "x";
  job.state = JobState::succeeded;
  job.settings = "{}";
  const json mark = {{"place_mm", {1.26, -2.0, 30.0}}, {"size_mm", 4.5}};
  const json report = {{"warnings",
                        {{{"what", "Thin."},
                          {"severity", "serious"},
                          {"place", "the top"},
                          {"fix", "Use a thicker sheet."},
                          {"marks", json::array({mark})}},
                         {{"what", "Guessed."}, {"marks", json::array()}}}}};
  const std::string html = job_page(job, report).main;
  EXPECT_NE(html.find("<li class=\"serious\"><strong>serious</strong> Thin.<br>Where: the top.<br>Fix: Use a "
                      "thicker sheet.<details>"),
            std::string::npos)
      << html;
  EXPECT_NE(html.find("<th scope=\"row\">1</th><td class=\"number\">1.3</td><td class=\"number\">-2.0</td>"
                      "<td class=\"number\">30.0</td><td class=\"number\">4.5</td>"),
            std::string::npos)
      << html;
  EXPECT_NE(html.find("<li class=\"warning\"><strong>warning</strong> Guessed.</li>"), std::string::npos);
}

TEST(Pages, SayHowManyCoilsAndHowMuchInkLieOnTheHead) {
  Job job;
  job.id = "x";
  job.state = JobState::succeeded;
  job.settings = "{}";
  const json report = {{"pattern", {{"ink_on_head", 0.412}}},
                       {"coils", json::array({1, 2, 3})},
                       {"figures", {{"with", {{"coils", {{"on_head", 2}}}}}}}};
  EXPECT_NE(job_page(job, report).main.find("2 of 3 coils and 41.2 % of the drawing's ink lie on the head."),
            std::string::npos);
}

TEST(Pages, ListWhatWasLeftOutOfTheScan) {
  Job job;
  job.id = "x";
  job.state = JobState::succeeded;
  job.settings = "{}";
  json made = {{"scan",
                {{"format", "STL"},
                 {"front", "+x"},
                 {"front_assumed", false},
                 {"left_side", "plus_x"},
                 {"mirrored", true},
                 {"outliers_dropped", 2},
                 {"crumbs_dropped", 3}}}};
  const std::string left_out =
      "<dt>Left out</dt><dd>2 outliers, 3 crumbs that the trim left beside the mold</dd>";
  for (const JobKind kind : {JobKind::print, JobKind::inspection}) {
    job.kind = kind;
    const std::string html = job_page(job, made).main;
    EXPECT_NE(html.find(left_out), std::string::npos) << html;
    EXPECT_NE(html.find("<dt>Face</dt><dd>+x, mirrored</dd>"), std::string::npos) << html;
    EXPECT_NE(html.find("left</dt><dd>+x, confirmed by a person</dd>"), std::string::npos) << html;
    EXPECT_EQ(html.find("Fits the machine"), std::string::npos);
  }
  made["scan"]["front_from_format"] = true;
  EXPECT_NE(job_page(job, made).main.find("<dt>Face</dt><dd>+x (as the format defines), mirrored</dd>"),
            std::string::npos);
  made["fits"] = true;
  EXPECT_NE(job_page(job, made).main.find("<dt>Fits the machine</dt><dd>yes</dd>"), std::string::npos);
}

TEST(Pages, ShowTheCoilsOfALayoutAndOfferItsPrint) {
  Job job;
  job.id = "x";
  job.kind = JobKind::layout;
  job.state = JobState::succeeded;
  job.settings = "{}";
  const json made = {{"count", 9},
                     {"diameter_mm", 40.0},
                     {"spacing_mm", 30.17},
                     {"spacing_rms_mm", 0.5},
                     {"pairs", 16},
                     {"off_head", 1},
                     {"strongest_neighbours", {{"a", "coil-1"}, {"b", "coil-2"}, {"k", -0.0012}}},
                     {"strongest", nullptr}};
  const std::string html = job_page(job, made).main;
  for (const char* shown : {"<h1>Layout ", "<dd>9, 1 of them not wholly on the head</dd>", "<dd>40.0 mm</dd>",
                            "<dd>30.17 mm, 0.50 mm rms over 16 pairs</dd>",
                            "<dd>coil-1 and coil-2, k = -0.0012</dd>", "<dd>- and -, k = -</dd>"})
    EXPECT_NE(html.find(shown), std::string::npos) << shown << "\n" << html;
  EXPECT_EQ(job_page(job, json()).main.find("The coils"), std::string::npos);
  EXPECT_NE(list_page({job}).main.find("</a>, layout</td>"), std::string::npos);
}

TEST(Pages, SayInTheStateThatThereAreSeriousWarnings) {
  Job job;
  job.id = "x";
  job.state = JobState::succeeded;
  job.settings = "{}";
  job.serious_warnings = 2;
  EXPECT_NE(job_page(job, json())
                .main.find("succeeded</span> <span class=\"state serious\">with 2 serious "
                           "warnings</span></h1>"),
            std::string::npos);
  EXPECT_NE(list_page({job}).main.find("with 2 serious warnings"), std::string::npos);
  job.serious_warnings = 0;
  EXPECT_EQ(job_page(job, json()).main.find("serious"), std::string::npos);
}

}  // namespace
}  // namespace vacuform
