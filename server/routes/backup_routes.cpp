// The copy of a store in use and the orphans of its bucket, for administrators; vacuform-server backup and orphans ask for
// them.
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "server/jobs/job_json.hpp"
#include "server/messages/problem.hpp"
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

constexpr double longest_hours = 24.0 * 3650;

Result<double> number_in(const nlohmann::json& body, const char* name, double otherwise, double most) {
  if (!body.contains(name)) return otherwise;
  if (body[name].is_number() && body[name] >= 0 && body[name] <= most) return body[name].get<double>();
  return fail(Code::bad_usage, "not a number in its range", name, "see the description of the API");
}

Result<Response> find_orphans(Service& service, Request& request, const Caller& caller) {
  VACUFORM_TRY(body, read_object(request, 4096));
  if (body.contains("delete") && !body["delete"].is_boolean())
    return fail(Code::bad_usage, "not true or false", "delete", "send {\"delete\": true} to delete them");
  OrphanSearch search;
  search.remove = body.value("delete", false);
  VACUFORM_TRY(hours, number_in(body, "older_than_hours", 48, longest_hours));
  search.older_than = static_cast<Millis>(hours * 3'600'000);
  VACUFORM_TRY(most, number_in(body, "most_percent", search.most, 100));
  search.most = most;
  Response response;
  response.waiter = [&service, search, token = caller.token](const http::Going& going) -> Result<Response> {
    VACUFORM_TRY(report, service.store.orphans(search, going));
    if (report.deleted > 0)
      log_event("orphans-deleted", {{"objects", report.deleted}, {"bytes", report.bytes}, {"token", token}});
    return json_response(orphans_json(report));
  };
  return response;
}

}  // namespace

void add_backup_routes(http::Router& router, Service& service) {
  add_guarded(router, service, Scope::admin, "POST", "/api/v1/backup", make_backup);
  add_guarded(router, service, Scope::admin, "POST", "/api/v1/orphans", find_orphans);
}

}  // namespace vacuform
