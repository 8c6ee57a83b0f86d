// Bytes that change on the disk without a trace: they are noticed when a file is read whole, and at the latest after an hour.
#include "server/store/blobs/files/file_blobs.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/unit/server/server_fixture.hpp"

namespace vacuform {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

fs::path place_of(const fs::path& data, const std::string& sha256) {
  return data / "blobs" / sha256.substr(0, 2) / sha256;
}

// What a failing disk does: another byte, and the times as they were.
void rot(const fs::path& path) {
  struct stat before {};
  ASSERT_EQ(::stat(path.c_str(), &before), 0);
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(before.st_size / 2));
    file.put('#');
  }
  const std::array<timespec, 2> times{before.st_atim, before.st_mtim};
  ASSERT_EQ(::utimensat(AT_FDCWD, path.c_str(), times.data(), 0), 0);
}

class BlobsTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    data_ = fs::temp_directory_path() / ("vacuform-blobs-" + random_hex(8));
  }
  void TearDown() override { fs::remove_all(data_); }
  static std::string kept(BlobStore& blobs, const std::string& bytes) {
    auto upload = blobs.upload();
    EXPECT_TRUE(upload && upload->write(bytes) && blobs.put(*upload));
    return text_hash(bytes);
  }
  fs::path data_;
};

TEST_F(BlobsTest, AFileIsTrustedForAWhileAndThenLookedAtAgain) {
  for (const auto& [trust, found] :
       {std::pair{std::chrono::milliseconds(0), true}, {std::chrono::hours(1), false}}) {
    const auto blobs = *FileBlobs::open(data_, nullptr, trust);
    const std::string hash = kept(*blobs, "some bytes");
    EXPECT_TRUE(blobs->open(hash));
    rot(place_of(data_, hash));
    EXPECT_EQ(blobs->open(hash).has_value(), !found);
    if (const auto again = blobs->open(hash)) (*again)->invalidate();
    EXPECT_EQ(blobs->open(hash).error().code, Code::gone);
    blobs->collect(hash, [](const std::string&) { return false; });
    EXPECT_FALSE(fs::exists(place_of(data_, hash)));
  }
}

TEST_F(BlobsTest, ABackupTrustsNothing) {
  const auto blobs = *FileBlobs::open(data_);
  const std::string hash = kept(*blobs, "some bytes");
  EXPECT_TRUE(blobs->open(hash));
  rot(place_of(data_, hash));
  EXPECT_EQ(blobs->copy(hash, data_ / "copy").error().code, Code::gone);
  EXPECT_FALSE(fs::exists(data_ / "copy" / hash.substr(0, 2) / hash));
}

TEST_F(BlobsTest, APinnedBlobIsDeletedOnlyAfterItsPinIsReleased) {
  const auto blobs = *FileBlobs::open(data_);
  const auto unnamed = [](const std::string&) { return false; };
  auto upload = *blobs->upload();
  ASSERT_TRUE(upload.write("some bytes"));
  auto first = *blobs->put(upload);
  const std::string hash = upload.digest().sha256;
  Pin second = blobs->pin(hash);
  first.release();
  blobs->collect(hash, unnamed);
  blobs->collect_again(unnamed);
  EXPECT_TRUE(blobs->open(hash));
  second.release();
  blobs->collect_again(unnamed);
  EXPECT_EQ(blobs->open(hash).error().code, Code::not_found);
}

// While a deletion looks whether the blob is named, the same bytes arrive again: they are stored after it.
TEST_F(BlobsTest, BytesThatArriveDuringTheirDeletionAreStored) {
  const auto blobs = *FileBlobs::open(data_);
  const std::string hash = kept(*blobs, "some bytes");
  std::thread sender;
  blobs->collect(hash, [&](const std::string&) {
    sender = std::thread([&] { kept(*blobs, "some bytes"); });
    return false;
  });
  sender.join();
  EXPECT_TRUE(blobs->open(hash));
}

using ServerBlobs = ServerTest;

TEST_F(ServerBlobs, ADownloadOfADamagedFileBreaksOffAndIsTheLast) {
  const std::string id = json::parse(submit().body)["id"],
                    path = "/api/v1/jobs/" + id + "/artifacts/mold.stl";
  const json held = json::parse(ask("POST", "/api/v1/leases", worker_headers(), R"({"protocol":2})").body);
  std::string bytes;
  while (bytes.size() < 300'000) bytes += "one byte after the other, ";
  ASSERT_EQ(
      ask("PUT", "/api/v1/leases/" + id + "/artifacts/mold.stl",
          worker_headers(held["lease"].get<std::string>()) + "Content-Type: application/octet-stream\r\n",
          bytes)
          .status,
      200);
  finish({id, held["lease"]}, {"mold.stl"});
  EXPECT_EQ(ask("GET", path).body, bytes);
  rot(place_of(data_, text_hash(bytes)));
  testing::internal::CaptureStderr();
  const Answer broken = ask("GET", path);
  EXPECT_EQ(broken.status, 200);
  EXPECT_EQ(broken.header("Content-Length"), std::to_string(bytes.size()));
  EXPECT_LT(broken.body.size(), bytes.size());
  const Answer refused = ask("GET", path);
  EXPECT_EQ(refused.status, 410);
  EXPECT_NE(refused.body.find("/problems/gone"), std::string::npos);
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("\"event\":\"blob-damaged\",\"blob\":\"" + text_hash(bytes) + "\""), std::string::npos)
      << log;
}

}  // namespace
}  // namespace vacuform
