// The routes: what the server answers, where, and to whom.
#pragma once

#include <functional>
#include <string>

#include "server/access/access.hpp"
#include "server/http/router.hpp"
#include "server/jobs/uploads.hpp"
#include "server/jobs/workers.hpp"
#include "server/store/store.hpp"

namespace vacuform {

class KeptFolder;

inline constexpr int most_wait_seconds = 60;  // of GET /api/v1/jobs/{id}?wait=

// What every route works on. Outlives the listener.
struct Service {
  Store& store;
  Access& access;
  Workers& workers;
  Uploads& uploads;
  int lease_seconds = 30;
  int heartbeat_seconds = 1;
  KeptFolder* kept = nullptr;  // none: workers keep nothing
};

void add_job_routes(http::Router& router, Service& service);     // /api/v1/jobs..., for people and programs
void add_worker_routes(http::Router& router, Service& service);  // /api/v1/leases..., for workers
void add_token_routes(http::Router& router, Service& service);   // /api/v1/tokens..., for administrators
void add_event_routes(http::Router& router, Service& service);   // /api/v1/jobs/{id}, waiting, and its events
void add_upload_routes(http::Router& router, Service& service);  // /api/v1/uploads...: tus
void add_scan_routes(http::Router& router, Service& service);    // /api/v1/scans...
void add_profile_routes(http::Router& router, Service& service);  // /api/v1/profiles...
void add_limits_routes(http::Router& router, Service& service);   // /api/v1/limits
void add_page_routes(http::Router& router, Service& service);     // /, /jobs/{id}: HTML
void add_sign_in_routes(http::Router& router, Service& service);  // /sign-in, /sign-out: HTML
void add_public_routes(http::Router& router, Service& service);   // what is about the service itself
void add_backup_routes(http::Router& router, Service& service);   // /api/v1/backup, for administrators
http::Router all_routes(Service& service);

// Adds a route that only a caller with this scope reaches, and whose body has at most so many bytes. The token is checked
// before the body is waited for.
using GuardedHandler = std::function<Result<http::Response>(Service&, http::Request&, const Caller&)>;
void add_guarded(http::Router& router, Service& service, Scope scope, std::string method, std::string pattern,
                 GuardedHandler handler, std::uint64_t most_body = http::small_body);

// The job of the route's {id}, if the caller may see it; not_found otherwise, so that nobody learns of another's jobs.
Result<Job> job_for(Service& service, const http::Request& request, const Caller& caller);

// The upload or the scan of that id, if the caller may see it.
Result<StoredUpload> upload_for(Service& service, const std::string& id, const Caller& caller);
Result<StoredScan> scan_for(Service& service, const std::string& id, const Caller& caller);

// A number of the query, or the one that stands for none. Errors: bad_usage.
Result<std::int64_t> query_number(const http::Request& request, const std::string& name,
                                  std::int64_t fallback, std::int64_t least, std::int64_t most);
// The `cursor` of a list's query, empty where there is none. Errors: bad_usage, when no list can have given it.
Result<std::string> page_cursor(const http::Request& request);

// The answer to a refused request: a page for a browser, otherwise a problem.
http::Response refuse(const http::Request& request, const http::Refusal& refusal);

}  // namespace vacuform
