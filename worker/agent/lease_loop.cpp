#include "worker/agent/lease_loop.hpp"

#include <sys/statvfs.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "api/job_limits.hpp"
#include "api/problem.hpp"
#include "api/version.hpp"
#include "worker/agent/heartbeat.hpp"
#include "worker/agent/job_file.hpp"
#include "worker/agent/work_folder.hpp"

namespace vacuform {

namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

// How many processes the system has ended since it started because memory ran out; 0 if it does not tell.
std::uint64_t oom_kills() {
  std::ifstream file("/proc/vmstat");
  std::string name;
  for (std::uint64_t value = 0; file >> name >> value;)
    if (name == "oom_kill") return value;
  return 0;
}

// The server may be away or have a temporary fault: the call may be retried.
bool passing(const Error& error) {
  return error.code == Code::unavailable || error.code == Code::disk_full || error.code == Code::internal;
}

milliseconds longer(milliseconds pause) { return std::min(2 * pause, milliseconds(10000)); }

constexpr std::chrono::hours tidy_every{1};  // of the caches, in addition to after every job

constexpr const char* out = "out";  // the folder of artifacts in the folder of the job
constexpr TreeLimits most_left;     // in a job's folder

// The command of vacuform that makes a job of this kind.
const char* command_of(JobKind kind) {
  switch (kind) {
    case JobKind::print:
      return "run";
    case JobKind::inspection:
      return "inspect";
    case JobKind::layout:
      break;
  }
  return "layout";
}

// How a leased job ended, for this worker.
enum class Verdict { completed, failed, cancelled, released, lost };

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::completed:
      return "completed";
    case Verdict::failed:
      return "failed";
    case Verdict::cancelled:
      return "cancelled";
    case Verdict::released:
      return "released";
    case Verdict::lost:
      return "lost";
  }
  return "";
}

// One leased job from its inputs to its artifacts.
class LeasedJob {
 public:
  LeasedJob(const LeaseLoop& loop, WorkerClient& client, Heartbeat& heartbeat, const Lease& lease,
            const WorkFolder& folder, const StopSignal& stop, JobLog& log)
      : loop_(loop),
        client_(client),
        heartbeat_(heartbeat),
        lease_(lease),
        folder_(folder.path()),
        home_(folder.descriptor()),
        stop_(stop),
        log_(log) {}

  // Runs the job and tells the server how it ended.
  Verdict run() {
    const Result<void> worked = work();
    if (worked) return Verdict::completed;
    if (heartbeat_.lost() || worked.error().code == Code::lease_lost) return Verdict::lost;
    if (heartbeat_.cancel_asked()) return told(Verdict::cancelled, [&] { return client_.cancelled(lease_); });
    if (stop_.drained_within(milliseconds(0))) {
      // Only once: if the server is away now, the lease simply expires.
      const auto released = client_.release(lease_);
      return released ? Verdict::released : Verdict::lost;
    }
    const Retry retry = retry_;
    (void)log_.send(client_, lease_);
    return told(Verdict::failed, [&] { return client_.fail(lease_, worked.error(), retry); });
  }

 private:
  bool going() const {
    return !heartbeat_.lost() && !heartbeat_.cancel_asked() && !stop_.drained_within(milliseconds(0));
  }

  // Retries a call until it is answered, the lease is lost, or the duration of a lease has passed.
  template <class Call>
  Result<void> persist(const Call& call) {
    const auto until = std::chrono::steady_clock::now() + lease_.seconds;
    for (milliseconds pause{200};; pause = longer(pause)) {
      const Result<void> answer = call();
      const bool again = !answer && passing(answer.error());
      retry_ = again ? Retry::after_fault : Retry::never;
      if (!again || heartbeat_.lost() || std::chrono::steady_clock::now() > until) return answer;
      if (stop_.drained_within(pause)) return answer;
    }
  }

