#include "server/routes/job_changes.hpp"

#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "server/jobs/job_json.hpp"

namespace vacuform {

using http::Request;
using http::Response;

JobGuard precondition(const Request& request, std::optional<http::Refusal>& refusal) {
  return [&request, &refusal](const Job& now) {
    refusal = http::unmet_precondition(request, etag_of(now));
    return !refusal;
  };
}

GuardedHandler cancelling(JobAnswer answer) {
  return [answer](Service& service, const Request& request, const Caller& caller) -> Result<Response> {
    VACUFORM_TRY(seen, job_for(service, request.at("id"), caller));
    std::optional<http::Refusal> refusal;
    auto cancelled = service.store.cancel(seen.id, precondition(request, refusal));
    if (refusal) return http::refused_response(std::move(*refusal));
    VACUFORM_TRY(job, std::move(cancelled));
    log_event("job-cancel-asked", {{"job", job.id}, {"state", name(job.state)}, {"token", caller.token}});
    return answer(job);
  };
}

GuardedHandler deleting(JobAnswer answer) {
  return [answer](Service& service, const Request& request, const Caller& caller) -> Result<Response> {
    VACUFORM_TRY(job, job_for(service, request.at("id"), caller));
    std::optional<http::Refusal> refusal;
    const auto removed = service.store.remove(job.id, precondition(request, refusal));
    if (refusal) return http::refused_response(std::move(*refusal));
    VACUFORM_CHECK(removed);
    log_event("job-deleted", {{"job", job.id}, {"token", caller.token}});
    return answer(job);
  };
}

}  // namespace vacuform
