#include "server/store/blobs/s3/s3_client.hpp"

#include <algorithm>
#include <chrono>
#include <pugixml.hpp>
#include <thread>

#include "api/base/clock.hpp"
#include "api/base/secrets.hpp"
#include "api/base/sha256.hpp"

namespace vacuform {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::string_view no_bytes_sha256 =
    "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
constexpr seconds small_request(20);  // for the whole of one
constexpr seconds trying(25);         // begin no further attempt after that
constexpr std::size_t most_idle = 16;
constexpr std::uint64_t slowest = 256'000;  // bytes a second of a transfer

seconds time_for(std::uint64_t bytes) { return small_request + seconds(bytes / slowest); }

milliseconds pause_after(int attempt) {
  const auto chance = static_cast<int>(random_number() % 100);
  return milliseconds((200 << attempt) + chance);
}

std::string without_quotes(std::string tag) {
  std::erase(tag, '"');
  return tag;
}

std::string header_of(const HttpResponse& response, const std::string& name) {
  const auto found = response.headers.find(name);
  return found == response.headers.end() ? "" : found->second;
}

std::string child_text(const std::string& body, const char* root, const char* name) {
  pugi::xml_document document;
  if (!document.load_buffer(body.data(), body.size())) return {};
  return document.child(root).child(name).text().as_string();
}

// The reason in an error's body: "NoSuchKey".
std::string reason_in(const HttpResponse& response) { return child_text(response.body, "Error", "Code"); }

bool is_passing(const HttpResponse& response) {
  if (response.status == 507) return false;
  return response.status >= 500 || response.status == 429 ||
         (response.status == 400 && reason_in(response) == "RequestTimeout");
}

bool good(const HttpResponse& response) { return response.status >= 200 && response.status < 300; }

Result<std::string> sha256_of_part(const File& file, std::uint64_t offset, std::uint64_t bytes) {
  Sha256 hash;
  std::vector<char> piece(256 * 1024);
  while (bytes > 0) {
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(bytes, piece.size()));
    VACUFORM_TRY(n, file.read_at(offset, {piece.data(), wanted}));
    if (n == 0) return fail(Code::unreadable, "a file is shorter than it was");
    hash.add({piece.data(), n});
    offset += n;
    bytes -= n;
  }
  return hash.hex();
}

}  // namespace

Result<Http> S3Client::take_connection() {
  {
    const std::lock_guard hold(mutex_);
    if (!idle_.empty()) {
      Http connection = std::move(idle_.back());
      idle_.pop_back();
      return connection;
    }
  }
  return Http::to(address_.url());
}

HttpRequest S3Client::signed_request(const Request& request) const {
  SignedRequest to_sign{
      request.method, address_.root() + "/", request.query, request.headers,
      request.payload_sha256.empty() ? std::string(no_bytes_sha256) : request.payload_sha256};
  if (!request.of_bucket) to_sign.path += address_.prefix + request.key;
  to_sign.headers["host"] = address_.host();
  to_sign.headers["x-amz-date"] = s3_time(wall_clock());
  to_sign.headers["x-amz-content-sha256"] = to_sign.payload_sha256;
  if (!credentials_.session.empty()) to_sign.headers["x-amz-security-token"] = credentials_.session;
  HttpRequest http = request.http;
  http.method = request.method;
  http.path = percent_encoded(to_sign.path, true);
  if (!request.query.empty()) http.path.append("?").append(encoded_query(request.query));
  http.headers = to_sign.headers;
  http.headers["authorization"] = s3_authorization(to_sign, credentials_, {address_.region});
  if (http.limit.count() == 0) http.limit = small_request;
  if (going_) http.going = [this](std::uint64_t, std::uint64_t) { return going_(); };
  return http;
}

// Gives any answer but those that another attempt may change.
Result<HttpResponse> S3Client::exchange(const Request& request) {
  const auto started = std::chrono::steady_clock::now();
  VACUFORM_TRY(connection, take_connection());
  for (int attempt = 1;; ++attempt) {
    if (request.begin) request.begin();
    auto answer = connection.send(signed_request(request));
    const bool again = answer ? is_passing(*answer) : answer.error().code == Code::unavailable;
    if (again && attempt < request.tries && std::chrono::steady_clock::now() - started < trying) {
      std::this_thread::sleep_for(pause_after(attempt));
      continue;
    }
    if (!answer && answer.error().code == Code::unavailable)
      return fail(Code::unavailable, "the object store cannot be reached: " + answer.error().what,
                  address_.endpoint, "check that it runs, and the endpoint in --blobs");
    const std::lock_guard hold(mutex_);
    if (answer && idle_.size() < most_idle) idle_.push_back(std::move(connection));
    return answer;
  }
}

