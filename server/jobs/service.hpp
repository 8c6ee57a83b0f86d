// What every route works on, and what of it a caller may see.
#pragma once

#include <string>

#include "api/base/clock.hpp"
#include "server/access/access.hpp"
#include "server/jobs/uploads.hpp"
#include "server/jobs/workers.hpp"
#include "server/store/store.hpp"

namespace vacuform {

class WorkerCaches;

// Outlives the listener.
struct Service {
  Store& store;
  Access& access;
  Workers& workers;
  Uploads& uploads;
  int lease_seconds = 30;
  int heartbeat_seconds = 1;
  WorkerCaches* caches = nullptr;  // none: workers keep nothing
  Millis started = boot_clock();
};

// What has that id, if the caller may see it; not_found otherwise, so that nobody learns of another's.
Result<Job> job_for(Service& service, const std::string& id, const Caller& caller);
Result<StoredUpload> upload_for(Service& service, const std::string& id, const Caller& caller);
Result<StoredScan> scan_for(Service& service, const std::string& id, const Caller& caller);

}  // namespace vacuform
