// The signer against the published examples of AWS: the suite of Signature Version 4, and those of the S3 documentation.
#include "server/store/blobs/s3/s3_signature.hpp"

#include <gtest/gtest.h>

#include "api/base/secrets.hpp"

namespace vacuform {
namespace {

const std::string no_payload = text_hash("");

std::string signature(const SignedRequest& request, const S3Credentials& credentials, const S3Scope& scope) {
  const std::string header = s3_authorization(request, credentials, scope);
  return header.substr(header.rfind('=') + 1);
}

// A request of the suite.
std::string of_suite(const std::string& method, const std::string& path,
                     const std::map<std::string, std::string>& query = {}) {
  const S3Credentials credentials{"AKIDEXAMPLE", "wJalrXUtnFEMI/K7MDENG+bPxRfiCYEXAMPLEKEY", ""};
  const SignedRequest request{method,
                              path,
                              query,
                              {{"host", "example.amazonaws.com"}, {"x-amz-date", "20150830T123600Z"}},
                              no_payload};
  return signature(request, credentials, {"us-east-1", "service"});
}

// A request of the S3 documentation.
std::string of_s3(const std::string& method, const std::string& path,
                  const std::map<std::string, std::string>& query, std::map<std::string, std::string> headers,
                  const std::string& payload = "") {
  const S3Credentials credentials{"AKIAIOSFODNN7EXAMPLE", "wJalrXUtnFEMI/K7MDENG/bPxRfiCYEXAMPLEKEY", ""};
  headers["host"] = "examplebucket.s3.amazonaws.com";
  headers["x-amz-date"] = "20130524T000000Z";
  headers["x-amz-content-sha256"] = text_hash(payload);
  return signature({method, path, query, std::move(headers), text_hash(payload)}, credentials,
                   {"us-east-1", "s3"});
}

TEST(S3Signature, IsThatOfTheSuite) {
  EXPECT_EQ(of_suite("GET", "/"), "5fa00fa31553b73ebf1942676e86291e8372ff2a2260956d9b8aae1d763fbf31");
  EXPECT_EQ(of_suite("POST", "/"), "5da7c1a2acd57cee7505fc6676e4e544621c30862966e37dddb68e92efbe5d6b");
  EXPECT_EQ(of_suite("GET", "/\u1234"), "8318018e0b0f223aa2bbf98705b62bb787dc9c0e678f255a891fd03141be5d85");
  EXPECT_EQ(of_suite("GET", "/-._~0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"),
            "07ef7494c76fa4850883e2b006601f940f8a34d404d0cfa977f52a65bbf5f24f");
  EXPECT_EQ(of_suite("GET", "/", {{"Param2", "value2"}, {"Param1", "value1"}}),
            "b97d918cfa904a5beff61c982a1b6f458b799221646efd99d3219ec94cdf2500");
  EXPECT_EQ(of_suite("GET", "/", {{"Param1", "value1"}}),
            "a67d582fa61cc504c4bae71f336f98b97f1ea3c7a6bfe1b6e45aec72011b9aeb");
}

TEST(S3Signature, IsThatOfTheExamplesOfS3) {
  EXPECT_EQ(of_s3("GET", "/test.txt", {}, {{"range", "bytes=0-9"}}),
            "f0e8bdb87c964420e857bd35b5d6ed310bd44f0170aba48dd91039c6036bdb41");
  EXPECT_EQ(of_s3("PUT", "/test$file.text", {},
                  {{"date", "Fri, 24 May 2013 00:00:00 GMT"}, {"x-amz-storage-class", "REDUCED_REDUNDANCY"}},
                  "Welcome to Amazon S3."),
            "98ad721746da40c64f1a55b78f14c238d841ea1380cd77a1b5971af0ece108bd");
  EXPECT_EQ(of_s3("GET", "/", {{"lifecycle", ""}}, {}),
            "fea454ca298b7da1c68078a5d1bdbfbbe0d65c699e0f91ac7a200a0136783543");
  EXPECT_EQ(of_s3("GET", "/", {{"max-keys", "2"}, {"prefix", "J"}}, {}),
            "34b48302e7b5fa45bde8084f4b7868a86f0a534bc59db6670ed5711ef69dc6f7");
}

TEST(S3Signature, DependsOnEveryPartOfARequest) {
  const std::string one = of_s3("GET", "/a", {{"b", "c"}}, {{"range", "bytes=0-9"}});
  EXPECT_EQ(one, of_s3("GET", "/a", {{"b", "c"}}, {{"range", "  bytes=0-9 "}}));
  EXPECT_NE(one, of_s3("PUT", "/a", {{"b", "c"}}, {{"range", "bytes=0-9"}}));
  EXPECT_NE(one, of_s3("GET", "/A", {{"b", "c"}}, {{"range", "bytes=0-9"}}));
  EXPECT_NE(one, of_s3("GET", "/a", {{"b", "d"}}, {{"range", "bytes=0-9"}}));
  EXPECT_NE(one, of_s3("GET", "/a", {{"b", "c"}}, {{"range", "bytes=0-8"}}));
  EXPECT_NE(one, of_s3("GET", "/a", {{"b", "c"}}, {{"range", "bytes=0-9"}}, "a body"));
}

TEST(S3Signature, WritesTimesAsTheyAreSigned) {
  EXPECT_EQ(s3_time(0), "19700101T000000Z");
  EXPECT_EQ(s3_time(1'369'353'600'999), "20130524T000000Z");
}

}  // namespace
}  // namespace vacuform