  template <class Call>
  Verdict told(Verdict verdict, const Call& call) {
    return persist(call) ? verdict : Verdict::lost;
  }

  Result<void> work() {
    const fs::path settings = folder_ / "settings.json";
    const auto alive = [this] { return going(); };
    std::vector<std::string> command{loop_.program.string(),
                                     command_of(lease_.kind),
                                     "--settings",
                                     settings.filename().string(),
                                     "--out",
                                     out,
                                     "--progress",
                                     "json"};
    for (const LeasedInput& input : lease_.inputs) {
      const std::string file = input.name + (input.extension.empty() ? "" : "." + input.extension);
      VACUFORM_CHECK(persist([&] { return client_.download_input(lease_, input, folder_ / file, alive); }));
      command.insert(command.end(), {std::string("--") + input.name, file});
    }
    if (std::ofstream file(settings, std::ios::binary); !(file << lease_.settings << std::flush)) {
      retry_ = Retry::after_fault;
      return fail(Code::internal, "the worker has no room for the job", "", "try again later");
    }
    if (lease_.kind == JobKind::print && !lease_.reference.empty())
      command.push_back("--reference=" + lease_.reference);
    const fs::path cache = cache_folder();
    // The working directory of the child is a folder in ours.
    if (!cache.empty())
      command.insert(command.end(), {"--cache", (cache.is_absolute() ? cache : ".." / cache).string()});
    oom_kills_before_ = oom_kills();
    const auto end = run_child(
        {loop_.program_file.number(), command, folder_, loop_.limits, loop_.sandbox, cache,
         loop_.groups ? &*loop_.groups : nullptr},
        [this](const ChildProgress& at) { heard(at); },
        [this] { return !going() || has_too_much() || fills_the_disk(); });
    if (loop_.caches) loop_.caches->make_room();
    if (!end) {
      retry_ = Retry::after_fault;
      return tl::make_unexpected(end.error());
    }
    measured_ = {};
    if (going() && has_too_much())
      return fail(Code::out_of_time,
                  "the job left more than " + std::to_string(most_left.entries) + " files or " +
                      std::to_string(most_left.bytes >> 30) + " GiB in its folder",
                  "", "give a smaller scan, a coarser sheet.resolution_mm or a lower print.dpi");
    if (going() && full_) {
      retry_ = Retry::after_crash;
      return fail(Code::out_of_time, "the worker's disk was nearly full, so the job was ended", "",
                  "give a smaller scan; an administrator can give the worker a larger disk");
    }
    if (const auto judged = judge(*end); !judged) {
      const Retry retry = retry_;
      // Artifacts that explain a refusal are sent if they can be; the refusal counts without them.
      if (retry == Retry::never && end->how == ChildEnd::How::exited)
        (void)upload([this](const ArtifactKind& kind) { return explains_failure(lease_.kind, kind); });
      retry_ = retry;
      return judged;
    }
    VACUFORM_CHECK(upload([](const ArtifactKind&) { return true; }));
    VACUFORM_TRY(report, left(std::string(report_of(lease_.kind))));
    const ReportedWarnings warnings = report ? reported_warnings(*report) : ReportedWarnings{};
    for (const std::string& code : warnings.codes) log_.say("warning " + code);
    VACUFORM_CHECK(persist([&] { return log_.send(client_, lease_, alive); }));
    const auto completed = persist([&] { return client_.complete(lease_, warnings.serious); });
    if (!completed && completed.error().code == Code::conflict)  // artifacts are missing
      return fail(Code::internal, completed.error().what, "", "report it with the job's id");
    return completed;
  }

  // Sends the artifacts that the child left, of those that are `wanted`.
  Result<void> upload(const std::function<bool(const ArtifactKind&)>& wanted) {
    for (const ArtifactKind& kind : artifact_kinds) {
      if (!wanted(kind)) continue;
      const std::string name(kind.name);
      VACUFORM_TRY(file, left(name));
      if (file)
        VACUFORM_CHECK(persist([&] {
          return client_.upload(lease_, name, file->descriptor.number(), file->bytes,
                                [this] { return going(); });
        }));
    }
    return {};
  }

