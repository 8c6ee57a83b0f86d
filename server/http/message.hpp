// Requests and responses as the routes see them; the HTTP library stays behind server.cpp.
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
#include "api/base/file.hpp"

namespace vacuform::http {

struct Header {
  std::string name, value;
};

// The bytes of a request's body, read from the socket as they are asked for.
class Body {
 public:
  virtual ~Body() = default;
  // At least one byte, or 0 at the end of the body. Errors: bad_usage when the client went away, out_of_time
  // when it is too slow, busy when too many large bodies arrive at a time.
  virtual Result<std::size_t> read(std::span<char> into) = 0;
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
  bool by_front = false;         // it came through the TLS front, by the front's name
  bool beyond_loopback = false;  // it arrived at another address than one of loopback
  Body* body = nullptr;          // never null inside a route

  // The first header of that name, whatever its case; empty when there is none.
  std::string_view header(std::string_view name) const;
  // A capture of the route's pattern.
  const std::string& at(const std::string& name) const { return captures.at(name); }
  std::string query_value(const std::string& name) const;
};

// The whole body. Errors: too_large above `limit`, and those of Body::read.
Result<std::string> read_text(Request& request, std::uint64_t limit);

// Bytes whose number is known and that can be read from any place: a file, or what is composed of files.
class Source {
 public:
  virtual ~Source() = default;
  // As File::read_at; one call at a time.
  virtual Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const = 0;
  // Called when the bytes turned out to be others than they should be.
  virtual void doubt() const {}
};

// A piece of a source as the body of a response. Of a whole source whose SHA-256 is known the last bytes are sent only if
// all of them have that hash; otherwise the connection breaks off before them.
struct SourceBody {
  std::shared_ptr<const Source> source;
  std::uint64_t offset = 0, bytes = 0;
  std::string sha256 = {};  // of a whole source; may be empty
};

// An error under an HTTP status of its own.
struct Refusal {
  int status = 400;
  Error error;
};

// Whether the client is still there and the server goes on. Whatever waits on a client's behalf asks it about every
// second.
using Going = std::function<bool()>;

// A body that is made while it is sent. Called again and again: waits a second at most for what comes next and gives its
// bytes, an empty text when nothing came, none at the end.
using Producer = std::function<std::optional<std::string>()>;

struct Response;
// A response that has to wait for something before it is known. Ends soon after `going` has become false.
using Waiter = std::function<Result<Response>(const Going& going)>;

struct Response {
  int status = 200;
  std::vector<Header> headers;
  std::string media_type;
  std::string text;
  std::optional<Refusal> refusal;  // in place of all but the headers: its answer gets these
  std::optional<SourceBody> file;  // in place of text
  Producer stream;    // in place of both, until the producer ends, the client leaves or the server stops
  Waiter waiter;      // in place of everything else
  std::string party;  // for whom a stream or a waiter is; each has so many (ServerOptions)

  void set(std::string name, std::string value) { headers.push_back({std::move(name), std::move(value)}); }
};

Response text_response(std::string media_type, std::string text, int status = 200);

// A whole file, or the range of it that the request asks for (206, 416), or 304 when the client has it
// already, or 412 when If-Match wants another one. `etag` without quotes. One range at a time; a request for several gets the whole file, as RFC 9110
// allows. `sha256` of the whole file, where it is known, goes out as Repr-Digest; Content-Digest is that of the bytes that
// are sent, left out of parts beyond 16 MiB, which would have to be read twice.
Result<Response> file_response(const Request& request, File file, std::string media_type,
                               const std::string& etag, const std::string& sha256 = {});
// The same of any source of that many bytes.
Result<Response> source_response(const Request& request, std::shared_ptr<const Source> source,
                                 std::uint64_t bytes, std::string media_type, const std::string& etag,
                                 const std::string& sha256 = {});

// The refusal (412) of a request whose If-Match does not name this entity tag (with its quotes; empty: there is nothing yet),
// or that changes something which If-None-Match names; none otherwise (RFC 9110, section 13).
std::optional<Refusal> unmet_precondition(const Request& request, const std::string& quoted);
Response refused_response(Refusal refusal);

}  // namespace vacuform::http
