// The routes: what the server answers, and where.
#pragma once

#include <string>

#include "server/http/router.hpp"
#include "server/store/store.hpp"

namespace vacuform {

// What every route works on. Outlives the listener.
struct Service {
  Store& store;
  std::string worker_token;  // what a worker must show
  int lease_seconds = 30;
  int heartbeat_seconds = 1;
};

void add_job_routes(http::Router& router, Service& service);     // /api/v1/jobs..., for everyone
void add_worker_routes(http::Router& router, Service& service);  // /api/v1/leases..., for workers
void add_page_routes(http::Router& router, Service& service);    // /, /jobs/{id}, /problems/{slug}: HTML
http::Router all_routes(Service& service);

// The answer to a refused request: a page for a browser, otherwise a problem.
http::Response refuse(const http::Request& request, const http::Refusal& refusal);

}  // namespace vacuform
