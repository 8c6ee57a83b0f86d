// The heartbeats of one leased job, sent from a separate thread while the job is fetched, run and handed in.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "api/client/client.hpp"
#include "worker/agent/job_log.hpp"

namespace vacuform {

// Reports the progress of the job to the server once a second (more often if the server asks for that). Learns whether
// the user wants to cancel it and whether the lease is still valid. Retries while the server is away. When the lease
// would have expired by then, it counts as lost, because the server may have given the job to another worker.
class Heartbeat {
 public:
  // `log` outlives it. Heartbeats carry its lines.
  Heartbeat(WorkerClient client, const Lease& lease, JobLog& log);
  ~Heartbeat();  // stops, and aborts a call in progress

  void at(Stage stage, double fraction);  // what to report from now on

  bool cancel_asked() const { return cancel_; }
  bool lost() const { return lost_; }

 private:
  void beat();

  WorkerClient client_;
  const Lease lease_;
  JobLog& log_;
  std::atomic<bool> cancel_{false}, lost_{false}, ending_{false};
  std::mutex mutex_;
  std::condition_variable wake_;
  Stage stage_ = Stage::scan;
  double fraction_ = 0;
  std::thread thread_;  // last: it uses everything above
};

}  // namespace vacuform
