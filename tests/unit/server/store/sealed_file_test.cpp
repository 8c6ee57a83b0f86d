// Files on their way in: the same bytes however often they were interrupted, and nothing of them readable on the disk.
#include "server/store/sealed_file.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "api/base/secrets.hpp"
#include "server/store/blobs/files/file_blobs.hpp"

namespace vacuform {
namespace {

const std::string patient = "JaneDoe1984";

std::string content(std::size_t size) {
  std::string text;
  for (int i = 0; text.size() < size; ++i) text += patient + " " + std::to_string(i) + "\n";
  return text.substr(0, size);
}

class SealedFileTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    data_ = std::filesystem::temp_directory_path() / ("vacuform-sealed-" + random_hex(8));
    auto blobs = FileBlobs::open(data_);
    ASSERT_TRUE(blobs);
    blobs_ = std::move(*blobs);
    path_ = data_ / "upload.part";
    key_ = SealedFile::new_key();
  }
  void TearDown() override { std::filesystem::remove_all(data_); }

  std::string on_disk() const {
    std::ifstream in(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void change_disk(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }
  // As the next start of the server finds it.
  std::string read(const std::string& key) const {
    auto file = SealedFile::open(path_, key);
    EXPECT_TRUE(file);
    return read(*file);
  }
  static std::string read(SealedFile& file, std::size_t step = 10'007) {
    EXPECT_TRUE(file.seal());
    std::string all, piece(step, '\0');
    for (;;) {
      const auto n = file.read_at(all.size(), piece);
      EXPECT_TRUE(n);
      if (!n || *n == 0) return all;
      all += piece.substr(0, *n);
    }
  }

  std::filesystem::path data_, path_;
  std::string key_;
  std::unique_ptr<BlobStore> blobs_;
};

TEST_F(SealedFileTest, KeepsWhatWasFlushedAndNothingElse) {
  const std::string all = content(300'000);
  for (const std::size_t step : {13'001, 65'536, 65'537, 140'000}) {
    for (std::size_t at = 0; at < all.size(); at += step) {
      auto file = SealedFile::open(path_, key_);
      ASSERT_TRUE(file);
      EXPECT_EQ(file->bytes(), at);
      ASSERT_TRUE(file->take(std::string_view(all).substr(at, step)) && file->flush());
      EXPECT_TRUE(file->is_flushed());
      ASSERT_TRUE(file->take(std::string(100'000, 'x')));  // lost in the crash, though a part is on the disk
      EXPECT_FALSE(file->is_flushed());
    }
    EXPECT_EQ(read(key_), all) << step;
    std::filesystem::remove(path_);
  }
}

TEST_F(SealedFileTest, NothingOfItCanBeReadOnTheDisk) {
  auto file = SealedFile::open(path_, key_);
  ASSERT_TRUE(file && file->take(content(200'000)) && file->flush());
  EXPECT_GT(on_disk().size(), 200'000u);
  for (std::size_t at = 0; at + 4 <= patient.size(); ++at)
    EXPECT_EQ(on_disk().find(patient.substr(at, 5)), std::string::npos);
  EXPECT_EQ(read(SealedFile::new_key()), "");  // another key; and then nothing is left
  EXPECT_EQ(read(key_), "");
}

// The same bytes are never the same on the disk, and their parts cannot change places.
TEST_F(SealedFileTest, EveryChangeOfTheFileIsFound) {
  const std::string all = content(150'000);
  {
    auto file = SealedFile::open(path_, key_);
    ASSERT_TRUE(file && file->take(std::string_view(all).substr(0, 65'536)) && file->flush());
    ASSERT_TRUE(file->take(std::string_view(all).substr(65'536)) && file->flush());
  }
  const std::string good = on_disk();
  constexpr std::size_t first = 65'536 + 44, mark = 44;  // bytes of a record
  for (const std::size_t at : {std::size_t{0}, std::size_t{7}, std::size_t{40}, first - 1, first + 1}) {
    std::string changed = good;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    change_disk(changed);
    EXPECT_EQ(read(key_), "") << at;
  }
  for (const std::size_t at : {first + mark + 30, good.size() - 1, good.size() - mark - 1}) {
    std::string changed = good;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    change_disk(changed);
    EXPECT_EQ(read(key_), all.substr(0, 65'536)) << at;
  }
  change_disk(good.substr(0, good.size() - 3));
  EXPECT_EQ(read(key_), all.substr(0, 65'536));
  change_disk(good.substr(first + mark) + good.substr(0, first + mark));
  EXPECT_EQ(read(key_), "");
  change_disk("no such file");
  EXPECT_EQ(read(key_), "");
}

TEST_F(SealedFileTest, ReadsFromAnyPlace) {
  const std::string all = content(200'000);
  auto file = SealedFile::temporary(path_);
  ASSERT_TRUE(file && file->take(all) && file->seal());
  EXPECT_FALSE(std::filesystem::exists(path_));
  for (const std::size_t at : {0, 65'535, 65'536, 131'071, 199'999, 1, 131'072, 200'000, 300'000}) {
    std::string piece(1000, '\0');
    const auto n = file->read_at(at, piece);
    ASSERT_TRUE(n);
    EXPECT_EQ(*n > 0, at < all.size()) << at;
    EXPECT_EQ(piece.substr(0, *n), all.substr(std::min<std::size_t>(at, all.size()), *n)) << at;
  }
  EXPECT_EQ(read(*file, 1 << 20), all);
}

// Another server has the pieces alone.
TEST_F(SealedFileTest, AnotherServerContinuesFromThePieces) {
  const std::string all = content(300'000);
  for (const std::size_t step : {100'000, 123'457}) {
    std::vector<std::string> pieces;
    const auto open_piece = [&](std::size_t i) { return blobs_->open(pieces[i]); };
    for (std::size_t at = 0; at < all.size(); at += step) {
      auto file = pieces.empty() ? SealedFile::open(path_, key_)
                                 : SealedFile::of_pieces(path_, key_, pieces.size(), open_piece);
      ASSERT_TRUE(file) << file.error().text();
      EXPECT_EQ(file->bytes(), at);
      ASSERT_TRUE(file->take(std::string_view(all).substr(at, step)) && file->flush());
      auto piece = blobs_->upload();
      ASSERT_TRUE(piece && file->write_piece(*piece) && blobs_->put(*piece));
      pieces.push_back(piece->digest().sha256);
      ASSERT_TRUE(file->take("lost in the crash"));
    }
    auto file = SealedFile::of_pieces(path_, key_, pieces.size(), open_piece);
    ASSERT_TRUE(file);
    EXPECT_EQ(read(*file), all) << step;
    std::swap(pieces.front(), pieces.back());
    EXPECT_EQ(SealedFile::of_pieces(path_, key_, pieces.size(), open_piece).error().code, Code::unreadable);
    std::filesystem::remove(path_);
  }
}

TEST_F(SealedFileTest, FreesTheSpaceOfUnflushedBytes) {
  {
    auto file = SealedFile::open(path_, key_);
    ASSERT_TRUE(file && file->take(std::string(1000, '\1')) && file->flush());
    const auto flushed = std::filesystem::file_size(path_);
    ASSERT_TRUE(file->take(std::string(100'000, '\1')));
    EXPECT_GT(std::filesystem::file_size(path_), flushed);
    file->drop_unflushed();
    EXPECT_EQ(std::filesystem::file_size(path_), flushed);
  }
  EXPECT_EQ(SealedFile::open(path_, key_)->bytes(), 1000u);
}

}  // namespace
}  // namespace vacuform