  // Reads a file that the child wrote. The child has ended.
  Result<std::optional<JobFile>> left(const std::string& name) {
    auto file = open_job_file(home_, out, name.c_str(), largest_artifact);
    if (!file) {
      retry_ = Retry::after_crash;
      log_event("artifact-refused", {{"job", lease_.job}, {"artifact", name}, {"why", file.error().what}});
    }
    return file;
  }

  // No kernel limit bounds the number of files or their sum, so both are checked once a second, in bounded time.
  bool has_too_much() {
    const auto now = std::chrono::steady_clock::now();
    if (now - measured_ < std::chrono::seconds(1)) return too_much_;
    measured_ = now;
    too_much_ = too_much_ || !measure_tree(home_, most_left).within;
    return too_much_;
  }

  // Files that a job has open but no name for are seen in what is left of the disk alone.
  bool fills_the_disk() {
    struct statvfs disk {};
    if (::fstatvfs(home_, &disk) != 0) return full_;
    const auto free = std::uint64_t(disk.f_bavail) * disk.f_frsize,
               all = std::uint64_t(disk.f_blocks) * disk.f_frsize;
    full_ = full_ || free < std::min<std::uint64_t>(256u << 20, all / 20);
    return full_;
  }

  // The folder of cached stages for this owner and scan; empty: no folder. Without one the job still runs.
  fs::path cache_folder() const {
    if (!loop_.caches || lease_.cache.empty()) return {};
    return loop_.caches->of(lease_.cache).value_or(fs::path());
  }

  void heard(const ChildProgress& at) {
    heartbeat_.at(at.stage, at.fraction);
    if (at.cached) log_.say("stage " + std::string(name(at.stage)) + " cached");
    if (!at.cached && at.stage != stage_) log_.say("stage " + std::string(name(at.stage)));
    stage_ = at.stage;
  }

  // What the end of the child means for the job.
  Result<void> judge(const ChildEnd& end) {
    const bool refused = end.how == ChildEnd::How::exited && end.number == meaning(Code::bad_usage).exit_code;
    if (end.how == ChildEnd::How::stopped) return fail(Code::cancelled, "cancelled");
    if (end.how == ChildEnd::How::out_of_time) return tl::make_unexpected(*end.problem);
    if (end.how == ChildEnd::How::exited && end.number == 0) return {};
    if (refused && end.problem) return tl::make_unexpected(*end.problem);
    constexpr int no_sandbox = 126;
    retry_ = refused                                                        ? Retry::never
             : end.how == ChildEnd::How::exited && end.number == no_sandbox ? Retry::after_fault
                                                                            : Retry::after_crash;
    constexpr std::size_t told = 2000;  // the operator reads this; limits what a scan can write into it
    log_event("child-fault", {{"job", lease_.job},
                              {"attempt", lease_.attempt},
                              {end.how == ChildEnd::How::signalled ? "signal" : "exit", end.number},
                              {"stderr", end.stderr_tail.substr(end.stderr_tail.size() -
                                                                std::min(told, end.stderr_tail.size()))}});
    if (end.problem) return tl::make_unexpected(*end.problem);
    if (end.out_of_memory)
      return fail(Code::out_of_time, "the job needed more memory than its worker has for one", "",
                  "give a smaller scan, a coarser sheet.resolution_mm or a lower print.dpi");
    if (end.how == ChildEnd::How::signalled && end.number == SIGKILL && oom_kills() > oom_kills_before_)
      return fail(Code::out_of_time,
                  "the worker's machine ran out of memory, and its system ended the job, which was within "
                  "its own limit",
                  "", "an administrator can run fewer workers there, or give the machine more memory");
    if (end.how == ChildEnd::How::signalled && end.number == SIGKILL)
      return fail(Code::out_of_time, "the job's process was killed from outside", "",
                  "try again; an administrator finds in the system's log what killed it");
    return fail(Code::internal, "the pipeline crashed on this scan and pattern", "",
                "try other settings; if it happens again, report it with the job's id");
  }

