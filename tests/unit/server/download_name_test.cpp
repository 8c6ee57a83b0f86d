#include "server/jobs/download_name.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace vacuform {
namespace {

Job job_of(const std::string& reference, const std::string& face = "outer") {
  Job job;
  job.id = "01hrz3f8w2c4e6g8k0m2p4r6t8";
  job.settings = R"({"pattern":{"inked_face":")" + face + "\"}}";
  job.reference = reference;
  return job;
}

TEST(DownloadName, HasReferenceFaceAndArtifact) {
  EXPECT_EQ(download_name(job_of("CASE-12"), "print.pdf"), "CASE-12-outer-print.pdf");
  EXPECT_EQ(download_name(job_of("CASE-12", "inner"), "print.svg"), "CASE-12-inner-print.svg");
  EXPECT_EQ(download_name(job_of("CASE-12", "inner"), "mold.stl"), "CASE-12-mold.stl");
  EXPECT_EQ(download_name(job_of(""), "artifacts.zip"), "m2p4r6t8-artifacts.zip");
}

TEST(DownloadName, HasNoCharacterThatASystemRefuses) {
  EXPECT_EQ(download_name(job_of("../../a/b\\c:d*e?f\"g<h>i|j%k"), "mold.stl"),
            "a-b-c-d-e-f-g-h-i-j-k-mold.stl");
  EXPECT_EQ(download_name(job_of(" .-hidden. "), "mold.stl"), "hidden-mold.stl");
  EXPECT_EQ(download_name(job_of("///"), "mold.stl"), "m2p4r6t8-mold.stl");
  std::string long_one;
  for (int i = 0; i < 64; ++i) long_one += "𝄞";
  EXPECT_EQ(download_name(job_of(long_one), "print.pdf").size(), 160u + 16u);  // whole characters
}

TEST(DownloadName, IsAsciiWithTheWholeNameBesideIt) {
  EXPECT_EQ(
      content_disposition("inline", job_of("CASE 12/ä"), "print.pdf"),
      "inline; filename=\"CASE-12-outer-print.pdf\"; filename*=UTF-8''CASE%2012-%C3%A4-outer-print.pdf");
  EXPECT_EQ(
      content_disposition("attachment", job_of("北京"), "artifacts.zip"),
      "attachment; filename=\"m2p4r6t8-artifacts.zip\"; filename*=UTF-8''%E5%8C%97%E4%BA%AC-artifacts.zip");
  // Nothing ends the header or the quoted text early.
  for (const std::string& hostile :
       {std::string("a\r\nX-Evil: 1"), std::string("a\"; filename=b"), std::string("a\0b", 3)}) {
    const std::string value = content_disposition("inline", job_of(hostile), "print.pdf");
    EXPECT_EQ(value.find_first_of("\r\n"), std::string::npos) << value;
    EXPECT_EQ(std::count(value.begin(), value.end(), '"'), 2) << value;
  }
}

}  // namespace
}  // namespace vacuform
