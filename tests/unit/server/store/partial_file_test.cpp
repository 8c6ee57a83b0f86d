// Files that arrive in pieces: the same bytes and the same hash however often they were interrupted.
#include "server/store/partial_file.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "server/store/file_blobs.hpp"

namespace vacuform {
namespace {

class PartialFileTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    data_ = std::filesystem::temp_directory_path() / ("vacuform-partial-" + random_hex(8));
    auto blobs = FileBlobs::open(data_);
    ASSERT_TRUE(blobs);
    blobs_ = std::move(*blobs);
    name_ = data_ / "upload";
  }
  void TearDown() override { std::filesystem::remove_all(data_); }

  static std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static std::string blanked(const std::string& bytes, const std::string& extension) {
    NameFilter filter(extension);
    std::string out = filter.pass(bytes);
    return out += filter.finish();
  }
  // Takes `bytes` in steps, as if the server had been killed after each, and gives what is kept.
  std::string in_steps(const std::string& bytes, const std::string& extension, std::size_t step) {
    for (std::size_t at = 0; at < bytes.size(); at += step) {
      auto file = PartialFile::open(name_, extension);
      EXPECT_TRUE(file);
      EXPECT_EQ(file->bytes(), at);
      EXPECT_TRUE(file->take(std::string_view(bytes).substr(at, step)));
      EXPECT_TRUE(file->flush());
      EXPECT_TRUE(file->take("lost in the crash"));
      EXPECT_EQ(*PartialFile::flushed(name_), std::min(at + step, bytes.size()));
    }
    return finished(extension);
  }
  std::string finished(const std::string& extension) {
    auto file = PartialFile::open(name_, extension);
    EXPECT_TRUE(file);
    auto upload = file->finish(blobs_->temporary_path());
    EXPECT_TRUE(upload);
    const Blob blob = upload->digest();
    EXPECT_TRUE(blobs_->put(*upload));
    EXPECT_TRUE(PartialFile::remove(name_));
    const std::string kept = bytes_of(data_ / "blobs" / blob.sha256.substr(0, 2) / blob.sha256);
    EXPECT_EQ(blob.bytes, kept.size());
    EXPECT_EQ(blob.sha256, text_hash(kept));
    EXPECT_FALSE(std::filesystem::exists(data_ / "upload.part"));
    EXPECT_FALSE(std::filesystem::exists(data_ / "upload.state"));
    return kept;
  }

  std::filesystem::path data_, name_;
  std::unique_ptr<BlobStore> blobs_;
};

const std::string patient = "JaneDoe1984";

TEST_F(PartialFileTest, NamesAreBlankedWhereverItWasInterrupted) {
  const std::string stl = std::string(patient).append(69, ' ').append("\x01\0\0\0", 4).append(50, '\x07'),
                    obj = "# " + patient + "\nv 1 2 3 # " + patient +
                          " v 4 5 6\nnote v 7 8 9\nf 1 2 \\\n 3\no " + patient + "\n",
                    text = "solid " + patient + " v\n" + patient +
                           "\nfacet normal 0 0 1\nendfacet\nendsolid " + patient;
  for (const auto& [bytes, extension] : {std::pair{stl, "stl"}, {obj, "obj"}, {text, "stl"}})
    for (const std::size_t step : {13, 83, 84, 85})
      EXPECT_EQ(in_steps(bytes, extension, step), blanked(bytes, extension)) << extension << " " << step;
}

