// Where objects are kept, as --blobs says it: s3://BUCKET/PREFIX?endpoint=https://HOST&region=NAME&addressing=path. The
// credentials are never part of it.
#pragma once

#include <filesystem>
#include <string>

#include "api/base/error.hpp"
#include "server/store/blobs/s3/s3_signature.hpp"

namespace vacuform {

struct S3Address {
  std::string bucket;
  std::string prefix;    // of every key; empty, or ends with a slash
  std::string endpoint;  // "https://s3.example.org:8443", without a slash at its end
  std::string region = "us-east-1";
  bool path_style = true;  // the bucket is in the path, and not a part of the host's name

  // The address and the path of requests to the bucket.
  std::string url() const;
  std::string root() const { return path_style ? std::string("/").append(bucket) : std::string(); }
  // As HTTP sends it.
  std::string host() const;
};

// Errors: bad_usage. Plain HTTP is for loopback alone.
Result<S3Address> s3_address(const std::string& text);

// Whether `blobs` names files, in the data folder: empty, or "file:".
bool blobs_in_files(const std::string& blobs);
// Whether --blobs can be used, without a connection. Errors: bad_usage.
Result<void> check_blobs(const std::string& blobs);

// From a file in the format that other programs for S3 use (aws_access_key_id = ..., aws_secret_access_key = ...,
// aws_session_token = ...), or, without a file, from the environment (AWS_ACCESS_KEY_ID and so on). Errors: bad_usage.
Result<S3Credentials> s3_credentials(const std::filesystem::path& file);

}  // namespace vacuform