  const LeaseLoop& loop_;
  WorkerClient& client_;
  Heartbeat& heartbeat_;
  const Lease& lease_;
  const fs::path folder_;
  const int home_;  // the same folder, open
  const StopSignal& stop_;
  JobLog& log_;
  std::optional<Stage> stage_;  // of the child
  std::chrono::steady_clock::time_point measured_{};
  bool too_much_ = false, full_ = false;
  std::uint64_t oom_kills_before_ = 0;
  Retry retry_ = Retry::never;
};

}  // namespace

Result<void> LeaseLoop::run(const StopSignal& stop) const {
  VACUFORM_TRY(client, WorkerClient::to(server, token));
  log_event("worker-started",
            {{"worker", name},
             {"sandbox", sandbox.measures(true)},
             {"sandbox_lacks", sandbox.measures(false)},
             {"control_group", groups ? nlohmann::json(groups->controllers()) : nlohmann::json()}});
  milliseconds pause = poll;
  int jobs = 0;
  auto busy =
      std::chrono::steady_clock::now();  // when the server last had a job for this worker, or was away
  const char* why = "signal";
  auto tidied = std::chrono::steady_clock::now() - tidy_every;
  while (!stop.within(milliseconds(0))) {
    if (const auto now = std::chrono::steady_clock::now(); now - tidied >= tidy_every) {
      if (caches) caches->make_room();
      (void)sweep(work);  // what could not be deleted earlier
      tidied = now;
    }
    const auto lease = client.lease(name, sandbox.measures(true));
    if (!lease && !passing(lease.error())) return tl::make_unexpected(lease.error());
    if (!lease || !*lease) {
      const auto now = std::chrono::steady_clock::now();
      if (!lease) busy = now;
      if (idle_exit && now - busy >= *idle_exit) {
        why = "idle";
        break;
      }
      if (!lease && pause == poll) log_event("server-away", {{"worker", name}, {"why", lease.error().what}});
      pause = lease ? poll : longer(pause);
      stop.within(pause);
      continue;
    }
    pause = poll;
    const Lease& held = **lease;
    const LoggedRequest logged(held.request);
    if (!held.understood) {
      log_event("job-not-understood", {{"worker", name}, {"job", held.job}, {"version", version}});
      VACUFORM_CHECK(client.release(held));
      return fail(Code::bad_usage,
                  "the server gave a job that this worker does not understand; it is given back", server,
                  "install the worker of the server's version (this one is " + std::string(version) + ")");
    }
    log_event("job-leased", {{"worker", name}, {"job", held.job}, {"attempt", held.attempt}});
    const auto folder = WorkFolder::make(work);
    if (!folder) {
      VACUFORM_CHECK(client.release(held));
      return tl::make_unexpected(folder.error());
    }
    VACUFORM_TRY(beating, WorkerClient::to(server, token));
    JobLog job_log;
    Heartbeat heartbeat(std::move(beating), held, job_log);
    const Verdict verdict = LeasedJob(*this, client, heartbeat, held, *folder, stop, job_log).run();
    log_event(
        "job-left",
        {{"worker", name}, {"job", held.job}, {"attempt", held.attempt}, {"verdict", name_of(verdict)}});
    busy = std::chrono::steady_clock::now();
    if (verdict != Verdict::released && ++jobs == most_jobs) {
      why = "max-jobs";
      break;
    }
  }
  log_event("worker-stopped", {{"worker", name}, {"why", why}, {"jobs", jobs}});
  return {};
}

}  // namespace vacuform
