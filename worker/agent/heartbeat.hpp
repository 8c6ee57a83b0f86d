// The signs of life of one leased job, sent from a thread of their own while the job is fetched, run and handed in.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "api/client/client.hpp"
#include "worker/agent/job_log.hpp"

namespace vacuform {

// Tells the server once a second (sooner where it asks for that) how far the job is, and learns whether the user wants
// it cancelled and whether the lease still holds. A server that is away is asked again; when the lease would have run
// out by then it counts as lost, since the server may have given the job to another worker.
class Heartbeat {
 public:
  // `log` outlives it; its lines are sent with the signs of life.
  Heartbeat(WorkerClient client, const Lease& lease, JobLog& log);
  ~Heartbeat();  // stops, and gives up a call under way

  void at(Stage stage, double fraction);  // what to tell from now on

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
