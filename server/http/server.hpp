// The listener: accepts, reads, routes, answers.
//
// Every request passes these steps in order: the head (head.hpp), the checks of origin.hpp, the router with its limit
// on the body, the route's admission, the body, the route. A body up to 72 KiB is in memory before the route runs. The
// route reads a longer one as it arrives, and a body with a Content-Digest is checked meanwhile (digest.hpp). The
// server ignores peer addresses.
//
// A connection serves one request after another (HTTP/1.1 keep-alive). It is closed after an answer if its request was
// malformed, if its body was not read to the end, or if bytes after the request arrived before the answer was sent. So
// pipelined requests are not served, and bytes inside a request are never read as the next one.
//
// Slow clients occupy no thread, except for large bodies and for responses that stream or wait (message.hpp), which
// have separate limits and threads. A client that does not keep up with `limits` is disconnected. Beyond `connections`
// the idle and the slowest are closed to make room for new ones. When `streams` streams are active, the next one is
// refused with 503 and Retry-After; when one party has `streams_of_one`, its next one is refused with 429.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/http/connection.hpp"
#include "server/http/router.hpp"

namespace vacuform::http {

struct Answered {
  std::string method;
  std::string route;  // the pattern; empty if no route matched
  int status = 0;
  double seconds = 0;
  std::string fault;  // text of an exception; for the log only
};

struct ServerOptions {
  std::string host = "127.0.0.1";
  std::string front_host;   // name that a TLS front passes on, in lower case; empty: no front
  int port = 0;             // 0: any free port
  int connections = 1000;   // open at a time
  int threads = 64;         // concurrent requests; they wait for the disk, so more than cores
  int uploads = 32;         // large bodies at a time, besides
  int streams = 64;         // responses at a time that stream or wait, besides
  int streams_of_one = 16;  // of them for the same party (Response::party)
  Limits limits;
  // Creates the answer to a refusal; `request` has a path only if the head could be read. Must not wait.
  std::function<Response(const Request& request, const Refusal& refusal)> refuse;
  // Called before each answer is sent, from the thread that made it. Must not wait.
  std::function<void(const Answered&)> observe;
};

class Server {
 public:
  // Binds and serves. Errors: bad_usage if the address cannot be bound.
  static Result<std::unique_ptr<Server>> start(ServerOptions options, Router router);
  // Stops accepting, lets active requests finish for up to five seconds, then ends them.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  int port() const;
  int connections() const;  // currently open
  int streams() const;      // those among them that stream or wait

 private:
  class Loop;
  explicit Server(std::unique_ptr<Loop> loop);
  std::unique_ptr<Loop> loop_;
};

}  // namespace vacuform::http
