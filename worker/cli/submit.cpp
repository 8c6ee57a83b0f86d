// vacuform submit: the same as run, through a server.
#include <poll.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "api/client/client.hpp"
#include "api/client/token.hpp"
#include "api/job_text.hpp"
#include "api/settings.hpp"
#include "worker/cli/commands.hpp"
#include "worker/cli/outcome.hpp"
#include "worker/cli/progress_bar.hpp"
#include "worker/cli/settings_options.hpp"

namespace vacuform::cli {

namespace {

using std::chrono::steady_clock;

std::atomic<bool> interrupted{false};
extern "C" void interrupt(int) { interrupted.store(true); }

bool going() { return !interrupted.load(); }

struct SubmitOptions {
  std::string server = "http://127.0.0.1:8080", job, from, out, token_file, reference, note;
  std::string kind{name(JobKind::print)};
  std::array<std::string, input_kinds.size()> files;  // in the order of input_kinds
  SettingsOptions settings;
  OutcomeOptions outcome;
  bool wait = false, rescan = false;
};

JobKind kind_of(const SubmitOptions& o) { return job_kind_from(o.kind).value_or(JobKind::print); }

// Whether the settings ask for the colours of the scan. Settings that cannot be read are refused later.
bool prints_scan(const SubmitOptions& o) {
  const auto given = o.settings.read();
  const auto settings = given ? settings_from_json(*given) : Result<Settings>(Settings{});
  return settings && settings->pattern.source == PatternSource::scan;
}

bool lacks_files(const SubmitOptions& o) {
  for (std::size_t i = 0; i < input_kinds.size(); ++i)
    if (needs(kind_of(o), input_kinds[i], prints_scan(o)) && o.files[i].empty()) return true;
  return false;
}

Result<RemoteJob> create(Client& client, const SubmitOptions& o, ProgressBar& bar) {
  VACUFORM_TRY(settings, o.settings.read());
  JobRequest job{{}, settings.dump(), o.from};
  VACUFORM_TRY(reference, clean_reference(o.reference));
  VACUFORM_TRY(note, clean_note(o.note));
  job.reference = std::move(reference);
  job.note = std::move(note);
  job.rescan = o.rescan;
  for (std::size_t i = 0; i < input_kinds.size(); ++i)
    if (!o.files[i].empty()) job.files[std::string(input_kinds[i].name)] = o.files[i];
  job.kind = kind_of(o);
  return client.submit(job, [&](double fraction) {
    bar.show("upload", fraction);
    return going();
  });
}

// Until the job has ended. A server that goes away is asked again for a minute.
Result<RemoteJob> follow(Client& client, const std::string& id, bool reached, ProgressBar& bar) {
  auto last_answer = steady_clock::now();
  for (;;) {
    auto job = client.job(id, going);
    if (job) {
      reached = true;
      last_answer = steady_clock::now();
      if (ended(job->state)) return job;
      bar.show(job->stage ? name(*job->stage) : name(job->state), job->progress);
    } else if (!reached || job.error().code != Code::unavailable ||
               steady_clock::now() - last_answer > std::chrono::minutes(1)) {
      return job;
    }
    ::poll(nullptr, 0, 500);  // a signal ends it early
    if (!going()) return fail(Code::cancelled, "interrupted");
  }
}

Result<void> download_all(Client& client, const RemoteJob& job, const std::string& out, ProgressBar& bar) {
  std::error_code ec;
  std::filesystem::create_directories(out, ec);
  if (ec) return fail(Code::unreadable, "the folder cannot be made", out, "check its name and permissions");
  double done = 0;
  for (const RemoteArtifact& artifact : job.artifacts) {
    bar.show("download", done++ / static_cast<double>(job.artifacts.size()));
    VACUFORM_CHECK(client.download(job.id, artifact, out, going));
  }
  return {};
}

// The figures and warnings of a job, whatever its kind; null if it has none.
const RemoteArtifact* report_of(const RemoteJob& job) {
  for (const JobKind kind : {JobKind::print, JobKind::inspection, JobKind::layout})
    for (const RemoteArtifact& artifact : job.artifacts)
      if (artifact.name == vacuform::report_of(kind)) return &artifact;
  return nullptr;
}

// Only this artifact, by way of a temporary folder.
Result<nlohmann::ordered_json> fetch(Client& client, const RemoteJob& job, const RemoteArtifact& artifact) {
  std::string folder = (std::filesystem::temp_directory_path() / "vacuform-XXXXXX").string();
  if (!::mkdtemp(folder.data()))
    return fail(Code::unreadable, "a temporary folder cannot be made", folder, "check TMPDIR");
  const auto downloaded = client.download(job.id, artifact, folder, going);
  auto report = read_report(std::filesystem::path(folder) / artifact.name);
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  VACUFORM_CHECK(downloaded);
  return report;
}

// Fetches what is asked for, and gives the report.
Result<nlohmann::ordered_json> collect(Client& client, const RemoteJob& job, const std::string& out,
                                       ProgressBar& bar) {
  const RemoteArtifact* report = report_of(job);
  if (!out.empty()) VACUFORM_CHECK(download_all(client, job, out, bar));
  if (!report) return nlohmann::ordered_json();
  if (out.empty()) return fetch(client, job, *report);
  return read_report(std::filesystem::path(out) / report->name);
}

int submit(const SubmitOptions& o) {
  const auto token = find_token(o.token_file);
  if (!token) return refuse(token.error());
  auto client = Client::to(o.server, *token);
  if (!client) return refuse(client.error());
  if (o.job.empty() && o.from.empty() && lacks_files(o))
    return refuse(
        {Code::bad_usage,
         "submit needs a scan and, for a print, a pattern; or a job to begin with or to come back to", "",
         "give --scan FILE and --pattern FILE, or --from ID, or --job ID"});

  struct sigaction action {};
  action.sa_handler = interrupt;  // no SA_RESTART: waiting ends at once
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);

