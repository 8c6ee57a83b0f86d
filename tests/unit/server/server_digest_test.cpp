// Digests (RFC 9530) and conditions (RFC 9110) on what is uploaded and downloaded. The base 64 digests were made by
// `printf TEXT | openssl dgst -sha256 -binary | base64`.
#include "server/messages/digest.hpp"

#include <nlohmann/json.hpp>

#include "server_fixture.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

// Of "solid" and of nothing.
constexpr const char* solid = "sha-256=:Sz1KDdcy95HKiX6VSItdY8rxKNhpG29bvFT4Zrm5cFQ=:";
constexpr const char* nothing = "sha-256=:47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU=:";

Result<std::string> stated(std::vector<http::Header> headers) {
  http::Request request;
  request.headers = std::move(headers);
  return http::stated_digest(request, "Content-Digest");
}

TEST(Digest, IsWrittenAndReadAsTheStandardSays) {
  EXPECT_EQ(http::digest_field(text_hash("")), nothing);
  EXPECT_EQ(http::digest_field(text_hash("solid")), solid);
  EXPECT_EQ(stated({{"content-digest", nothing}}), text_hash(""));
  EXPECT_EQ(stated({{"Content-Digest", std::string("sha-512=:AAAA:, ") + solid + ";q=1"}}),
            text_hash("solid"));
  EXPECT_EQ(stated({{"Content-Digest", "md5=:AAAA:"}, {"Content-Digest", solid}}), text_hash("solid"));
  EXPECT_EQ(stated({{"Content-Digest", std::string(solid) + "," + nothing}}), text_hash(""));
}

TEST(Digest, IgnoresOtherAlgorithmsAndRefusesAMalformedOne) {
  EXPECT_EQ(stated({}), "");
  EXPECT_EQ(stated({{"Content-Digest", "sha-512=:AAAA:"}, {"Repr-Digest", solid}}), "");
  const std::string digits = std::string(solid).substr(9, 44);
  for (const std::string& wrong :
       {std::string("sha-256"), std::string("sha-256="), "sha-256=" + digits, "sha-256=:" + digits,
        "sha-256=:" + digits + ":x", "sha-256=:" + digits + "AAAA:", "sha-256=:" + digits.substr(0, 43) + ":",
        std::string("sha-256=::"), "sha-256=:" + text_hash("solid") + ":"}) {
    const auto digest = stated({{"Content-Digest", wrong}});
    ASSERT_FALSE(digest) << wrong;
    EXPECT_EQ(digest.error().code, Code::bad_usage);
  }
}

class ServerDigest : public ServerTest {
 protected:
  static std::string form() {
    return part("scan", "a.stl", "solid") + part("pattern", "p.svg", "<svg/>") + "--XX--\r\n";
  }
  Answer send(const std::string& digest) {
    return ask("POST", "/api/v1/jobs", form_type + ("Content-Digest: " + digest + "\r\n"), form());
  }
  // The path of an artifact with these bytes.
  std::string artifact(const std::string& bytes) {
    EXPECT_EQ(submit().status, 202);
    const json held = json::parse(ask("POST", "/api/v1/leases", worker_headers(), R"({"protocol":2})").body);
    const std::string id = held["job"], headers = worker_headers(held["lease"].get<std::string>());
    EXPECT_EQ(ask("PUT", "/api/v1/leases/" + id + "/artifacts/mold.stl",
                  headers + "Content-Digest: " + nothing + "\r\n", bytes)
                  .status,
              400);
    EXPECT_EQ(ask("PUT", "/api/v1/leases/" + id + "/artifacts/mold.stl",
                  headers + "Content-Digest: " + http::digest_field(text_hash(bytes)) + "\r\n", bytes)
                  .status,
              200);
    finish({id, held["lease"]}, {"mold.stl"});
    return "/api/v1/jobs/" + id + "/artifacts/mold.stl";
  }
};

TEST_F(ServerDigest, AFormThatIsNotTheOneSentMakesNoJob) {
  const Answer wrong = send(solid);
  EXPECT_EQ(wrong.status, 400);
  EXPECT_EQ(json::parse(wrong.body)["type"], "/problems/wrong-digest");
  EXPECT_EQ(json::parse(wrong.body)["where"], "request body");
  EXPECT_EQ(send("sha-256=:nonsense:").status, 400);
  EXPECT_TRUE(json::parse(ask("GET", "/api/v1/jobs").body)["jobs"].empty());
  EXPECT_TRUE(std::filesystem::is_empty(data_ / "incoming"));
  EXPECT_EQ(send(http::digest_field(text_hash(form()))).status, 202);
  EXPECT_EQ(send("sha-512=:nonsense:").status, 202);
}

TEST_F(ServerDigest, ArtifactsSayTheirs) {
  const std::string path = artifact("0123456789"), whole = http::digest_field(text_hash("0123456789"));
  const Answer all = ask("GET", path);
  EXPECT_EQ(all.header("Repr-Digest"), whole);
  EXPECT_EQ(all.header("Content-Digest"), whole);
  const Answer part = ask("GET", path, "Range: bytes=2-4\r\n");
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.header("Repr-Digest"), whole);
  EXPECT_EQ(part.header("Content-Digest"), http::digest_field(text_hash("234")));
  const Answer head = ask("HEAD", path);
  EXPECT_EQ(head.header("Repr-Digest"), whole);
  EXPECT_EQ(head.header("Content-Digest"), "");
  const Answer beyond = ask("GET", path, "Range: bytes=10-\r\n");
  EXPECT_EQ(beyond.status, 416);
  EXPECT_EQ(beyond.header("Content-Digest"), "");
}

TEST_F(ServerDigest, ConditionsOnAnArtifact) {
  const std::string path = artifact("0123456789"),
                    tag = std::string("\"").append(text_hash("0123456789")).append("\"");
  const auto status = [&](const std::string& headers, const std::string& method = "GET") {
    return ask(method, path, headers).status;
  };
  EXPECT_EQ(status("If-None-Match: \"a\", W/" + tag + "\r\n"), 304);  // weak comparison
  EXPECT_EQ(status("If-None-Match: *\r\n"), 304);
  EXPECT_EQ(status("If-None-Match: \"a\"\r\n"), 200);
  EXPECT_EQ(status("If-None-Match: " + tag + "\r\n", "HEAD"), 304);
  EXPECT_EQ(status("If-None-Match: " + tag + "\r\nRange: bytes=0-1\r\n"), 304);  // goes before the range
  EXPECT_EQ(status("Range: bytes=0-1\r\nIf-Range: " + tag + "\r\n"), 206);
  EXPECT_EQ(status("Range: bytes=0-1\r\nIf-Range: W/" + tag + "\r\n"), 200);  // strong comparison
  EXPECT_EQ(status("Range: bytes=0-1\r\nIf-Range: Sat, 21 Nov 2026 00:00:00 GMT\r\n"), 200);
  EXPECT_EQ(status("Range: bytes=20-\r\nIf-Range: \"old\"\r\n"), 200);
  EXPECT_EQ(ask("GET", path, "If-None-Match: " + tag + "\r\n").header("ETag"), tag);
}

}  // namespace
}  // namespace vacuform
