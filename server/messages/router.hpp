// Which function answers which request: a method and a pattern such as "/jobs/{id}/log?after&limit".
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/messages/message.hpp"

namespace vacuform::http {

using Handler = std::function<Result<Response>(Request&)>;
// For whom a request is served, and by what.
struct Admitted {
  std::string client;  // whose share it takes of the server (admission.hpp); empty: everybody's
  Handler handler;
};
// Says from the head alone whether the request may go on: before a byte of its body is waited for.
using Admission = std::function<Result<Admitted>(const Request&)>;

inline constexpr std::uint64_t small_body = 72
                                            << 10;  // a body up to this is held in memory until it is whole

Admission everybody(Handler handler);

struct Route {
  std::string method, pattern;
  Admission admission;
  std::uint64_t most_body = small_body;  // a longer body is refused by its Content-Length (413)
  std::vector<std::string> query = {};   // the names of the parameters that it takes
  std::string admits = {};               // whom, in words; for who lists the routes
};

class Router {
 public:
  // A piece "{name}" of the pattern matches one non-empty piece of a path and is captured under its name. Behind "?"
  // stand the names of the query parameters, separated by "&".
  void add(std::string method, std::string pattern, Handler handler);  // for everybody
  void add(Route route);

  struct Match {
    const Route* route = nullptr;
    std::map<std::string, std::string> captures;
    std::string allowed;  // the methods of the path, when it exists but not for this method
  };
  Match match(std::string_view method, std::string_view path) const;
  const std::vector<Route>& routes() const { return routes_; }

 private:
  std::vector<Route> routes_;
};

// Why no route serves the request, by its head alone: no route (404), another method (405), a query parameter that the
// route does not take or that is given twice (400), a body that is too long (413).
std::optional<Refusal> unserved(const Router::Match& match, const Request& request);

}  // namespace vacuform::http
