#include "server/jobs/service.hpp"

namespace vacuform {

namespace {

template <class Found>
Result<Found> if_seen(Result<Found> found, const Caller& caller, const std::string& id, const char* what,
                      const char* fix) {
  if (found && !caller.sees_of(found->owner))
    return fail(Code::not_found, std::string("there is no such ") + what, id, fix);
  return found;
}

}  // namespace

Result<Job> job_for(Service& service, const std::string& id, const Caller& caller) {
  return if_seen(service.store.job(id), caller, id, "job", "see the list of jobs");
}

Result<StoredUpload> upload_for(Service& service, const std::string& id, const Caller& caller) {
  return if_seen(service.store.find_upload(id), caller, id, "upload", "begin it again");
}

Result<StoredScan> scan_for(Service& service, const std::string& id, const Caller& caller) {
  return if_seen(service.store.find_scan(id), caller, id, "scan", "see the list of scans");
}

}  // namespace vacuform
