// The requests that blobs need of an object store that speaks S3. No request depends on what differs between such stores:
// nothing is written on a condition, and every body is signed with its SHA-256, which the store checks.
//
// A request that was not answered, or was answered with 5xx or 429, is sent again up to three times, later each time.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/clock.hpp"
#include "api/base/error.hpp"
#include "api/base/file.hpp"
#include "api/client/http.hpp"
#include "server/store/blobs/s3/s3_address.hpp"

namespace vacuform {

struct S3Object {
  std::uint64_t bytes = 0;
  std::string etag;  // changes with the bytes; without quotation marks; may be empty
};

struct S3Listed {
  std::string key;
  std::uint64_t bytes = 0;
  std::optional<Millis> stored;  // by the clock of the object store
};

// From any thread. Errors of everything: unavailable (no answer, refused, no such bucket), disk_full (a quota).
class S3Client {
 public:
  // `going`, unless it is empty, is asked several times a second during a request; false gives it up with cancelled.
  S3Client(S3Address address, S3Credentials credentials, std::function<bool()> going = {})
      : address_(std::move(address)), credentials_(std::move(credentials)), going_(std::move(going)) {}

  // Whether the bucket is there and the credentials are good for it. Errors: bad_usage if not; unavailable.
  Result<void> check();
  // `key` is below the prefix. Gives the entity tag.
  Result<std::string> put(const std::string& key, const File& file, std::uint64_t bytes,
                          const std::string& sha256);
  Result<std::string> put(const std::string& key, const std::string& text);
  // In parts of `part` bytes, 5 MiB or more; nothing is left behind on an error.
  Result<std::string> put_parts(const std::string& key, const File& file, std::uint64_t bytes,
                                std::uint64_t part);
  // Errors: not_found.
  Result<S3Object> head(const std::string& key);
  using Sink = std::function<bool(std::string_view piece)>;
  // The bytes of a range, or of the whole object if `bytes` is 0. `begin` is called before the first byte, and again
  // when the request is repeated. Errors: not_found; gone: its entity tag is not `etag`, unless that is empty; cancelled,
  // if the sink gives up.
  Result<void> get(const std::string& key, std::uint64_t offset, std::uint64_t bytes, const std::string& etag,
                   const std::function<void()>& begin, const Sink& sink);
  // Once, without a second attempt. An object that does not exist is fine.
  Result<void> remove(const std::string& key);
  // Up to a thousand objects whose keys come after `after`, in the order of their keys.
  Result<std::vector<S3Listed>> list(const std::string& after);
  // Deletes the parts of uploads to this key that were never completed.
  Result<void> abort_uploads(const std::string& key);

 private:
  struct Request {
    std::string method, key;
    bool of_bucket = false;  // and not of an object
    std::map<std::string, std::string> query = {}, headers = {};
    std::string payload_sha256 = {};
    HttpRequest http = {};
    int tries = 4;
    std::function<void()> begin = {};
  };
  Result<HttpResponse> exchange(const Request& request);
  HttpRequest signed_request(const Request& request) const;
  Error error_in(const Request& request, const HttpResponse& response) const;
  Result<std::string> begin_upload(const std::string& key);
  Result<std::string> put_part(const std::string& key, const std::string& upload, int number,
                               const File& file, std::uint64_t offset, std::uint64_t bytes);
  Result<std::string> complete_upload(const std::string& key, const std::string& upload,
                                      const std::vector<std::string>& tags);
  Result<void> abort_upload(const std::string& key, const std::string& upload);
  Result<Http> take_connection();

  const S3Address address_;
  const S3Credentials credentials_;
  const std::function<bool()> going_;
  std::mutex mutex_;
  std::vector<Http> idle_;  // connections that nobody uses
};

}  // namespace vacuform
