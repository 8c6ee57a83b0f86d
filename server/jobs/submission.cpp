#include "server/jobs/submission.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/base/log.hpp"
#include "api/base/text.hpp"
#include "api/job_inputs.hpp"
#include "api/job_text.hpp"
#include "api/settings.hpp"
#include "server/jobs/formats.hpp"
#include "server/jobs/submission_form.hpp"

namespace vacuform {

namespace {

constexpr std::uint64_t part_heads = 1 << 20;  // of a form

bool has(const NewJob& job, std::string_view name) {
  return std::any_of(job.inputs.begin(), job.inputs.end(),
                     [&](const NewInput& input) { return input.name == name; });
}

// The digest of the scan; empty without one.
std::string scan_digest(NewJob& job) {
  for (NewInput& input : job.inputs) {
    if (input.name != "scan") continue;
    auto* upload = std::get_if<Upload>(&input.file);
    return (upload ? upload->digest() : std::get<Blob>(input.file)).sha256;
  }
  return {};
}

// `base` contains valid settings.
Result<Settings> merged_settings(const std::string& base, const std::string& text,
                                 const std::map<std::string, std::string>& fields) {
  nlohmann::json object = nlohmann::json::parse(base);
  if (!trimmed(text).empty()) {
    VACUFORM_TRY(given, settings_json(text));
    const auto alone = settings_from_json(given);
    if (!alone && (base == "{}" || !given.is_object())) return alone;
    for (const auto& [group, values] : given.items()) {
      if (!values.is_object() || !object[group].is_object())
        object[group] = values;
      else
        for (const auto& [key, value] : values.items()) object[group][key] = value;
    }
  }
  for (const auto& [name, value] : fields) {
    std::string given(trimmed(value));
    if (given.empty() || !SubmissionForm::is_setting(name)) continue;
    if (given.find(',') != std::string::npos && given.front() != '[' && given.front() != '{')
      given = "[" + given + "]";  // "3, 4" is a pair
    VACUFORM_CHECK(set_in_json(object, name + "=" + given));
  }
  return settings_from_json(object);
}

// The Idempotency-Key of a request; empty if it has none. An empty one is a client's fault: it would not protect.
Result<std::string> client_key_of(const http::Request& request) {
  std::string key(request.header("Idempotency-Key"));
  const bool visible = std::all_of(key.begin(), key.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (request.has("Idempotency-Key") && (key.size() < 8 || key.size() > 128 || !visible))
    return fail(Code::bad_usage, "the key has not 8 to 128 visible ASCII characters", "Idempotency-Key",
                "send for example a random UUID");
  return key;
}

// The file that a field names by an id.
Result<NewInput> shared_input(Service& service, const Caller& caller, const std::string& field,
                              const std::string& id) {
  if (field == "scan_id") {
    VACUFORM_TRY(scan, scan_for(service, id, caller));
    return NewInput{"scan", scan.blob, scan.extension};
  }
  VACUFORM_TRY(started, upload_for(service, id, caller));
  VACUFORM_TRY(upload, service.uploads.whole(started));
  if (field != upload.input + "_upload")
    return fail(Code::bad_usage, "the upload is a " + upload.input, field,
                "name it in the field " + upload.input + "_upload");
  return NewInput{upload.input, *upload.blob, upload.extension};
}

Result<void> add_inputs(Service& service, const Caller& caller, SubmissionForm& form, NewJob& job) {
  for (auto& [name, file] : form.files)
    if (file.given()) job.add(std::string(name), std::move(*file.upload), std::move(file.extension));
  for (const auto& [field, id] : form.fields()) {
    if (!SubmissionForm::is_file(field) || id.empty()) continue;
    VACUFORM_TRY(input, shared_input(service, caller, field, id));
    if (has(job, input.name))
      return fail(Code::bad_usage, "there is more than one " + input.name, field, "send one");
    job.inputs.push_back(std::move(input));
  }
  return {};
}

// The files of the source job, in place of those that were not sent: of the optional files only those that the settings
// still ask for.
void share_inputs(const Job& from, const Settings& settings, NewJob& job) {
  for (const Input& input : from.inputs) {
    const bool asked = asks_for(settings, input.name).value_or(true);
    if (asked && !has(job, input.name)) job.add(input.name, input.blob, input.extension);
  }
}

Result<JobKind> kind_of(const SubmissionForm& form) {
  const std::string text = form.field("kind");
  if (text.empty()) return JobKind::print;
  if (const auto kind = job_kind_from(text)) return *kind;
  return fail(Code::bad_usage, "there is no such kind of job: " + text.substr(0, 64), "kind",
              "send print, inspection or layout");
}

Result<int> priority_of(const SubmissionForm& form, const Caller& caller) {
  const std::string text = form.field("priority");
  int priority = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), priority);
  if (text.empty()) return 0;
  if (error != std::errc() || end != text.data() + text.size() || priority < lowest_priority ||
      priority > highest_priority)
    return fail(Code::bad_usage, "not a priority: " + text.substr(0, 64), "priority",
                "give a number from -10 to 10");
  if (priority > 0 && !caller.scopes.has(Scope::admin))
    return fail(Code::forbidden, "only an administrator raises a job above the others", "priority",
                "give 0 or less");
  return priority;
}

// The base settings. Those of the group layout count for layouts alone: a print begins with others.
Result<std::string> base_of(Service& service, const SubmissionForm& form, JobKind kind,
                            const std::optional<Job>& from) {
  const std::string named = form.field("profile");
  if (from && !named.empty())
    return fail(Code::bad_usage, "both another job and a profile are given to begin with", "profile",
                "give one of them");
  std::string base("{}");
  if (from) base = from->settings;
  if (!named.empty()) {
    VACUFORM_TRY(profile, service.store.find_profile(named));
    base = std::move(profile.settings);
  }
  if (base == "{}" || kind == JobKind::layout) return base;
  nlohmann::json settings = nlohmann::json::parse(base);
  settings.erase("layout");
  return settings.dump();
}

// Whether the job has the scan of the source job.
bool shares_scan(NewJob& job, const Job& from) {
  const Input* scan = from.input("scan");
  const std::string sha256 = scan_digest(job);
  return sha256.empty() || (scan && scan->blob.sha256 == sha256);
}

Result<bool> rescan_of(const SubmissionForm& form) {
  const std::string text = form.field("rescan");
  if (text.empty() || text == "false") return false;
  if (text == "true") return true;
  return fail(Code::bad_usage, "neither true nor false: " + text.substr(0, 64), "rescan",
              "send true if this is another scan of the same patient");
}

// An empty field counts as not sent: then the reference of the source job is taken if the scan is the same, and no note.
Result<void> read_texts(const SubmissionForm& form, const std::optional<Job>& from, NewJob& job) {
  VACUFORM_TRY(reference, clean_reference(form.field("reference")));
  VACUFORM_TRY(note, clean_note(form.field("note")));
  job.reference = std::move(reference);
  if (job.reference.empty() && from && shares_scan(job, *from)) job.reference = from->reference;
  VACUFORM_TRY(rescan, rescan_of(form));
  job.rescan = rescan;
  job.note = std::move(note);
  return {};
}

Result<std::optional<Job>> origin_of(Service& service, const SubmissionForm& form, const Caller& caller) {
  const std::string id = form.field("from");
  if (id.empty()) return std::optional<Job>();
  VACUFORM_TRY(job, job_for(service, id, caller));
  return std::optional<Job>(std::move(job));
}

}  // namespace

