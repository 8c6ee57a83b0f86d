// The routes: what the server answers, where, and to whom.
#pragma once

#include "server/jobs/service.hpp"
#include "server/messages/router.hpp"

namespace vacuform {

inline constexpr int most_wait_seconds = 60;  // of GET /api/v1/jobs/{id}?wait=

void add_job_routes(http::Router& router, Service& service);     // /api/v1/jobs..., for people and programs
void add_worker_routes(http::Router& router, Service& service);  // /api/v1/leases..., for workers
void add_token_routes(http::Router& router, Service& service);   // /api/v1/tokens..., for administrators
void add_event_routes(http::Router& router, Service& service);   // /api/v1/jobs/{id}, waiting, and its events
void add_upload_routes(http::Router& router, Service& service);  // /api/v1/uploads...: tus
void add_scan_routes(http::Router& router, Service& service);    // /api/v1/scans...
void add_profile_routes(http::Router& router, Service& service);  // /api/v1/profiles...
void add_session_routes(http::Router& router, Service& service);  // /api/v1/session
void add_limits_routes(http::Router& router, Service& service);   // /api/v1/limits
void add_page_routes(http::Router& router, Service& service);     // /, /jobs, /jobs/{id}: HTML
void add_sign_in_routes(http::Router& router, Service& service);  // /sign-in, /sign-out: HTML
void add_about_routes(http::Router& router);                      // what is about the service itself
void add_service_routes(http::Router& router, Service& service);  // /api/v1/service, for administrators
void add_backup_routes(http::Router& router, Service& service);   // /api/v1/backup, for administrators
http::Router all_routes(Service& service);

// The answer to a refused request: a page for a browser, otherwise a problem.
http::Response refuse(const http::Request& request, const http::Refusal& refusal);

}  // namespace vacuform
