// Resumable uploads (tus 1.0.0) and their uses: scans and inputs of jobs; profiles.
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "server/messages/digest.hpp"
#include "server_fixture.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

const std::string tus = "Tus-Resumable: 1.0.0\r\n";
const std::string piece = tus + "Content-Type: application/offset+octet-stream\r\n";

class ServerUpload : public ServerTest {
 protected:
  Answer begin(std::size_t length, const std::string& more = "Upload-Metadata: filename YS5zdGw=\r\n",
               const std::string& body = "") {
    return ask("POST", "/api/v1/uploads", tus + "Upload-Length: " + std::to_string(length) + "\r\n" + more,
               body);
  }
  std::string new_upload(std::size_t length) {
    const Answer answer = begin(length);
    EXPECT_EQ(answer.status, 201) << answer.body;
    return answer.header("Location");
  }
  Answer send(const std::string& place, std::size_t offset, const std::string& bytes,
              const std::string& more = "") {
    return ask("PATCH", place, piece + "Upload-Offset: " + std::to_string(offset) + "\r\n" + more, bytes);
  }
  std::string offset(const std::string& place) { return ask("HEAD", place, tus).header("Upload-Offset"); }
  static std::string id_of(const std::string& place) { return place.substr(place.rfind('/') + 1); }
  Answer submit_with(const std::string& parts, const std::string& path = "/api/v1/jobs") {
    return ask("POST", path, form_type, parts + part("pattern", "p.svg", "<svg/>") + "--XX--\r\n");
  }
};

TEST_F(ServerUpload, FromItsBeginningToAJob) {
  const std::string place = new_upload(10);
  const Answer head = ask("HEAD", place, tus);
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.header("Upload-Offset"), "0");
  EXPECT_EQ(head.header("Upload-Length"), "10");
  EXPECT_EQ(head.header("Tus-Resumable"), "1.0.0");
  EXPECT_EQ(head.header("Cache-Control"), "no-store");
  EXPECT_TRUE(head.header("Upload-Expires").ends_with(" GMT")) << head.head;
  EXPECT_EQ(send(place, 0, "solid").header("Upload-Offset"), "5");
  EXPECT_EQ(offset(place), "5");
  const Answer early = submit_with(part("scan_upload", "", id_of(place)));
  EXPECT_EQ(early.status, 409) << early.body;
  const Answer last = send(place, 5, " Jane");
  EXPECT_EQ(last.status, 204);
  EXPECT_EQ(last.header("Upload-Offset"), "10");
  const json upload = json::parse(ask("GET", place).body);
  EXPECT_EQ(upload["offset"], 10);
  EXPECT_EQ(upload["sha256"], text_hash("solid     "));  // the name is replaced by spaces
  EXPECT_TRUE(std::filesystem::is_empty(data_ / "uploads"));
  for (int i = 0; i < 2; ++i) {
    const Answer made = submit_with(part("scan_upload", "", id_of(place)));
    ASSERT_EQ(made.status, 202) << made.body;
    const json scan = json::parse(made.body)["inputs"]["scan"];
    EXPECT_EQ(scan["sha256"], upload["sha256"]);
    EXPECT_EQ(scan["extension"], "stl");
  }
  EXPECT_EQ(submit_with(part("pattern_upload", "", id_of(place))).status, 400);  // it is a scan
  EXPECT_EQ(submit_with(part("scan_upload", "", id_of(place)) + part("scan", "a.stl", "x")).status, 400);
  EXPECT_EQ(submit_with(part("scan_upload", "", "none")).status, 404);
}

TEST_F(ServerUpload, SaysWhatItSpeaks) {
  const Answer options = ask("OPTIONS", "/api/v1/uploads", anonymous);
  EXPECT_EQ(options.status, 204);
  EXPECT_EQ(options.header("Tus-Version"), "1.0.0");
  EXPECT_EQ(options.header("Tus-Extension"), "creation,creation-with-upload,checksum,expiration,termination");
  EXPECT_EQ(options.header("Tus-Max-Size"), "1073741824");
  EXPECT_EQ(options.header("Tus-Checksum-Algorithm"), "sha1,sha256");
  const Answer other = ask("POST", "/api/v1/uploads", "Tus-Resumable: 0.2.2\r\nUpload-Length: 5\r\n");
  EXPECT_EQ(other.status, 412);
  EXPECT_EQ(other.header("Tus-Version"), "1.0.0");
}

