// Requests and responses as the routes see them.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/error.hpp"

namespace vacuform::http {

struct Header {
  std::string name, value;
};

// The bytes of a request's body as they arrive.
class Body {
 public:
  // Takes the next bytes. An error ends the reading and is given to the caller.
  using Taker = std::function<Result<void>(std::string_view)>;

  virtual ~Body() = default;
  // Reads the whole body; call it once. Errors: bad_usage if the client disconnected, out_of_time if it is too slow, and
  // those of `take`. What came before an error has been taken.
  virtual Result<void> read(const Taker& take) = 0;
};

// A body that is in memory, as much of it as came.
class HeldBody final : public Body {
 public:
  explicit HeldBody(Body& body);
  Result<void> read(const Taker& take) override;

 private:
  std::string text_;
  Result<void> whole_;
};

struct Request {
  std::string method;                             // GET also for HEAD
  std::string path;                               // percent-decoded
  std::multimap<std::string, std::string> query;  // as sent
  std::vector<Header> headers;
  std::map<std::string, std::string> captures;  // of the route's pattern
  std::string id;                               // for the log: the client's own, or a random one
  std::uint64_t content_length = 0;
  bool head_only = false;        // a HEAD request, which `method` calls GET
  bool by_front = false;         // it came through the TLS front, with the front's name
  bool beyond_loopback = false;  // it arrived at an address that is not on loopback
  Body* body = nullptr;          // never null inside a route

  // The first header of that name, in any case; empty if it is absent.
  std::string_view header(std::string_view name) const;
  bool has(std::string_view name) const;
  // A capture of the route's pattern.
  const std::string& at(const std::string& name) const { return captures.at(name); }
  std::string query_value(const std::string& name) const;
};

// The whole body. Errors: too_large above `limit`, and those of Body::read.
Result<std::string> read_text(Request& request, std::uint64_t limit);

// Bytes of known length with random access: a file, or a sequence assembled from files.
class Source {
 public:
  virtual ~Source() = default;
  // Bytes from `offset` on, at most the span's size; 0 only at the end. One call at a time.
  virtual Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const = 0;
  // Called if the bytes are not the expected ones.
  virtual void invalidate() const {}
};

// A piece of a source as the body of a response. If the whole source is sent and its SHA-256 is known, the last bytes
// are sent only if everything matches that hash; otherwise the connection is closed before them.
struct SourceBody {
  std::shared_ptr<const Source> source;
  std::uint64_t offset = 0, bytes = 0;
  std::string sha256 = {};  // of a whole source; may be empty
};

// An error with a specific HTTP status.
struct Refusal {
  int status = 400;
  Error error;
};

// Whether the client is still connected and the server is not stopping. Code that waits for a client calls it about
// once per second.
using Going = std::function<bool()>;

// A body that is generated while it is sent. Called repeatedly: waits at most a second for the next piece and returns
// its bytes, an empty text if there was none, nullopt at the end.
using Producer = std::function<std::optional<std::string>()>;

struct Response;
// A response that must wait for an event. Ends soon after `going` has become false.
using Waiter = std::function<Result<Response>(const Going& going)>;

struct Response {
  int status = 200;
  std::vector<Header> headers;
  std::string media_type;
  std::string text;
  std::optional<Refusal> refusal;  // replaces everything but the headers, which its answer gets
  std::optional<SourceBody> file;  // in place of text
  Producer stream;  // in place of both, until the producer ends, the client leaves or the server stops
  Waiter waiter;    // replaces everything else

  void set(std::string name, std::string value) { headers.push_back({std::move(name), std::move(value)}); }
};

// With those of `more` whose names the response does not have.
Response with_headers(Response response, const std::vector<Header>& more);

Response text_response(std::string media_type, std::string text, int status = 200);

// A whole source of that many bytes, or the range that the request asks for (206, 416), or 304 if the client already has
// it, or 412 if If-Match names another version. `etag` without quotes. Only one range per request; a request for several
// gets everything, as RFC 9110 allows. `sha256` of the whole source, if known, is sent as Repr-Digest. Content-Digest is
// the digest of the bytes sent; it is omitted for parts above 16 MiB, which would have to be read twice.
Result<Response> source_response(const Request& request, std::shared_ptr<const Source> source,
                                 std::uint64_t bytes, std::string media_type, const std::string& etag,
                                 const std::string& sha256 = {});

// The refusal (412) of a request whose If-Match does not name this entity tag (with its quotes; empty: the resource
// does not exist yet), or that changes something which If-None-Match names; otherwise nullopt (RFC 9110, section 13).
std::optional<Refusal> unmet_precondition(const Request& request, const std::string& quoted);
Response refused_response(Refusal refusal);

}  // namespace vacuform::http
