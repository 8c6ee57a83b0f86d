#include "api/base/sha256.hpp"

#include <gtest/gtest.h>

namespace vacuform {
namespace {

std::string digest(const std::string& text) {
  Sha256 sha;
  sha.add(text);
  return sha.hex();
}

// FIPS 180-4's examples.
TEST(Sha256, KnownMessages) {
  EXPECT_EQ(digest(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(digest("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(digest(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, PiecesAddUp) {
  Sha256 sha;
  for (int i = 0; i < 1000; ++i) sha.add(std::string(1000, 'a'));
  EXPECT_EQ(sha.hex(), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace vacuform
