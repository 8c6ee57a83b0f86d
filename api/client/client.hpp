// The client side of the HTTP API (api/openapi.yaml): the requests of `vacuform submit` and `vacuform-worker`. Every
// call returns the server's problem as an Error of the same code; unavailable means that the server was not reached or
// cannot answer now, and the same call may be repeated.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "api/base/error.hpp"
#include "api/client/http.hpp"
#include "api/job.hpp"
#include "api/retry.hpp"

namespace vacuform {

// Called several times per second during a call; false cancels it with Code::cancelled.
using Going = std::function<bool()>;

struct RemoteArtifact {
  std::string name;  // one of api/job.hpp: other names that a server lists are left out
  std::uint64_t bytes = 0;
  std::string sha256;
};

struct RemoteJob {
  std::string id;
  JobState state = JobState::queued;
  std::optional<Stage> stage;  // while it runs
  double progress = 0;         // of the whole job, in [0, 1]
  double stage_progress = 0;   // of the stage, in [0, 1]
  std::vector<RemoteArtifact> artifacts;
  std::optional<Error> problem;  // of a failed job
};

// A job to create.
struct JobRequest {
  std::map<std::string, std::filesystem::path> files;  // by the name of their kind of input
  std::string settings;                                // JSON text
  std::string from = {};  // the id of a job whose other files are shared; may be empty
  std::string reference = {}, note = {};
  bool rescan = false;  // another scan of the patient who has the reference
  JobKind kind = JobKind::print;
};

// What a user does with jobs.
class Client {
 public:
  // `token` goes with every request; empty: none.
  static Result<Client> to(const std::string& server, const std::string& token);

  // Creates a job; the files are streamed. `uploaded` receives the fraction sent and may cancel. An interrupted request
  // is sent again, up to three times within half a minute; its Idempotency-Key prevents a second job.
  Result<RemoteJob> submit(const JobRequest& job, const std::function<bool(double)>& uploaded);
  Result<RemoteJob> job(const std::string& id, const Going& going = {});
  // Into `folder`, under the artifact's name: written beside it, checked against its SHA-256, then renamed.
  Result<void> download(const std::string& id, const RemoteArtifact& artifact,
                        const std::filesystem::path& folder, const Going& going = {});

  std::string job_url(const std::string& id) const;

 private:
  explicit Client(Http http) : http_(std::move(http)) {}
  Http http_;
};

// A job as a worker holds it.
struct LeasedInput {
  std::string name;       // one of api/job.hpp: other names that a server lists are left out
  std::string extension;  // lower case letters and digits, no dot; may be empty
  std::uint64_t bytes = 0;
  std::string sha256;
};
struct Lease {
  std::string job, token;
  JobKind kind = JobKind::print;
  int attempt = 1;
  std::chrono::seconds seconds{30};    // from a heartbeat to the end of the lease
  std::chrono::seconds heartbeat{10};  // longest interval that the server accepts
  std::string settings;                // JSON text
  std::string reference;               // of the job, for the label of the print; may be empty
  std::string request;                 // the id of the request that made the job, for the log; may be empty
  std::vector<LeasedInput> inputs;     // in the order of input_kinds, with all that the kind of job needs
  std::string
      cache;  // a key for what may be cached for other jobs of the same owner and scan; empty: cache nothing
  // Whether this program understands everything that the job needs. If not, only `job`, `token` and `request` are
  // valid, and the job must be released.
  bool understood = true;
};

// Operations of a worker on leases. Every call but the first may return lease_lost: another worker has the job now.
class WorkerClient {
 public:
  static Result<WorkerClient> to(const std::string& server, const std::string& token);

  // nullopt: no job is waiting. `sandbox` names the measures under which this worker's jobs run. The server refuses a
  // worker whose protocol it does not support with conflict.
  Result<std::optional<Lease>> lease(const std::string& worker, const std::vector<std::string>& sandbox);
  // One of the lease's inputs, checked against its length and SHA-256.
  Result<void> download_input(const Lease& lease, const LeasedInput& input, const std::filesystem::path& file,
                              const Going& going);
  // True: the user has requested a cancel.
  Result<bool> heartbeat(const Lease& lease, Stage stage, double progress, const Going& going);
  // The first `bytes` bytes of an open file.
  Result<void> upload(const Lease& lease, const std::string& artifact, int file, std::uint64_t bytes,
                      const Going& going);
  Result<void> complete(const Lease& lease, std::optional<int> serious_warnings = {});
  Result<void> fail(const Lease& lease, const Error& error, Retry retry);
  // Lines for the job's log; the first has this number within the attempt.
  Result<void> log(const Lease& lease, std::size_t first, const std::vector<std::string>& lines,
                   const Going& going = {});
  Result<void> cancelled(const Lease& lease);
  Result<void> release(const Lease& lease);

 private:
  explicit WorkerClient(Http http) : http_(std::move(http)) {}
  Result<HttpResponse> call(const Lease& lease, const std::string& method, const std::string& tail,
                            const std::string& body, const Going& going = {});
  Http http_;
};

}  // namespace vacuform
