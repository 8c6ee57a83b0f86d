// The listener: httplib::Server (cpp-httplib) accepts, gives each connection a thread, reads bodies and writes answers.
//
// Every request passes these steps in order: the head (head.hpp), the checks of origin.hpp, the router with its limit
// on the body, the route's admission, the share of its client, the body, a turn, the route. A body up to 72 KiB is in
// memory before the turn comes. The route reads a longer one as it arrives, in a slot for large bodies and without a
// turn. A body with a Content-Digest is checked meanwhile (digest.hpp). The server ignores peer addresses.
// A connection serves one request, and no byte behind it is read as another.
//
// Slow clients occupy a thread, so clients that do not keep up with `limits` are disconnected, and beyond `connections`
// the slowest make room for new ones. No client has more than its share of anything (admission.hpp): then it gets 429, and
// 503 if all of it is taken, with Retry-After.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/messages/head.hpp"
#include "server/messages/router.hpp"

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
  std::string front_host;     // name that a TLS front passes on, in lower case; empty: no front
  int port = 0;               // 0: any free port
  int connections = 1000;     // open at a time; each occupies a thread
  int requests_of_one = 250;  // of them for the same client
  int turns = 16;    // requests of one route that are worked on at a time; half of them for the same client
  int bodies = 256;  // large bodies at a time
  int bodies_of_one = 16;   // of them for the same client
  int streams = 64;         // responses at a time that stream or wait
  int streams_of_one = 16;  // of them for the same client
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
  class Adapter;
  explicit Server(std::unique_ptr<Adapter> adapter);
  std::unique_ptr<Adapter> adapter_;
};

}  // namespace vacuform::http