  const auto otherwise =
      o.wait && !o.outcome.json ? ProgressBar::Otherwise::line_a_stage : ProgressBar::Otherwise::silent;
  ProgressBar bar =
      o.outcome.quiet ? ProgressBar(ProgressBar::Otherwise::silent, false) : ProgressBar(otherwise);
  std::string id = o.job;
  if (id.empty()) {
    const auto created = create(*client, o, bar);
    bar.clear();
    if (!created && !going())
      return refuse(
          {Code::cancelled, "interrupted while uploading", "", "nothing was submitted; submit again"});
    if (!created) return refuse(created.error());
    id = created->id;
  }
  if (!o.outcome.json) {  // that is one JSON object and nothing else
    std::printf("%s\n", client->job_url(id).c_str());
    std::fflush(stdout);
  }
  if (!o.wait) return 0;

  // What to do about whatever ends the waiting but not the job.
  const auto come_back = [&](Error error) {
    bar.clear();
    error.fix = "the job goes on; come back with vacuform submit --server " + o.server + " --job " + id +
                " --wait" + (o.out.empty() ? "" : " --out " + o.out) +
                (o.token_file.empty() ? "" : " --token-file " + o.token_file) +
                ", or cancel it on its page, " + o.server + "/jobs/" + id;
    return refuse(error);
  };
  const auto job = follow(*client, id, o.job.empty(), bar);
  if (!going()) return come_back({Code::cancelled, "interrupted while waiting", "", ""});
  if (!job && job.error().code == Code::unavailable) return come_back(job.error());
  if (!job) return refuse(job.error());
  bar.clear();
  if (job->state == JobState::cancelled) return refuse({Code::cancelled, "the job was cancelled", id, ""});
  if (job->state == JobState::failed)
    return refuse(job->problem.value_or(Error{Code::internal, "the job failed without saying why", id, ""}));
  const auto report = collect(*client, *job, o.out, bar);
  bar.clear();
  if (!going())
    return refuse({Code::cancelled, "interrupted while downloading", "",
                   "the artifacts are at " + client->job_url(id)});
  if (!report) return refuse(report.error());
  tell(o.outcome, *report, o.out.empty() ? client->job_url(id) : o.out);
  return exit_code_of(o.outcome, *report);
}

}  // namespace

void add_submit(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<SubmitOptions>();
  CLI::App* command =
      app.add_subcommand("submit", "Make a job on a server and, if asked, wait for its artifacts");
  command->add_option("--server", options->server, "Address of the server")
      ->type_name("URL")
      ->capture_default_str();
  command
      ->add_option(
          "--token-file", options->token_file,
          "File that holds your token (default: VACUFORM_TOKEN, or the file that VACUFORM_TOKEN_FILE names)")
      ->type_name("FILE");
  options->settings.add_to(*command);
  auto* job = command->add_option("--job", options->job, "Come back to a job that was submitted before")
                  ->type_name("ID");
  command
      ->add_option("--from", options->from,
                   "Begin with the files and settings of this job; what is given as well replaces them")
      ->type_name("ID")
      ->excludes(job);
  command
      ->add_option("--kind", options->kind,
                   "What to make: the print, an inspection of the scan, or a layout of coils for it")
      ->check(CLI::IsMember(std::vector<std::string>(job_kind_names.begin(), job_kind_names.end())))
      ->capture_default_str()
      ->excludes(job);
  for (std::size_t i = 0; i < input_kinds.size(); ++i)
    command
        ->add_option("--" + std::string(input_kinds[i].name), options->files[i],
                     std::string(input_kinds[i].title) + " (" + std::string(input_kinds[i].extensions) + ")")
        ->type_name("FILE")
        ->excludes(job);
  command->add_option("--reference", options->reference, std::string(reference_hint))
      ->type_name("TEXT")
      ->excludes(job);
  command
      ->add_flag("--rescan", options->rescan, "The scan is another one of the patient who has the reference")
      ->excludes(job);
  command->add_option("--note", options->note, std::string(note_hint))->type_name("TEXT")->excludes(job);
  auto* wait = command->add_flag("--wait", options->wait, "Wait until the job has ended");
  command->add_option("--out", options->out, "Folder for the artifacts")->type_name("DIR")->needs(wait);
  const auto added = options->outcome.add_to(*command);
  added.json->needs(wait);
  added.strict->needs(wait);
  command->callback([options, &exit_code] { exit_code = submit(*options); });
}

}  // namespace vacuform::cli
