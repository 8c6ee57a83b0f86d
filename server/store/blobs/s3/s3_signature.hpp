// Signs requests to object stores: AWS Signature Version 4, by its public description
// (https://docs.aws.amazon.com/IAM/latest/UserGuide/reference_sigv.html).
#pragma once

#include <map>
#include <string>

#include "api/base/clock.hpp"

namespace vacuform {

struct S3Credentials {
  std::string key_id, secret;
  std::string session;  // of temporary credentials; may be empty
};

struct S3Scope {
  std::string region, service = "s3";
};

struct SignedRequest {
  std::string method;
  std::string path;                          // not yet encoded, "/bucket/a key"
  std::map<std::string, std::string> query;  // not yet encoded
  // Names in lower case; "host" is among them. Each of them is signed.
  std::map<std::string, std::string> headers;
  std::string payload_sha256;  // of the body, in hexadecimal
};

// Everything but letters, digits and -._~ as %XX; `keep_slashes` for paths.
std::string percent_encoded(const std::string& text, bool keep_slashes);
// "a=1&b=2" as it is signed, and as it must be sent.
std::string encoded_query(const std::map<std::string, std::string>& query);
// "20130524T000000Z"
std::string s3_time(Millis time);
// The value of the Authorization header. The request has an x-amz-date header.
std::string s3_authorization(const SignedRequest& request, const S3Credentials& credentials,
                             const S3Scope& scope);

}  // namespace vacuform
