// What the service takes, how long it waits, and what its workers' jobs are kept from.
#include <nlohmann/json.hpp>

#include "api/job_limits.hpp"
#include "server/http/server.hpp"
#include "server/jobs/submission.hpp"
#include "server/jobs/submission_form.hpp"
#include "server/messages/problem.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;
using nlohmann::ordered_json;

namespace {

ordered_json workers_json(const Workers& workers) {
  ordered_json list = ordered_json::array();
  for (const SeenWorker& worker : workers.lately(wall_clock())) {
    ordered_json object = {{"worker", worker.name}};
    object.update(sandbox_json(worker));
    list.push_back(std::move(object));
  }
  return list;
}

}  // namespace

void add_limits_routes(http::Router& router, Service& service) {
  add_guarded(router, service, Scope::read, "GET", "/api/v1/limits",
              [](Service& s, Request&, const Caller&) -> Result<Response> {
                const http::ServerOptions server;
                const http::Limits& limits = server.limits;
                ordered_json object;
                for (const InputKind& kind : input_kinds)
                  object[std::string(kind.name) + "_bytes"] = kind.most_bytes;
                object.update({{"settings_bytes", largest_settings},
                               {"scan_triangles", job_limits.scan_triangles},
                               {"scan_vertices", job_limits.scan_vertices},
                               {"scan_components", job_limits.scan_components},
                               {"pattern_pixels", job_limits.pattern_pixels},
                               {"sheet_cells", job_limits.sheet_cells},
                               {"job_seconds", job_limits.seconds},
                               {"job_cpu_seconds", job_limits.cpu_seconds},
                               {"job_memory_bytes", job_limits.memory_bytes},
                               {"artifact_bytes", largest_artifact},
                               {"head_bytes", limits.head_bytes},
                               {"head_lines", limits.head_lines},
                               {"head_seconds", limits.head_time.count() / 1000},
                               {"wait_seconds", limits.wait.count() / 1000},
                               {"body_bytes_per_second", limits.slowest_body},
                               {"lease_seconds", s.lease_seconds},
                               {"wait_for_job_seconds", most_wait_seconds},
                               {"requests_of_owner", server.requests_of_one},
                               {"bodies", server.bodies},
                               {"bodies_of_owner", server.bodies_of_one},
                               {"streams", server.streams},
                               {"streams_of_owner", server.streams_of_one},
                               {"uploads", most_uploads},
                               {"uploads_bytes", most_upload_bytes},
                               {"upload_seconds", upload_lifetime / 1000},
                               {"queued_jobs", StoreOptions{}.most_queued},
                               {"queued_jobs_of_owner", StoreOptions{}.most_queued_by_owner},
                               {"profiles", most_profiles},
                               {"workers", workers_json(s.workers)}});
                return json_response(object);
              });
}

}  // namespace vacuform
