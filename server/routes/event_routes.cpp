// A job as it changes: at once (GET with If-None-Match), as soon as it does (with wait=SECONDS), and as a stream of
// server-sent events that goes on where it broke off (Last-Event-ID).
#include <algorithm>
#include <charconv>
#include <chrono>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "server/jobs/job_json.hpp"
#include "server/messages/problem.hpp"
#include "server/messages/range.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/lists.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;
using nlohmann::ordered_json;
using std::chrono::steady_clock;
using namespace std::chrono_literals;

namespace {

constexpr auto slice = 500ms;  // of waiting: a client that left and a server that stops are noticed so soon
constexpr auto silence = 15s;  // after which a comment is sent, so that nobody in between hangs up
constexpr auto between_looks = 2s;      // at the token of a client that listens
constexpr auto longest_stream = 10min;  // then the client comes again
constexpr int lines_at_once = 200;

// The JSON of jobs that are asked for again and again, one version of each. It is much more work to write than the job is to
// read. That of a queued job is not kept: its place in the queue changes without it. From any thread.
class Shown {
 public:
  Result<std::string> of(Store& store, const Job& job) {
    {
      const std::lock_guard hold(mutex_);
      const auto found = texts_.find(job.id);
      if (found != texts_.end() && found->second.version == job.version &&
          found->second.artifacts == job.artifacts.size())
        return found->second.text;
    }
    VACUFORM_TRY(estimate, store.estimate(job));
    std::string text = dump(job_json(job, estimate));
    if (job.state == JobState::queued) return text;
    const std::lock_guard hold(mutex_);
    if (texts_.size() >= most) texts_.clear();
    texts_[job.id] = {job.version, job.artifacts.size(), text};
    return text;
  }

 private:
  static constexpr std::size_t most = 1000;  // some 4 KiB each
  struct Text {
    std::int64_t version = 0;
    std::size_t artifacts = 0;  // those of a running job come one by one
    std::string text;
  };
  std::mutex mutex_;
  std::unordered_map<std::string, Text> texts_;
};

Result<Response> job_response(Store& store, const Job& job, Shown& shown) {
  VACUFORM_TRY(text, shown.of(store, job));
  Response response = json_text_response(std::move(text));
  response.set("ETag", etag_of(job));
  return response;
}

Response unchanged(const Job& job) {
  Response response;
  response.status = 304;
  response.set("ETag", etag_of(job));
  response.set("Cache-Control", "no-store");
  return response;
}

Result<Response> get_job(Service& service, const std::shared_ptr<Shown>& shown, const Request& request,
                         const Caller& caller) {
  VACUFORM_TRY(job, job_for(service, request.at("id"), caller));
  VACUFORM_TRY(seconds, query_number(request, "wait", 0, 0, most_wait_seconds));
  if (auto refusal = http::unmet_precondition(request, etag_of(job)))
    return http::refused_response(std::move(*refusal));
  if (!http::names_etag(request.header("If-None-Match"), etag_of(job)))
    return job_response(service.store, job, *shown);
  if (seconds == 0 || ended(job.state)) return unchanged(job);
  Response response;
  response.waiter = [&store = service.store, shown, job,
                     until = steady_clock::now() +
                             std::chrono::seconds(seconds)](const http::Going& going) -> Result<Response> {
    while (going() && steady_clock::now() < until) {
      VACUFORM_TRY(now, store.wait_for_change(job.id, job.version, slice));
      if (now.version > job.version) return job_response(store, now, *shown);
    }
    return unchanged(job);
  };
  return response;
}

// How far a client has heard: the job's version and the number of the last line of its log, "7.12" as an event's id.
struct Heard {
  std::int64_t version = 0, line = 0;