// Another server has the pieces alone.
TEST_F(PartialFileTest, AnotherServerContinuesFromThePieces) {
  std::string obj;
  while (obj.size() < 300'000) obj += "# " + patient + "\nv 1 2 3\n";
  for (const std::size_t step : {100'000, 123'457}) {
    std::vector<std::string> pieces;
    for (std::size_t at = 0; at < obj.size(); at += step) {
      const auto open_piece = [&](std::size_t i) { return blobs_->open(pieces[i]); };
      auto file = pieces.empty() ? PartialFile::open(name_, "obj")
                                 : PartialFile::of_pieces(name_, "obj", pieces.size(), open_piece);
      ASSERT_TRUE(file) << file.error().text();
      EXPECT_EQ(file->bytes(), at);
      ASSERT_TRUE(file->take(std::string_view(obj).substr(at, step)) && file->flush());
      auto piece = blobs_->upload();
      ASSERT_TRUE(piece && file->write_piece(*piece) && blobs_->put(*piece));
      pieces.push_back(piece->digest().sha256);
      ASSERT_TRUE(file->take("lost in the crash"));
      if (at + step < obj.size()) {
        ASSERT_TRUE(PartialFile::remove(name_));
      }
    }
    EXPECT_EQ(finished("obj"), blanked(obj, "obj")) << step;
  }
}

TEST_F(PartialFileTest, BytesThatAreNoPieceAreRefused) {
  for (const char* bytes : {"", "Jane", "5", "999999999999\n", "9\nshort"}) {
    auto upload = blobs_->upload();
    ASSERT_TRUE(upload && upload->write(bytes) && blobs_->put(*upload));
    const auto file = PartialFile::of_pieces(
        name_, "stl", 1, [&](std::size_t) { return blobs_->open(upload->digest().sha256); });
    ASSERT_FALSE(file) << bytes;
    EXPECT_EQ(file.error().code, Code::unreadable) << bytes;
  }
}

TEST_F(PartialFileTest, InLongCommentsAndSegmentsToo) {
  std::string obj =
      "v 1 2 3 # " + std::string(500'000, 'x');  // of one line, whose end may look like a beginning
  while (obj.size() < 1'000'000) obj += " v 1 2 3 o " + patient;
  EXPECT_EQ(in_steps(obj, "obj", 300'007), blanked(obj, "obj"));
  std::string jpeg = "\xff\xd8";  // comments of the greatest size
  for (int i = 0; i < 8; ++i) jpeg.append("\xff\xfe\xff\xff").append(65'533, 'J');
  jpeg += "\xff\xd9";
  EXPECT_EQ(in_steps(jpeg, "jpg", 130'003), blanked(jpeg, "jpg"));
}

TEST_F(PartialFileTest, NoWholeNameStandsOnTheDiskMeanwhile) {
  std::string obj;
  while (obj.size() < 1'000'000) obj += "# " + patient + "\nv 1 2 3\n";
  auto file = PartialFile::open(name_, "obj");
  ASSERT_TRUE(file && file->take(obj) && file->flush());
  for (const char* end : {".part", ".state"})
    EXPECT_EQ(bytes_of(data_ / (std::string("upload") + end)).find(patient), std::string::npos);
  EXPECT_LE(std::filesystem::file_size(data_ / "upload.state"), 200u);
}

TEST_F(PartialFileTest, FreesTheSpaceOfUnflushedBytes) {
  {
    auto file = PartialFile::open(name_, "stl");
    ASSERT_TRUE(file && file->take(std::string(1000, '\1')) && file->flush());
    EXPECT_TRUE(file->is_flushed());
    const auto flushed = std::filesystem::file_size(data_ / "upload.part");
    ASSERT_TRUE(file->take(std::string(100'000, '\1')));
    EXPECT_FALSE(file->is_flushed());
    EXPECT_GT(std::filesystem::file_size(data_ / "upload.part"), flushed);
    file->drop_unflushed();
    EXPECT_EQ(std::filesystem::file_size(data_ / "upload.part"), flushed);
  }
  EXPECT_EQ(PartialFile::open(name_, "stl")->bytes(), 1000u);
}

TEST_F(PartialFileTest, AStateThatIsNoneBeginsAnew) {
  for (const char* text : {"", "5", "5 ", "5 5", "5 9\n0 0 ", "Jane"}) {
    {
      auto file = PartialFile::open(name_, "stl");
      ASSERT_TRUE(file && file->take("solid") && file->flush());
    }
    std::ofstream(data_ / "upload.state") << text;
    EXPECT_EQ(*PartialFile::flushed(name_), 0u) << text;
    EXPECT_EQ(PartialFile::open(name_, "stl")->bytes(), 0u) << text;
  }
}

TEST_F(PartialFileTest, HalfOfItsTwoFilesIsNone) {
  {
    auto file = PartialFile::open(name_, "stl");
    ASSERT_TRUE(file && file->take("solid") && file->flush());
  }
  std::filesystem::remove(data_ / "upload.part");
  EXPECT_EQ(*PartialFile::flushed(name_), 0u);
  EXPECT_EQ(PartialFile::open(name_, "stl")->bytes(), 0u);
  EXPECT_EQ(*PartialFile::flushed(name_), 0u);
  EXPECT_EQ(*PartialFile::flushed(data_ / "nothing"), 0u);
}

}  // namespace
}  // namespace vacuform
