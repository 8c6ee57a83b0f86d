#include "server/routes/routes.hpp"

#include "server/messages/problem.hpp"
#include "server/pages/pages.hpp"

namespace vacuform {

using http::Request;
using http::Response;

http::Router all_routes(Service& service) {
  http::Router router;
  add_job_routes(router, service);
  add_worker_routes(router, service);
  add_event_routes(router, service);
  add_upload_routes(router, service);
  add_scan_routes(router, service);
  add_profile_routes(router, service);
  add_token_routes(router, service);
  add_session_routes(router, service);
  add_limits_routes(router, service);
  add_service_routes(router, service);
  add_backup_routes(router, service);
  add_page_routes(router, service);
  add_sign_in_routes(router, service);
  add_about_routes(router);
  return router;
}

Response refuse(const Request& request, const http::Refusal& refusal) {
  const bool page =
      !request.path.starts_with("/api/") && request.header("Accept").find("text/html") != std::string::npos;
  if (!page) return problem_response(refusal.error, refusal.status);
  if (refusal.error.code == Code::unauthorized && request.method == "GET") return see_other("/sign-in");
  return html_response(refused_page(refusal));
}

}  // namespace vacuform
