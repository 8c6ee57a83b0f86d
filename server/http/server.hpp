// The listener: accepts, vets, routes, answers. The one place behind which an HTTP library (cpp-httplib)
// stands.
//
// Every request passes, in this order: the limits of connection.hpp, the checks of origin.hpp, the router,
// the route. A body whose Content-Digest was sent is checked while the route reads it (digest.hpp). A connection serves one request. Peer addresses are not looked at, and no header of a client
// reaches the library.
//
// A response that streams or waits (message.hpp) keeps its thread, so these have a bound and threads of their own: when
// `streams` of them are under way the next one is refused with 503 and Retry-After, when `streams_of_one` are one party's
// its next one with 429, and `threads` are always left for the other requests.
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
  int threads = 64;         // requests at a time; a thread waits for its client, so more than cores
  int streams = 64;         // responses at a time that stream or wait, besides
  int streams_of_one = 16;  // of them for the same party (Response::party)
  Limits limits;
  // Makes the answer to a refusal; `request` has a path only if the head could be read.
  std::function<Response(const Request& request, const Refusal& refusal)> refuse;
  // Called after each answer, from the thread that gave it.
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
  int connections() const;  // being served at the moment
  int streams() const;      // those among them that stream or wait

 private:
  class Library;
  explicit Server(std::unique_ptr<Library> library);
  std::unique_ptr<Library> library_;
};

}  // namespace vacuform::http
