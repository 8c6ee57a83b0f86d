// Which function answers which request: a method and a pattern such as "/jobs/{id}/log?after&limit".
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/message.hpp"

namespace vacuform::http {

using Handler = std::function<Result<Response>(Request&)>;

struct Route {
  std::string method, pattern;     // without the query
  std::vector<std::string> query;  // the names of the parameters that it takes
  Handler handler;
};

class Router {
 public:
  // A piece "{name}" of the pattern matches one non-empty piece of a path and is captured under its name. Behind "?"
  // stand the names of the query parameters, separated by "&".
  void add(std::string method, std::string pattern, Handler handler);

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

// The refusal of a query with a parameter that the route does not take, or with one that is given twice.
std::optional<Refusal> query_refusal(const Route& route,
                                     const std::multimap<std::string, std::string>& query);

}  // namespace vacuform::http
