// The state of the service, for administrators; the length of its queue, for programs that start workers.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "api/version.hpp"
#include "server/messages/problem.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;
using nlohmann::ordered_json;

namespace {

// The workers that asked for a job lately, and those that hold one. Of the second, if the server was started since they
// asked, the sandbox is not known.
ordered_json all_workers_json(const Workers& workers, const StoreStatus& status) {
  std::map<std::string, ordered_json> all;
  for (const SeenWorker& worker : workers.lately(wall_clock())) {
    ordered_json object = {{"worker", worker.name}, {"last_seen", rfc3339(worker.at)}, {"job", nullptr}};
    object.update(sandbox_json(worker));
    all[worker.name] = std::move(object);
  }
  for (const WorkingWorker& worker : status.working) {
    ordered_json& object = all[worker.name];
    if (object.is_null())
      object = {{"worker", worker.name},
                {"last_seen", ""},
                {"job", nullptr},
                {"sandbox", nullptr},
                {"lacks", nullptr}};
    object["last_seen"] = std::max(object["last_seen"].get<std::string>(), rfc3339(worker.heard));
    object["job"] = worker.job;
  }
  ordered_json list = ordered_json::array();
  for (auto& [name, object] : all) list.push_back(std::move(object));
  return list;
}

std::size_t number_of(const StoreStatus& status, JobState state) {
  return status.counts[static_cast<std::size_t>(state)];
}

// Age of the queued job that was created first, or null.
ordered_json oldest_seconds(const StoreStatus& status) {
  if (!status.oldest_queued) return nullptr;
  return std::max<Millis>(0, wall_clock() - *status.oldest_queued) / 1000;
}

// Counts alone, of nobody in particular: a read-only token of an owner without jobs is enough.
Result<Response> show_queue(Service& service, Request&, const Caller&) {
  VACUFORM_TRY(status, service.store.status());
  const std::size_t queued = number_of(status, JobState::queued);
  const std::size_t running = number_of(status, JobState::running) + number_of(status, JobState::cancelling);
  return json_response({{"queued", queued},
                        {"running", running},
                        {"oldest_seconds", oldest_seconds(status)},
                        {"wanted_workers", queued + running}});
}

Result<Response> show_service(Service& service, Request&, const Caller&) {
  VACUFORM_TRY(status, service.store.status());
  ordered_json jobs = ordered_json::object();
  for (std::size_t i = 0; i < status.counts.size(); ++i)
    jobs[std::string(job_state_names[i])] = status.counts[i];
  return json_response(
      {{"version", version},
       {"uptime_seconds", (boot_clock() - service.started) / 1000},
       {"schema", status.schema},
       {"jobs", std::move(jobs)},
       {"queue",
        {{"length", number_of(status, JobState::queued)}, {"oldest_seconds", oldest_seconds(status)}}},
       {"workers", all_workers_json(service.workers, status)},
       {"disk",
        {{"total_bytes", status.disk.total},
         {"free_bytes", status.disk.free},
         {"kept_free_bytes", status.disk.kept_free}}},
       {"last_backup", status.last_backup ? ordered_json(rfc3339(*status.last_backup)) : ordered_json()}});
}

}  // namespace

void add_service_routes(http::Router& router, Service& service) {
  add_guarded(router, service, Scope::read, "GET", "/api/v1/queue", show_queue);
  add_guarded(router, service, Scope::admin, "GET", "/api/v1/service", show_service);
}

}  // namespace vacuform
