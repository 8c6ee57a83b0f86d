// The real scans, which are not in the repository: tests/real/scans.json says what they are, tests/fetch-scans gets them.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

namespace vacuform::real {

using FileBytes = std::vector<std::uint8_t>;

inline std::string path_of(const std::string& file) { return VACUFORM_SHARED_DATA "/scans/" + file; }

inline std::optional<FileBytes> read(const std::string& file) {
  std::ifstream in(path_of(file), std::ios::binary);
  if (!in) return std::nullopt;
  const std::vector<char> text((std::istreambuf_iterator<char>(in)), {});
  return FileBytes(text.begin(), text.end());
}

inline std::string missing(const std::string& file) {
  return path_of(file) +
         " is missing. Run tests/fetch-scans, or set VACUFORM_SHARED_DATA to the folder above scans/.";
}

inline bool required() {
  const char* set = std::getenv("VACUFORM_REQUIRE_REAL_SCANS");
  return set && std::string(set) == "1";
}

}  // namespace vacuform::real

// Declares `bytes`, the contents of a real scan. Without the file the test is skipped, or fails where
// VACUFORM_REQUIRE_REAL_SCANS=1.
#define VACUFORM_READ_REAL_SCAN(bytes, file)              \
  const auto bytes##_read = ::vacuform::real::read(file); \
  if (!bytes##_read && ::vacuform::real::required())      \
    FAIL() << ::vacuform::real::missing(file);            \
  else if (!bytes##_read)                                 \
    GTEST_SKIP() << ::vacuform::real::missing(file);      \
  const ::vacuform::real::FileBytes& bytes = *bytes##_read