Error S3Client::error_in(const Request& request, const HttpResponse& response) const {
  const std::string reason = reason_in(response),
                    shown = reason.empty() ? reason : std::string(" (").append(reason).append(")");
  const std::string bucket = address_.bucket;
  if (reason == "NoSuchBucket")
    return {Code::unavailable, "there is no such bucket in the object store", bucket,
            "make it, or correct the name in --blobs"};
  if (response.status == 404) return {Code::not_found, "there is no such object", request.key, ""};
  if (response.status == 412)
    return {Code::gone, "an object has changed", request.key, "restore the bucket from a backup"};
  if (response.status == 507 || response.status == 413 || reason == "QuotaExceeded" ||
      reason == "EntityTooLarge")
    return {Code::disk_full, "the object store has no room for more" + shown, bucket,
            "delete jobs, or raise the quota of the bucket"};
  if (reason == "RequestTimeTooSkewed")
    return {Code::unavailable, "the clocks of this machine and of the object store differ", address_.endpoint,
            "set the clock of this machine by NTP"};
  if (response.status == 403 || response.status == 401)
    return {Code::unavailable, "the object store refuses the access key" + shown, bucket,
            "check the key and its secret, and that it may read, write, list and delete in the bucket"};
  return {Code::unavailable, "the object store answered " + std::to_string(response.status) + shown,
          address_.endpoint, "see the log of the object store"};
}

Result<void> S3Client::check() {
  const Request request{
      "GET", "", true, {{"list-type", "2"}, {"max-keys", "1"}, {"prefix", address_.prefix}}};
  VACUFORM_TRY(answer, exchange(request));
  if (good(answer)) return {};
  Error error = error_in(request, answer);
  if (answer.status < 500 && answer.status != 429) error.code = Code::bad_usage;
  return tl::make_unexpected(error);
}

Result<std::string> S3Client::put(const std::string& key, const File& file, std::uint64_t bytes,
                                  const std::string& sha256) {
  Request request{"PUT", key};
  request.payload_sha256 = sha256;
  request.http.file = file.descriptor();
  request.http.file_bytes = bytes;
  request.http.limit = time_for(bytes);
  VACUFORM_TRY(answer, exchange(request));
  if (!good(answer)) return tl::make_unexpected(error_in(request, answer));
  return without_quotes(header_of(answer, "etag"));
}

Result<std::string> S3Client::put(const std::string& key, const std::string& text) {
  Request request{"PUT", key};
  request.payload_sha256 = text_hash(text);
  request.http.body = text;
  VACUFORM_TRY(answer, exchange(request));
  if (!good(answer)) return tl::make_unexpected(error_in(request, answer));
  return without_quotes(header_of(answer, "etag"));
}

Result<std::string> S3Client::put_parts(const std::string& key, const File& file, std::uint64_t bytes,
                                        std::uint64_t part) {
  VACUFORM_TRY(upload, begin_upload(key));
  std::vector<std::string> tags;
  for (std::uint64_t at = 0; at < bytes; at += part) {
    auto tag = put_part(key, upload, static_cast<int>(tags.size()) + 1, file, at, std::min(part, bytes - at));
    if (!tag) {
      (void)abort_upload(key, upload);
      return tag;
    }
    tags.push_back(std::move(*tag));
  }
  auto whole = complete_upload(key, upload, tags);
  if (!whole) (void)abort_upload(key, upload);
  return whole;
}

Result<std::string> S3Client::begin_upload(const std::string& key) {
  const Request request{"POST", key, false, {{"uploads", ""}}};
  VACUFORM_TRY(answer, exchange(request));
  if (!good(answer)) return tl::make_unexpected(error_in(request, answer));
  std::string upload = child_text(answer.body, "InitiateMultipartUploadResult", "UploadId");
  if (upload.empty()) return tl::make_unexpected(error_in(request, answer));
  return upload;
}

Result<std::string> S3Client::put_part(const std::string& key, const std::string& upload, int number,
                                       const File& file, std::uint64_t offset, std::uint64_t bytes) {
  VACUFORM_TRY(sha256, sha256_of_part(file, offset, bytes));
  Request request{"PUT", key, false, {{"partNumber", std::to_string(number)}, {"uploadId", upload}}};
  request.payload_sha256 = sha256;
  request.http.file = file.descriptor();
  request.http.file_offset = offset;
  request.http.file_bytes = bytes;
  request.http.limit = time_for(bytes);
  VACUFORM_TRY(answer, exchange(request));
  if (!good(answer)) return tl::make_unexpected(error_in(request, answer));
  return without_quotes(header_of(answer, "etag"));
}