TEST_F(ServerUpload, RefusesWhatItCannotTake) {
  EXPECT_EQ(begin(0).status, 400);
  EXPECT_EQ(begin((1u << 30) + 1).status, 413);
  EXPECT_EQ(ask("POST", "/api/v1/uploads", tus + "Upload-Defer-Length: 1\r\n").status, 400);
  EXPECT_EQ(ask("POST", "/api/v1/uploads", tus + "Upload-Length: 9\r\nUpload-Concat: partial\r\n").status,
            400);
  EXPECT_EQ(begin(5, "Upload-Metadata: input !!!\r\n").status, 400);
  EXPECT_EQ(begin(5, "Upload-Metadata: input c2V0dGluZ3M=\r\n").status, 400);  // settings
  const std::string place = new_upload(5);
  EXPECT_EQ(send(place, 1, "a").status, 409);
  EXPECT_EQ(send(place, 0, "123456").status, 413);
  EXPECT_EQ(ask("PATCH", place, tus + "Upload-Offset: 0\r\n", "a").status, 415);
  EXPECT_EQ(ask("PATCH", place, piece, "a").status, 400);
  EXPECT_EQ(ask("PATCH", place, "Content-Type: application/offset+octet-stream\r\nUpload-Offset: 0\r\n", "a")
                .status,
            412);
  EXPECT_EQ(offset(place), "0");
  EXPECT_EQ(send(place, 0, "12345").status, 204);
  EXPECT_EQ(send(place, 5, "6").status, 409);
}

TEST_F(ServerUpload, CreationCarriesBytes) {
  const Answer made = begin(8, "Content-Type: application/offset+octet-stream\r\n", "solid");
  EXPECT_EQ(made.status, 201);
  EXPECT_EQ(made.header("Upload-Offset"), "5");
  EXPECT_EQ(offset(made.header("Location")), "5");
}

TEST_F(ServerUpload, AWrongChecksumCountsForNothing) {
  const std::string place = new_upload(10),
                    good = "Sz1KDdcy95HKiX6VSItdY8rxKNhpG29bvFT4Zrm5cFQ=";  // of "solid"
  ASSERT_EQ(send(place, 0, "solid", "Upload-Checksum: sha256 " + good + "\r\n").status, 204);
  const Answer wrong = send(place, 5, "wrong", "Upload-Checksum: sha256 " + good + "\r\n");
  EXPECT_EQ(wrong.status, 460);
  EXPECT_EQ(json::parse(wrong.body)["type"], "/problems/wrong-digest");
  EXPECT_EQ(wrong.header("Tus-Resumable"), "1.0.0");
  EXPECT_EQ(send(place, 5, "wrong", "Content-Digest: sha-256=:" + good + ":\r\n").status, 460);
  EXPECT_EQ(send(place, 5, "a", "Upload-Checksum: md5 AAAA\r\n").status, 400);
  EXPECT_EQ(offset(place), "5");
  // sha1 of "12345", by `printf 12345 | openssl dgst -sha1 -binary | base64`
  EXPECT_EQ(send(place, 5, "12345", "Upload-Checksum: sha1 jLIjfQZ5yojbZGTqxg2pY0VROWQ=\r\n").status, 204);
  EXPECT_EQ(json::parse(ask("GET", place).body)["sha256"], text_hash("solid     "));
}

