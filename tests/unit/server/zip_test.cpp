// Zips that are made while they are sent: the whole, its parts, and places beyond 32 bits.
#include "server/jobs/zip.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "api/base/secrets.hpp"
#include "server/store/blobs/files/file_blobs.hpp"

namespace vacuform {
namespace {

class ZipTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    folder_ = std::filesystem::temp_directory_path() / ("vacuform-zip-" + random_hex(8));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // A file of that many bytes, without its bytes on the disk, but for the last ones.
  Zip::Entry file(const std::string& name, std::uint64_t bytes, const std::string& last) {
    std::ofstream(folder_ / name) << "";
    std::filesystem::resize_file(folder_ / name, bytes - last.size());
    std::ofstream(folder_ / name, std::ios::app) << last;
    return {name, {name, bytes}, 7};
  }
  Zip zip(std::vector<Zip::Entry> entries) {
    return Zip(std::move(entries), [this](const Blob& blob) -> Result<std::unique_ptr<BlobReader>> {
      VACUFORM_TRY(file, File::open(folder_ / blob.sha256));
      return reader_of(std::move(file));
    });
  }
  static std::string read(const Zip& zip, std::uint64_t from, std::uint64_t bytes, std::size_t buffer_bytes) {
    std::string text, buffer(buffer_bytes, 0);
    while (text.size() < bytes) {
      const auto n = zip.read_at(from + text.size(), buffer);
      if (!n || *n == 0) break;
      text.append(buffer, 0, *n);
    }
    return text.substr(0, bytes);
  }
  static std::uint64_t number(const std::string& text, std::size_t at, int bytes) {
    std::uint64_t value = 0;
    for (int i = bytes; i-- > 0;)
      value = value << 8 | static_cast<unsigned char>(text[at + static_cast<std::size_t>(i)]);
    return value;
  }

  std::filesystem::path folder_;
};

TEST_F(ZipTest, IsTheSameWhereverItIsReadFrom) {
  const Zip made = zip({file("a.txt", 5, "hello"), file("b.txt", 300, "world")});
  const std::string whole = read(made, 0, made.bytes(), 1 << 16);
  ASSERT_EQ(whole.size(), made.bytes());
  EXPECT_EQ(whole.substr(30, 10), "a.txthello");
  for (std::uint64_t from = 0; from <= whole.size(); ++from)
    EXPECT_EQ(read(made, from, made.bytes() - from, 7), whole.substr(from)) << from;
}

TEST_F(ZipTest, PlacesBeyondThirtyTwoBitsAreFound) {
  constexpr std::uint64_t gib = 1 << 30;
  const Zip made =
      zip({file("a.bin", 2 * gib, "first"), file("b.bin", 2 * gib, "second"), file("c.bin", 9, "the third")});
  const std::string tail = read(made, made.bytes() - 400, 400, 1 << 16);
  const std::size_t end = tail.rfind("PK\x05\x06"), locator = tail.rfind("PK\x06\x07");
  ASSERT_NE(end, std::string::npos);
  ASSERT_NE(locator, std::string::npos);
  EXPECT_EQ(number(tail, end + 16, 4), 0xffffffffu);
  const std::uint64_t record = number(tail, locator + 8, 8);
  const std::string zip64 = read(made, record, 56, 56);
  EXPECT_EQ(zip64.substr(0, 4), "PK\x06\x06");
  EXPECT_EQ(number(zip64, 32, 8), 3u);
  const std::uint64_t directory = number(zip64, 48, 8), directory_bytes = number(zip64, 40, 8);
  EXPECT_EQ(directory + directory_bytes, record);
  const std::string central = read(made, directory, directory_bytes, 1000);
  const std::size_t third = central.rfind("PK\x01\x02");
  ASSERT_EQ(number(central, third + 42, 4), 0xffffffffu);
  const std::uint64_t place = number(central, third + 46 + 5 + 4, 8);
  EXPECT_EQ(read(made, place, 4, 4), "PK\x03\x04");
  EXPECT_EQ(read(made, place + 30, 14, 14), "c.binthe third");
}

}  // namespace
}  // namespace vacuform
