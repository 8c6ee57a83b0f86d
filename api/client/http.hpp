// The one door to libcurl: a request out, a response in. No knowledge of jobs.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "api/base/error.hpp"

namespace vacuform {

struct HttpResponse {
  int status = 0;
  std::map<std::string, std::string> headers;  // names in lower case; of a repeated header, the last
  std::string body;                            // empty when a sink took it
};

// One part of a multipart/form-data body: a file, streamed from disk, or a text.
struct FormPart {
  std::string name;
  std::filesystem::path file;  // sent under its own last component; empty: `text` is sent
  std::string text;
};

struct HttpRequest {
  std::string method = "GET";
  std::string path;  // from the server's root, "/api/v1/jobs"
  std::map<std::string, std::string> headers = {};
  std::string body = {};  // sent when there is neither a file nor a form
  int file =
      -1;  // an open file, of which `file_bytes` bytes from `file_offset` on are streamed in place of `body`
  std::uint64_t file_bytes = 0, file_offset = 0;
  std::vector<FormPart> form = {};                               // multipart/form-data in place of both
  std::function<bool(std::span<const std::uint8_t>)> sink = {};  // takes a 2xx body in pieces; false gives up
  // Called several times a second with the bytes sent and those to send in all (0: unknown); false gives up.
  std::function<bool(std::uint64_t sent, std::uint64_t total)> going = {};
  std::chrono::seconds limit{
      0};  // for the whole exchange; 0: none, but a transfer that stands still for 30 s is given up
};

// A server's base URL, http or https, with the bearer token that goes with every request (none when empty).
// Movable, not copyable; used from one thread at a time. Never follows redirects. Error bodies and other bodies
// without a sink are held in memory, 4 MiB at most.
class Http {
 public:
  // Errors: bad_usage when the URL is not http:// or https://, or when a token would leave this machine in plain HTTP.
  static Result<Http> to(const std::string& url, const std::string& token = {});
  Http(Http&&) noexcept;
  Http& operator=(Http&&) noexcept;
  ~Http();

  // The base URL without a slash at its end.
  const std::string& url() const { return url_; }

  // Gives the response whatever its status. Errors: unavailable (no connection, broken off, too slow), cancelled
  // (`going` or the sink gave up), unreadable (a file to send), too_large (a body held in memory).
  Result<HttpResponse> send(const HttpRequest& request);

 private:
  Http();
  struct Handle;
  std::unique_ptr<Handle> handle_;
  std::string url_;
  std::string token_;
  bool loopback_ = false;
};

// What a response other than 2xx says: its problem document (RFC 9457) where it has one, the status otherwise.
Error error_of(const HttpResponse& response);

}  // namespace vacuform
