#include "server/routes/metrics.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "api/base/clock.hpp"

namespace vacuform {

namespace {

// Whole numbers without a point, others with all their digits.
std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.15g", value);
  return text;
}

void write_head(std::string& out, const std::string& name, const std::string& help, const char* type) {
  out += "# HELP " + name + " " + help + "\n# TYPE " + name + " " + type + "\n";
}

void write_sample(std::string& out, const std::string& name, const std::string& labels, double value) {
  out += name + (labels.empty() ? "" : "{" + labels + "}") + " " + number(value) + "\n";
}

}  // namespace

void Metrics::answered(const http::Answered& answered) {
  const auto interval = std::lower_bound(bounds.begin(), bounds.end(), answered.seconds) - bounds.begin();
  const std::lock_guard hold(mutex_);
  const std::string route = answered.route.empty() ? "none" : answered.route;
  ++requests_[{route, answered.method, answered.status}];
  Seconds& seconds = seconds_[route];
  ++seconds.in[interval];
  seconds.sum += answered.seconds;
}

void Metrics::leases_lost(std::size_t number_lost) {
  const std::lock_guard hold(mutex_);
  leases_lost_ += number_lost;
}

void Metrics::job_ended(const Job& job) {
  const std::string labels =
      "kind=\"" + std::string(name(job.kind)) + "\",outcome=\"" + std::string(name(job.state)) + "\"";
  const std::lock_guard hold(mutex_);
  ++jobs_ended_[labels];
  if (!job.started || !job.ended) return;
  const double seconds = static_cast<double>(std::max<Millis>(0, *job.ended - *job.started)) / 1000;
  Durations& durations = job_durations_[labels];
  ++durations.counts[static_cast<std::size_t>(
      std::lower_bound(job_bounds.begin(), job_bounds.end(), seconds) - job_bounds.begin())];
  durations.sum += seconds;
}

std::string Metrics::text(const std::vector<Family>& read) const {
  std::string out;
  for (const Family& family : read) {
    write_head(out, family.name, family.help, family.type.c_str());
    for (const Sample& sample : family.samples) write_sample(out, sample.name, sample.labels, sample.value);
  }
  const std::lock_guard hold(mutex_);
  write_head(out, "vacuform_http_requests_total", "Requests answered, by route and status", "counter");
  for (const auto& [key, count] : requests_) {
    const auto& [route, method, status] = key;
    write_sample(
        out, "vacuform_http_requests_total",
        "route=\"" + route + "\",method=\"" + method + "\",status=\"" + std::to_string(status) + "\"",
        static_cast<double>(count));
  }
  write_head(out, "vacuform_http_request_seconds",
             "Time from the end of a request's head to its answer, by route", "histogram");
  for (const auto& [route, seconds] : seconds_) {
    const std::string of_route = "route=\"" + route + "\"";
    std::uint64_t so_far = 0;
    for (std::size_t i = 0; i < seconds.in.size(); ++i) {
      so_far += seconds.in[i];
      const std::string bound = i < bounds.size() ? number(bounds[i]) : "+Inf";
      write_sample(out, "vacuform_http_request_seconds_bucket", of_route + ",le=\"" + bound + "\"",
                   static_cast<double>(so_far));
    }
    write_sample(out, "vacuform_http_request_seconds_sum", of_route, seconds.sum);
    write_sample(out, "vacuform_http_request_seconds_count", of_route, static_cast<double>(so_far));
  }
  write_head(out, "vacuform_leases_lost_total", "Leases that expired because their worker was silent",
             "counter");
  write_sample(out, "vacuform_leases_lost_total", "", static_cast<double>(leases_lost_));
  write_head(out, "vacuform_jobs_ended_total", "Jobs that ended since the start of the server, by outcome",
             "counter");
  for (const auto& [labels, count] : jobs_ended_)
    write_sample(out, "vacuform_jobs_ended_total", labels, static_cast<double>(count));
  write_head(out, "vacuform_job_duration_seconds", "From the start of a job's last attempt to its end",
             "histogram");
  for (const auto& [labels, durations] : job_durations_) {
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < durations.counts.size(); ++i) {
      count += durations.counts[i];
      const std::string bound = i < job_bounds.size() ? number(job_bounds[i]) : "+Inf";
      write_sample(out, "vacuform_job_duration_seconds_bucket", labels + ",le=\"" + bound + "\"",
                   static_cast<double>(count));
    }
    write_sample(out, "vacuform_job_duration_seconds_sum", labels, durations.sum);
    write_sample(out, "vacuform_job_duration_seconds_count", labels, static_cast<double>(count));
  }
  return out;
}

std::vector<Family> process_families() {
  static const double started = static_cast<double>(wall_clock()) / 1000;
  std::vector<Family> families;
  const auto add = [&](const char* name, const char* help, double value) {
    families.push_back({name, help, "gauge", {{name, "", value}}});
  };
  add("process_start_time_seconds", "Start of the process, in seconds since 1970", started);
  if (double pages = 0, resident = 0; std::ifstream("/proc/self/statm") >> pages >> resident)
    add("process_resident_memory_bytes", "Memory in use",
        resident * static_cast<double>(::sysconf(_SC_PAGESIZE)));
  std::error_code ec;
  if (std::filesystem::directory_iterator files("/proc/self/fd", ec); !ec)
    add("process_open_fds", "Open files and sockets", static_cast<double>(std::distance(files, {})));
  return families;
}

}  // namespace vacuform