  static Heard from(std::string_view text) {
    Heard heard;
    const char* const end = text.data() + text.size();
    const auto version = std::from_chars(text.data(), end, heard.version);
    const bool dotted = version.ec == std::errc() && version.ptr != end && *version.ptr == '.';
    const auto line = dotted ? std::from_chars(version.ptr + 1, end, heard.line) : std::from_chars_result{};
    const bool good =
        dotted && line.ec == std::errc() && line.ptr == end && heard.version >= 0 && heard.line >= 0;
    return good ? heard : Heard{};
  }
  std::string id() const { return std::to_string(version) + "." + std::to_string(line); }
};

std::string event(const char* name, const std::string& id, const ordered_json& data) {
  return std::string("event: ") + name + "\nid: " + id + "\ndata: " + dump(data) + "\n";
}

ordered_json change_json(const Job& job) {
  const ordered_json whole = job_json(job, Detail::brief);
  ordered_json change;
  for (const char* key :
       {"id", "state", "stage", "progress", "stage_progress", "attempt", "started", "ended", "problem"})
    change[key] = whole.at(key);
  return change;
}

// What the client has not heard yet of the job as it is now.
class Telling {
 public:
  Telling(Service& service, std::string id, Heard heard, Caller caller)
      : store_(service.store),
        access_(service.access),
        caller_(std::move(caller)),
        id_(std::move(id)),
        heard_(heard) {}

  std::optional<std::string> operator()() {
    if (over_ || steady_clock::now() - begun_ > longest_stream) return std::nullopt;
    if (steady_clock::now() - looked_ > between_looks) {
      looked_ = steady_clock::now();
      if (!access_.still_allowed(caller_)) return std::nullopt;
    }
    const auto job = store_.wait_for_change(id_, heard_.version, slice);
    if (!job) return std::nullopt;  // deleted meanwhile
    std::string text;
    if (job->version > heard_.version) text = news(*job);
    over_ = ended(job->state) && heard_.version == job->version;
    if (!text.empty()) {
      spoke_ = steady_clock::now();
    } else if (steady_clock::now() - spoke_ > silence) {
      spoke_ = steady_clock::now();
      text = ": still here\n\n";
    }
    return text;
  }

 private:
  std::string news(const Job& job) {
    std::string text;
    const auto lines = store_.log_after(id_, heard_.line, lines_at_once);
    if (!lines) return text;
    for (const LogLine& line : *lines) {
      heard_.line = line.number;
      text += event("log", heard_.id(),
                    log_line_json(line));  // under the old version: the change is still to come
    }
    if (lines->size() == lines_at_once) return text;
    heard_.version = job.version;
    return text += event("job", heard_.id(), change_json(job));
  }

  Store& store_;
  const Access& access_;
  const Caller caller_;
  const std::string id_;
  Heard heard_;
  steady_clock::time_point looked_ = steady_clock::now();  // at the token
  const steady_clock::time_point begun_ = steady_clock::now();
  steady_clock::time_point spoke_ = begun_;
  bool over_ = false;
};

Result<Response> get_events(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(job, job_for(service, request.at("id"), caller));
  Heard heard = Heard::from(request.header("Last-Event-ID"));
  if (heard.version > job.version) heard = {};  // of a store that has since been restored from a copy
  Response response;
  response.set("Cache-Control", "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  if (ended(job.state) && heard.version >= job.version) {
    response.status = 204;  // tells an EventSource to come no more
    return response;
  }
  response.set("X-Accel-Buffering", "no");  // nginx passes events on as they come
  response.media_type = "text/event-stream";
  response.stream = Telling(service, job.id, heard, caller);
  return response;
}

}  // namespace

void add_event_routes(http::Router& router, Service& service) {
  add_guarded(router, service, Scope::read, "GET", "/api/v1/jobs/{id}?wait",
              [shown = std::make_shared<Shown>()](Service& s, const Request& request, const Caller& caller) {
                return get_job(s, shown, request, caller);
              });
  add_guarded(router, service, Scope::read, "GET", "/api/v1/jobs/{id}/events", get_events);
}

}  // namespace vacuform