TEST_F(ServerUpload, GoesOnWhereItBrokeOffAlsoInAnotherProcess) {
  const std::string place = new_upload(1000);
  const int socket = connected();
  send_all(socket, "PATCH " + place + " HTTP/1.1\r\nHost: " + host() + "\r\n" + bearer(user_) + piece +
                       "Upload-Offset: 0\r\nContent-Length: 1000\r\n\r\n" + std::string(300, '\x01'));
  ::shutdown(socket, SHUT_WR);
  EXPECT_EQ(parsed(receive_all(socket)).status, 400);
  EXPECT_EQ(offset(place), "300");
  // Another process finds the same upload on the disk.
  const auto fresh = Uploads::open(*store_, data_ / "uploads");
  ASSERT_TRUE(fresh);
  EXPECT_EQ(*(*fresh)->offset(*store_->find_upload(id_of(place))), 300u);
  EXPECT_EQ(send(place, 300, std::string(700, '\x02')).status, 204);
  const std::string all = std::string(80, ' ') + std::string(220, '\x01') + std::string(700, '\x02');
  EXPECT_EQ(json::parse(ask("GET", place).body)["sha256"], text_hash(all));
}

TEST_F(ServerUpload, OneRequestAtATime) {
  const std::string place = new_upload(100'000);  // too long to be kept in memory until it is complete
  const int socket = connected();
  send_all(socket, "PATCH " + place + " HTTP/1.1\r\nHost: " + host() + "\r\n" + bearer(user_) + piece +
                       "Upload-Offset: 0\r\nContent-Length: 100000\r\n\r\nabc");
  ASSERT_TRUE(eventually([&] { return offset(place).empty(); }));
  const auto second = send(place, 0, "x");
  EXPECT_EQ(second.status, 423);
  EXPECT_EQ(json::parse(second.body)["type"], "/problems/locked");
  EXPECT_EQ(ask("HEAD", place, tus).status, 423);
  EXPECT_EQ(ask("DELETE", place, tus).status, 423);
  send_all(socket, std::string(99'997, 'd'));
  EXPECT_EQ(parsed(receive_one(socket)).status, 204);
  ::close(socket);
  EXPECT_EQ(offset(place), "100000");
}

TEST_F(ServerUpload, EndsByDeletionAndIsNobodyElses) {
  const std::string place = new_upload(10), other = bearer(token("station-2", {Scope::submit, Scope::read}));
  send(place, 0, "solid");
  EXPECT_EQ(ask("GET", place, other).status, 404);
  EXPECT_EQ(ask("DELETE", place, other + tus).status, 404);
  EXPECT_EQ(ask("POST", place, tus + "X-HTTP-Method-Override: DELETE\r\n").status, 204);
  EXPECT_EQ(ask("HEAD", place, tus).status, 404);
  EXPECT_TRUE(std::filesystem::is_empty(data_ / "uploads"));
  EXPECT_EQ(ask("POST", new_upload(5), tus).status, 405);
}

TEST_F(ServerUpload, AnOwnerHasSoManyAndNoMore) {
  for (int i = 0; i < most_uploads; ++i) ASSERT_EQ(begin(5).status, 201);
  const Answer refused = begin(5);
  EXPECT_EQ(refused.status, 429);
  EXPECT_EQ(json::parse(refused.body)["type"], "/problems/busy");
  EXPECT_EQ(refused.header("Retry-After"), "60");
  const std::string large = "Upload-Length: 1073741824\r\n";
  const std::string other = bearer(token("station-2", {Scope::submit})) + tus + large;
  for (int i = 0; i < 8; ++i) EXPECT_EQ(ask("POST", "/api/v1/uploads", other).status, 201);
  EXPECT_EQ(ask("POST", "/api/v1/uploads", other).status, 429);  // 8 GiB
}

TEST_F(ServerUpload, ExpiresAfterADayAndIsRememberedForAWeek) {
  Millis now = 1'000'000;
  StoreOptions options;
  options.clock = [&now] { return now; };
  const auto store = open_store(data_ / "other", options);
  ASSERT_TRUE(store);
  const auto uploads = Uploads::open(**store, data_ / "other" / "uploads", options.clock);
  ASSERT_TRUE(uploads);
  const auto upload = (*uploads)->begin("station-1", *input_kind("scan"), "stl", 5);
  ASSERT_TRUE(upload);
  std::ofstream(data_ / "other" / "uploads" / (upload->id + ".part")) << "half";
  now += upload_lifetime - 1;
  ASSERT_TRUE((*uploads)->collect());
  EXPECT_TRUE((*store)->find_upload(upload->id));
  now += 1;
  EXPECT_EQ((*store)->find_upload(upload->id).error().code, Code::gone);
  ASSERT_TRUE((*uploads)->collect());
  EXPECT_TRUE(std::filesystem::is_empty(data_ / "other" / "uploads"));
  EXPECT_EQ((*store)->find_upload(upload->id).error().code, Code::gone);
  now += 7 * upload_lifetime;
  ASSERT_TRUE((*uploads)->begin("station-1", *input_kind("scan"), "stl", 5));
  now += upload_lifetime;
  ASSERT_TRUE((*uploads)->collect());
  EXPECT_EQ((*store)->find_upload(upload->id).error().code, Code::not_found);
}

TEST_F(ServerUpload, AScanIsKeptOnceForManyJobs) {
  const std::string place = new_upload(5);
  send(place, 0, "solid");
  const auto post = [&](const std::string& parts) {
    return ask("POST", "/api/v1/scans", form_type, parts + "--XX--\r\n");
  };
  const Answer made = post(part("scan_upload", "", id_of(place)));
  ASSERT_EQ(made.status, 201) << made.body;
  const json scan = json::parse(made.body);
  const std::string at = made.header("Location"), id = scan["id"];
  EXPECT_EQ(json::parse(ask("GET", at).body), scan);
  EXPECT_EQ(json::parse(post(part("scan", "b.stl", "solid")).body)["id"], id);  // the same bytes
  EXPECT_EQ(ask("DELETE", place, tus).status, 204);                             // the scan keeps them
  EXPECT_EQ(submit_with(part("scan_id", "", id), "/api/v1/validate").status, 200);
  const Answer job = submit_with(part("scan_id", "", id));
  ASSERT_EQ(job.status, 202) << job.body;
  const std::string other = bearer(token("station-2", {Scope::submit, Scope::read}));
  EXPECT_EQ(ask("GET", at, other).status, 404);
  EXPECT_EQ(ask("DELETE", at, other).status, 404);
  EXPECT_EQ(ask("POST", "/api/v1/jobs", other + form_type,
                part("scan_id", "", id) + part("pattern", "p.svg", "<svg/>") + "--XX--\r\n")
                .status,
            404);
  EXPECT_EQ(ask("DELETE", at).status, 204);
  EXPECT_EQ(ask("GET", at).status, 404);
  const json held = json::parse(
      ask("POST", "/api/v1/leases", worker_headers(), R"({"protocol":2})").body);  // the job keeps it
  EXPECT_EQ(ask("GET", "/api/v1/leases/" + held["job"].get<std::string>() + "/inputs/scan",
                worker_headers(held["lease"].get<std::string>()))
                .body,
            "solid");
  for (const std::string& wrong :
       {part("pattern", "p.svg", "<svg/>"), part("scan", "a.stl", ""), std::string()})
    EXPECT_EQ(post(wrong).status, 400);
}

TEST_F(ServerUpload, KeepsTheFindingsOfAnInspectionWithItsScan) {
  const Answer made = ask("POST", "/api/v1/scans", form_type, part("scan", "a.stl", "solid") + "--XX--\r\n");
  const std::string at = made.header("Location"), id = json::parse(made.body)["id"];
  EXPECT_TRUE(json::parse(made.body)["inspection"].is_null());
  const auto post = [&](const std::string& parts) {
    return ask("POST", "/api/v1/jobs", form_type, parts + "--XX--\r\n");
  };
  EXPECT_EQ(post(part("scan_id", "", id) + part("kind", "", "inspect")).status, 400);
  EXPECT_EQ(post(part("scan_id", "", id)).status, 400);  // a print needs a pattern
  const Answer asked = post(part("scan_id", "", id) + part("kind", "", "inspection"));
  ASSERT_EQ(asked.status, 202) << asked.body;
  const json job = json::parse(asked.body);
  EXPECT_EQ(job["kind"], "inspection");
  json inspection = json::parse(ask("GET", at).body)["inspection"];
  EXPECT_EQ(inspection["job"], job["id"]);
  EXPECT_EQ(inspection["state"], "queued");
  EXPECT_TRUE(inspection["findings"].is_null());

  const json held = json::parse(ask("POST", "/api/v1/leases", worker_headers(), R"({"protocol":2})").body);
  EXPECT_EQ(held["kind"], "inspection");
  const std::string lease = "/api/v1/leases/" + held["job"].get<std::string>();
  const std::string key = worker_headers(held["lease"].get<std::string>());
  EXPECT_EQ(ask("PUT", lease + "/artifacts/findings.json", key, R"({"fits":true})").status, 200);
  put_artifacts({held["job"], held["lease"]}, {"findings.json"});
  EXPECT_EQ(ask("POST", lease + "/complete", key, "{}").status, 200);
  inspection = json::parse(ask("GET", at).body)["inspection"];
  EXPECT_EQ(inspection["state"], "succeeded");
  EXPECT_EQ(inspection["findings"], json::parse(R"({"fits":true})"));
  EXPECT_FALSE(json::parse(ask("GET", "/api/v1/scans").body)["scans"][0]["inspection"].contains("findings"));

  // A print from the profile has its scan; the message lists what is missing.
  const std::string from = part("from", "", job["id"].get<std::string>());
  EXPECT_EQ(post(from).status, 400);
  const Answer print = post(from + part("pattern", "p.svg", "<svg/>"));
  ASSERT_EQ(print.status, 202) << print.body;
  EXPECT_EQ(json::parse(print.body)["kind"], "print");
  EXPECT_EQ(json::parse(print.body)["inputs"]["scan"], job["inputs"]["scan"]);
}

// Findings come from a process that read an untrusted file.
TEST_F(ServerUpload, FindingsThatNobodyCanReadAreNone) {
  const Answer made = ask("POST", "/api/v1/scans", form_type, part("scan", "a.stl", "solid") + "--XX--\r\n");
  const std::string id = json::parse(made.body)["id"];
  for (const std::string& findings : {std::string("{"), std::string("7"), std::string(100'000, '['),
                                      std::string(20, '[') + std::string(20, ']')}) {
    ask("POST", "/api/v1/jobs", form_type,
        part("scan_id", "", id) + part("kind", "", "inspection") + "--XX--\r\n");
    const json held = json::parse(ask("POST", "/api/v1/leases", worker_headers(), R"({"protocol":2})").body);
    const std::string lease = "/api/v1/leases/" + held["job"].get<std::string>();
    const std::string key = worker_headers(held["lease"].get<std::string>());
    EXPECT_EQ(ask("PUT", lease + "/artifacts/findings.json", key, findings).status, 200);
    put_artifacts({held["job"], held["lease"]}, {"findings.json"});
    EXPECT_EQ(ask("POST", lease + "/complete", key, "{}").status, 200);
    const json inspection = json::parse(ask("GET", "/api/v1/scans/" + id).body)["inspection"];
    EXPECT_EQ(inspection["state"], "succeeded");
    EXPECT_TRUE(inspection["findings"].is_null()) << findings.substr(0, 10);
    EXPECT_EQ(ask("GET", "/jobs/" + held["job"].get<std::string>()).status, 200);
  }
}

TEST_F(ServerUpload, ListsInPagesAndRefusesOtherCursors) {
  for (const char* bytes : {"one", "two", "three"})
    ask("POST", "/api/v1/scans", form_type, part("scan", "a.obj", bytes) + "--XX--\r\n");
  const json first = json::parse(ask("GET", "/api/v1/scans?limit=2").body);
  ASSERT_EQ(first["scans"].size(), 2u);
  EXPECT_GT(first["scans"][0]["id"], first["scans"][1]["id"]);
  const json rest =
      json::parse(ask("GET", "/api/v1/scans?limit=2&cursor=" + first["next"].get<std::string>()).body);
  EXPECT_EQ(rest["scans"].size(), 1u);
  EXPECT_TRUE(rest["next"].is_null());
  for (const char* list : {"jobs", "scans", "profiles"}) {
    const std::string path = std::string("/api/v1/") + list;
    for (const char* cursor : {"NOPE", "%27%20OR%201", "a.b", "~"})
      EXPECT_EQ(ask("GET", path + "?cursor=" + cursor).status, 400) << list << cursor;
    EXPECT_EQ(ask("GET", path + "?limit=101").status, 400);
  }
}

TEST_F(ServerUpload, AProfileIsTheBaseOfAJobsSettings) {
  const std::string at = "/api/v1/profiles/formech-300xq", as_admin = bearer(admin_);
  const Answer made =
      ask("PUT", at, as_admin, R"({"sheet":{"width_mm":450},"machine":{"window_width_mm":430}})");
  EXPECT_EQ(made.status, 201) << made.body;
  EXPECT_EQ(
      ask("PUT", at, as_admin, R"({"sheet":{"width_mm":450},"machine":{"window_width_mm":420}})").status,
      200);
  EXPECT_EQ(ask("PUT", at, "", "{}").status, 403);
  EXPECT_EQ(ask("PUT", at, as_admin, R"({"sheet":{"width":450}})").status, 422);
  EXPECT_EQ(ask("PUT", at, as_admin, "7").status, 422);
  EXPECT_EQ(ask("PUT", "/api/v1/profiles/Jane%20Doe", as_admin, "{}").status, 400);
  EXPECT_EQ(json::parse(ask("GET", at).body)["settings"]["machine"]["window_width_mm"], 420);
  EXPECT_EQ(json::parse(ask("GET", "/api/v1/profiles").body)["profiles"].size(), 1u);
  EXPECT_EQ(json::parse(ask("GET", at).body)["default"], false);
  EXPECT_EQ(ask("PUT", at + "/default").status, 403);
  EXPECT_EQ(ask("PUT", at + "/default", as_admin).status, 204);
  EXPECT_EQ(json::parse(ask("GET", at).body)["default"], true);
  EXPECT_EQ(ask("DELETE", at + "/default", as_admin).status, 204);
  EXPECT_EQ(json::parse(ask("GET", at).body)["default"], false);
  EXPECT_EQ(ask("PUT", "/api/v1/profiles/none/default", as_admin).status, 404);
  const auto settings = [&](const std::string& more) {
    const Answer answer = submit(part("profile", "", "formech-300xq") + more);
    EXPECT_EQ(answer.status, 202) << answer.body;
    return json::parse(answer.body)["settings"];
  };
  EXPECT_EQ(settings("")["sheet"]["width_mm"], 450);
  // Settings that only fit the profile's sheet are accepted, too.
  const json changed = settings(part("settings", "", R"({"machine":{"window_width_mm":400}})") +
                                part("machine.window_height_mm", "", "250"));
  EXPECT_EQ(changed["sheet"]["width_mm"], 450);
  EXPECT_EQ(changed["machine"]["window_width_mm"], 400);
  EXPECT_EQ(changed["machine"]["window_height_mm"], 250);
  EXPECT_EQ(submit(part("profile", "", "none")).status, 404);
  EXPECT_EQ(submit(part("profile", "", "formech-300xq") + part("settings", "", "[")).status, 422);
  EXPECT_EQ(submit(part("profile", "", "formech-300xq") + part("settings", "", R"({"oven":{"x":1}})")).status,
            422);
  EXPECT_EQ(ask("DELETE", at, as_admin).status, 204);
  EXPECT_EQ(ask("GET", at).status, 404);
}

}  // namespace
}  // namespace vacuform
