// What the service counts, as Prometheus reads it (text format 0.0.4): a small writer of our own, for a library would
// bring a second HTTP server along.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <tuple>
#include <vector>

#include "server/http/server.hpp"
#include "server/store/job.hpp"

namespace vacuform {

// One time series of a gauge or counter that is read when it is asked for.
struct Sample {
  std::string name;    // "vacuform_jobs"
  std::string labels;  // "state=\"queued\"", or empty
  double value = 0;
};
struct Family {
  std::string name, help, type;  // type: gauge or counter
  std::vector<Sample> samples;
};

// From any thread. Its labels are route patterns, methods of HTTP and statuses that we gave: nothing that a client
// sends can make them many.
class Metrics {
 public:
  void answered(const http::Answered& answered);
  void leases_lost(std::size_t number);
  void job_ended(const Job& job);

  // Everything that was counted, and `read` before it.
  std::string text(const std::vector<Family>& read) const;

 private:
  static constexpr std::array<double, 8> bounds{0.005, 0.02, 0.1, 0.5, 2, 10, 60, 600};  // seconds
  mutable std::mutex mutex_;
  std::map<std::tuple<std::string, std::string, int>, std::uint64_t> requests_;  // route, method, status
  struct Seconds {
    std::array<std::uint64_t, bounds.size() + 1> in{};  // each interval of the bounds
    double sum = 0;
  };
  std::map<std::string, Seconds> seconds_;  // by route
  std::uint64_t leases_lost_ = 0;

  static constexpr std::array<double, 7> job_bounds{1, 5, 15, 60, 300, 900, 3600};  // seconds
  struct Durations {
    std::array<std::uint64_t, job_bounds.size() + 1> counts{};
    double sum = 0;
  };
  std::map<std::string, std::uint64_t> jobs_ended_;  // by labels
  std::map<std::string, Durations> job_durations_;   // of those that a worker started
};

// Memory, files and start of this process, from /proc; what cannot be read is left out.
std::vector<Family> process_families();

}  // namespace vacuform
