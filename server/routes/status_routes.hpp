// What an operator's machines ask: whether the service lives, whether it can work, and what it counts. On a listener of
// its own, so that it answers while clients hold every thread of the other one.
#pragma once

#include <filesystem>
#include <functional>

#include "server/messages/router.hpp"
#include "server/routes/metrics.hpp"
#include "server/store/store.hpp"

namespace vacuform {

// Outlives the listener.
struct Status {
  Store& store;
  Metrics& metrics;
  std::filesystem::path data;        // whose disk is looked at
  std::function<int()> connections;  // that the job listener serves at the moment
  int most_connections = 0;
  std::function<int()> streams = [] { return 0; };  // those among them that stream or wait
  int most_streams = 0;
};

// GET /healthz (the process answers; touches nothing that could block), GET /readyz (503 unless the store answers and
// its disk has room), GET /metrics.
http::Router status_routes(Status& status);

}  // namespace vacuform