// A failure may come after the head of the answer, with the status 200.
Result<std::string> S3Client::complete_upload(const std::string& key, const std::string& upload,
                                              const std::vector<std::string>& tags) {
  std::string body = "<CompleteMultipartUpload>";
  for (std::size_t i = 0; i < tags.size(); ++i)
    body +=
        "<Part><PartNumber>" + std::to_string(i + 1) + "</PartNumber><ETag>\"" + tags[i] + "\"</ETag></Part>";
  body += "</CompleteMultipartUpload>";
  Request request{"POST", key, false, {{"uploadId", upload}}};
  request.payload_sha256 = text_hash(body);
  request.http.body = body;
  request.http.limit = seconds(120);  // some stores copy the parts
  VACUFORM_TRY(answer, exchange(request));
  if (!good(answer) || answer.body.find("<CompleteMultipartUploadResult") == std::string::npos)
    return tl::make_unexpected(error_in(request, answer));
  return without_quotes(child_text(answer.body, "CompleteMultipartUploadResult", "ETag"));
}

Result<void> S3Client::abort_upload(const std::string& key, const std::string& upload) {
  Request request{"DELETE", key, false, {{"uploadId", upload}}};
  request.tries = 1;
  VACUFORM_TRY(answer, exchange(request));
  if (!good(answer) && answer.status != 404) return tl::make_unexpected(error_in(request, answer));
  return {};
}

Result<void> S3Client::abort_uploads(const std::string& key) {
  Request request{"GET", "", true, {{"uploads", ""}, {"prefix", address_.prefix + key}}};
  request.tries = 1;
  VACUFORM_TRY(answer, exchange(request));
  if (!good(answer)) return tl::make_unexpected(error_in(request, answer));
  pugi::xml_document document;
  if (!document.load_buffer(answer.body.data(), answer.body.size())) return {};
  for (const auto& upload : document.child("ListMultipartUploadsResult").children("Upload"))
    VACUFORM_CHECK(abort_upload(key, upload.child("UploadId").text().as_string()));
  return {};
}

Result<S3Object> S3Client::head(const std::string& key) {
  // A GET of no bytes would do as well, but some stores refuse it for an empty object.
  const Request request{"HEAD", key};
  VACUFORM_TRY(answer, exchange(request));
  if (!good(answer)) return tl::make_unexpected(error_in(request, answer));
  return S3Object{std::strtoull(header_of(answer, "content-length").c_str(), nullptr, 10),
                  without_quotes(header_of(answer, "etag"))};
}

Result<void> S3Client::get(const std::string& key, std::uint64_t offset, std::uint64_t bytes,
                           const std::string& etag, const std::function<void()>& begin, const Sink& sink) {
  Request request{"GET", key};
  if (bytes > 0)
    request.headers["range"] = "bytes=" + std::to_string(offset) + "-" + std::to_string(offset + bytes - 1);
  if (!etag.empty()) request.headers["if-match"] = std::string("\"").append(etag).append("\"");
  request.begin = begin;
  request.http.limit = time_for(bytes > 0 ? bytes : std::uint64_t{16} << 30);
  request.http.sink = [&](std::span<const std::uint8_t> piece) {
    return sink({reinterpret_cast<const char*>(piece.data()), piece.size()});
  };
  VACUFORM_TRY(answer, exchange(request));
  if (!good(answer)) return tl::make_unexpected(error_in(request, answer));
  if (bytes > 0 && answer.status != 206)
    return fail(Code::unavailable, "the object store does not give parts of objects", address_.endpoint,
                "use one that answers requests with Range");
  return {};
}

Result<void> S3Client::remove(const std::string& key) {
  Request request{"DELETE", key};
  request.tries = 1;
  VACUFORM_TRY(answer, exchange(request));
  if (good(answer)) return {};
  Error error = error_in(request, answer);
  if (error.code == Code::not_found) return {};
  return tl::make_unexpected(error);
}

Result<std::vector<S3Listed>> S3Client::list(const std::string& after) {
  Request request{"GET", "", true, {{"list-type", "2"}, {"prefix", address_.prefix}}};
  if (!after.empty()) request.query["start-after"] = address_.prefix + after;
  VACUFORM_TRY(answer, exchange(request));
  if (!good(answer)) return tl::make_unexpected(error_in(request, answer));
  pugi::xml_document document;
  if (!document.load_buffer(answer.body.data(), answer.body.size()))
    return fail(Code::unavailable, "the object store gave no list of the bucket", address_.endpoint);
  std::vector<S3Listed> found;
  for (const auto& item : document.child("ListBucketResult").children("Contents"))
    found.push_back({std::string(item.child("Key").text().as_string()).substr(address_.prefix.size()),
                     item.child("Size").text().as_ullong(),
                     from_rfc3339(item.child("LastModified").text().as_string())});
  return found;
}

}  // namespace vacuform