std::uint64_t largest_form() {
  std::uint64_t most = part_heads + largest_settings;
  for (const InputKind& kind : input_kinds) most += kind.most_bytes;
  return most;
}

std::uint64_t largest_form(std::string_view input) { return part_heads + input_kind(input)->most_bytes; }

Result<NewJob> read_submission(Service& service, http::Request& request, const Caller& caller) {
  VACUFORM_CHECK(service.store.room_for(request.content_length));  // before its bytes
  VACUFORM_TRY(client_key, client_key_of(request));
  SubmissionForm form(service.store);
  VACUFORM_CHECK(form.read(request));
  NewJob job;
  VACUFORM_TRY(kind, kind_of(form));
  job.kind = kind;
  VACUFORM_CHECK(add_inputs(service, caller, form, job));
  VACUFORM_TRY(from, origin_of(service, form, caller));
  VACUFORM_CHECK(read_texts(form, from, job));
  VACUFORM_TRY(base, base_of(service, form, kind, from));
  VACUFORM_TRY(settings, merged_settings(base, form.settings, form.fields()));
  if (from) {
    share_inputs(*from, settings, job);
    job.derived_from = from->id;
  }
  const HasInput given = [&](std::string_view name) { return has(job, name); };
  use_inputs(given, settings);
  VACUFORM_CHECK(check_inputs(kind, given, settings));
  VACUFORM_TRY(priority, priority_of(form, caller));
  job.priority = priority;
  VACUFORM_CHECK(check_for(kind, settings));
  job.settings = to_json(settings).dump();
  job.request = request.id;
  job.owner = caller.owner;
  job.client_key = std::move(client_key);
  return job;
}

Result<void> check_reference(Service& service, NewJob& submission) {
  if (submission.rescan) return {};
  return service.store.check_reference(submission.owner, submission.reference, scan_digest(submission));
}

Result<Job> create_job(Service& service, NewJob submission, const Caller& caller) {
  bool repeated = false;
  auto job = service.store.create(std::move(submission), &repeated);
  if (job) log_event(repeated ? "job-repeated" : "job-created", {{"job", job->id}, {"token", caller.token}});
  return job;
}

Result<nlohmann::ordered_json> plan_of(NewJob& job, Store& store) {
  nlohmann::ordered_json inputs = nlohmann::ordered_json::object();
  for (const InputKind& kind : input_kinds)
    for (NewInput& input : job.inputs) {
      if (input.name != kind.name) continue;
      auto* upload = std::get_if<Upload>(&input.file);
      const Blob blob = upload ? upload->digest() : std::get<Blob>(input.file);
      std::unique_ptr<BlobReader> reader;
      if (!upload) {
        VACUFORM_TRY(opened, store.open(blob));
        reader = std::move(opened);
      }
      std::string head(format_head, '\0');
      VACUFORM_TRY(n, upload ? upload->file().read_at(0, head) : reader->read_at(0, head));
      head.resize(n);
      VACUFORM_TRY(format, format_of(input.name, head, blob.bytes, input.extension));
      inputs[input.name] = {
          {"bytes", blob.bytes}, {"sha256", blob.sha256}, {"extension", input.extension}, {"format", format}};
    }
  return nlohmann::ordered_json{{"kind", name(job.kind)},
                                {"reference", job.reference},
                                {"note", job.note},
                                {"settings", nlohmann::ordered_json::parse(job.settings)},
                                {"inputs", std::move(inputs)}};
}

}  // namespace vacuform
