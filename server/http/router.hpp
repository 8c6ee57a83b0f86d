// Which function answers which request: a method and a pattern such as "/jobs/{id}".
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/message.hpp"

namespace vacuform::http {

using Handler = std::function<Result<Response>(Request&)>;

struct Route {
  std::string method, pattern;
  Handler handler;
};

class Router {
 public:
  // A piece "{name}" of the pattern matches one non-empty piece of a path and is captured under its name.
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

}  // namespace vacuform::http
