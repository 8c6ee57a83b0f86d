#include "server/routes/status_routes.hpp"

#include <nlohmann/json.hpp>

#include "api/version.hpp"
#include "server/messages/problem.hpp"
#include "server/routes/guard.hpp"

namespace vacuform {

using http::Request;
using http::Response;

namespace {

std::uintmax_t room(const Status& status) {
  std::error_code ec;
  const auto space = std::filesystem::space(status.data, ec);
  return ec ? 0 : space.available;
}

Result<Response> ready(const Status& status) {
  VACUFORM_TRY(store, status.store.status());
  if (room(status) == 0 || !status.store.room_for(0))
    return fail(Code::unavailable, "the disk of the data folder is nearly full", "--data",
                "delete jobs that are no longer needed, or move the folder to a larger disk");
  return json_response({{"status", "ready"}, {"durability", store.durability}});
}

Result<Response> metrics(const Status& status) {
  std::vector<Family> families = process_families();
  const auto gauge = [&](const char* name, const char* help, double value) {
    families.push_back({name, help, "gauge", {{name, "", value}}});
  };
  families.push_back({"vacuform_build_info",
                      "The version that runs",
                      "gauge",
                      {{"vacuform_build_info", "version=\"" + std::string(version) + "\"", 1}}});
  gauge("vacuform_http_connections", "Connections being served", status.connections());
  gauge("vacuform_http_connections_limit", "Connections that can be served at a time",
        status.most_connections);
  gauge("vacuform_http_streams", "Connections among them that stream or wait", status.streams());
  gauge("vacuform_http_streams_limit", "Connections that can stream or wait at a time", status.most_streams);
  gauge("vacuform_store_free_bytes", "Free space on the disk of the data folder",
        static_cast<double>(room(status)));
  if (const auto store = status.store.status()) {
    Family jobs{"vacuform_jobs", "Jobs in the store, by state", "gauge", {}};
    for (std::size_t i = 0; i < store->counts.size(); ++i)
      jobs.samples.push_back({"vacuform_jobs", "state=\"" + std::string(job_state_names[i]) + "\"",
                              static_cast<double>(store->counts[i])});
    families.push_back(std::move(jobs));
    gauge("vacuform_store_damaged_jobs", "Jobs whose rows were found damaged since the start",
          static_cast<double>(store->damaged_jobs));
    gauge("vacuform_store_damaged_files", "Stored files that were found damaged or missing",
          static_cast<double>(store->damaged_files));
    gauge("vacuform_store_files_without_job", "Files in the data folder that no job names",
          static_cast<double>(store->unnamed_files));
    if (store->last_check)
      gauge("vacuform_store_last_check_timestamp_seconds", "End of the last check of all that is stored",
            static_cast<double>(*store->last_check) / 1000);
    if (store->oldest_transaction_seconds)
      gauge("vacuform_database_oldest_transaction_seconds",
            "Age of the oldest transaction in PostgreSQL that keeps it from removing dead rows",
            *store->oldest_transaction_seconds);
  }
  Response response =
      http::text_response("text/plain; version=0.0.4; charset=utf-8", status.metrics.text(families));
  response.set("Cache-Control", "no-store");
  return response;
}

}  // namespace

http::Router status_routes(Status& status) {
  Status* const s = &status;
  http::Router router;
  add_public(router, "GET", "/healthz", [](Request&) -> Result<Response> {
    return json_response({{"status", "ok"}});
  });
  add_public(router, "GET", "/readyz", [s](Request&) { return ready(*s); });
  add_public(router, "GET", "/metrics", [s](Request&) { return metrics(*s); });
  return router;
}

}  // namespace vacuform
