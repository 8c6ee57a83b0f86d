// The copy of a store in use, for administrators; vacuform-server backup asks for it.
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "server/http/problem.hpp"
#include "server/jobs/job_json.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;

namespace {

Result<Response> make_backup(Service& service, Request& request, const Caller& caller) {
  VACUFORM_TRY(body, read_object(request, 4096));
  if (!body.contains("to") || !body["to"].is_string())
    return fail(Code::bad_usage, "the body names no folder", "to", "send {\"to\": \"/the/folder\"}");
  Response response;
  response.waiter = [&service, to = body["to"].get<std::string>(),
                     token = caller.token](const http::Going& going) -> Result<Response> {
    VACUFORM_TRY(report, service.store.backup(to, going));
    log_event("backup-made", {{"jobs", report.jobs},
                              {"blobs", report.blobs},
                              {"damaged", report.damaged.size()},
                              {"token", token}});
    return json_response(backup_json(report));
  };
  return response;
}

}  // namespace

void add_backup_routes(http::Router& router, Service& service) {
  add_guarded(router, service, Scope::admin, "POST", "/api/v1/backup", make_backup);
}

}  // namespace vacuform
