// The listener: accepts, reads, routes, answers.
//
// Every request passes, in this order: the head (head.hpp), the checks of origin.hpp, the router with its
// limit on the body, the route's admission, the body, the route. A body up to 72 KiB is in memory before the
// route runs; a longer one is read by the route as it comes, and a body whose Content-Digest was sent is
// checked meanwhile (digest.hpp). Peer addresses are not looked at.
//
// A connection serves one request after another (HTTP/1.1 keep-alive). It is closed after an answer when its
// request was refused for its form, when its body was not read to the end, and when bytes behind the request
// came before the answer was sent: pipelined requests are not served, and what a request carries along is
// never read as the next one.
//
// Clients that are slow cost no thread, but for large bodies and for responses that stream or wait
// (message.hpp), which have bounds and threads of their own. A client must keep up with `limits`, or is
// closed; beyond `connections` the idle and the slowest are closed to make room for new ones. When `streams`
// streams are under way the next one is refused with 503 and Retry-After, when `streams_of_one` are one
// party's its next one with 429.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/http/connection.hpp"
#include "server/http/router.hpp"

namespace vacuform::http {

struct Answered {
  std::string method;
  std::string route;  // the pattern; empty when there was none
  int status = 0;
  double seconds = 0;
  std::string fault;  // what an exception said; for the log alone
};

struct ServerOptions {
  std::string host = "127.0.0.1";
  std::string front_host;   // under which a TLS front passes requests on, in lower case; empty: there is none
  int port = 0;             // 0: any free one
  int connections = 1000;   // open at a time
  int threads = 64;         // requests at a time; they wait for the disk, so more than cores
  int uploads = 32;         // large bodies at a time, besides
  int streams = 64;         // responses at a time that stream or wait, besides
  int streams_of_one = 16;  // of them for the same party (Response::party)
  Limits limits;
  // Makes the answer to a refusal; `request` has a path only if the head could be read. Must not wait.
  std::function<Response(const Request& request, const Refusal& refusal)> refuse;
  // Called before each answer is sent, from the thread that made it. Must not wait.
  std::function<void(const Answered&)> observe;
};

class Server {
 public:
  // Binds and serves. Errors: bad_usage when the address cannot be bound.
  static Result<std::unique_ptr<Server>> start(ServerOptions options, Router router);
  // Stops accepting, lets requests under way end within five seconds, then ends them.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  int port() const;
  int connections() const;  // open at the moment
  int streams() const;      // those among them that stream or wait

 private:
  class Loop;
  explicit Server(std::unique_ptr<Loop> loop);
  std::unique_ptr<Loop> loop_;
};

}  // namespace vacuform::http
