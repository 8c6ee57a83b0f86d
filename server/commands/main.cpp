// vacuform-server: the options, the lifetime, the signals.
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sysexits.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/base/file.hpp"
#include "api/base/log.hpp"
#include "api/base/secrets.hpp"
#include "api/commit.hpp"
#include "api/problem.hpp"
#include "api/version.hpp"
#include "server/access/tokens.hpp"
#include "server/commands/configuration.hpp"
#include "server/commands/local_workers.hpp"
#include "server/commands/store_command.hpp"
#include "server/http/server.hpp"
#include "server/jobs/worker_caches.hpp"
#include "server/messages/problem.hpp"
#include "server/routes/routes.hpp"
#include "server/routes/status_routes.hpp"
#include "server/store/store_watch.hpp"

namespace vacuform {
namespace {

// One descriptor for each connection, one more for each download, and those of the store.
void raise_file_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = std::max(limit.rlim_cur, std::min<rlim_t>(limit.rlim_max, 4096));
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

// The tokens that a new service needs, each in its own file in the data folder.
Result<void> first_tokens(Store& store, const std::filesystem::path& data,
                          const std::filesystem::path& worker_token) {
  VACUFORM_CHECK(token_in_file(store, worker_token, {"local-workers", {Scope::work}, std::nullopt}));
  VACUFORM_TRY(tokens, store.tokens());
  const std::filesystem::path file = data / "admin-token";
  if (token_of_file(store, file, {Scope::admin})) return {};
  // The server's own commands need it. A backup contains its row but not its file, so its secret is lost there.
  VACUFORM_CHECK(token_in_file(store, file, {"admin", {Scope::admin}, std::nullopt}));
  log_event("admin-token-made", {{"file", "admin-token"}});
  if (store.shared()) return {};  // the others may be those of servers that run
  for (const Token& token : tokens) {
    if (token.file != "admin-token" || !usable(token, wall_clock())) continue;
    VACUFORM_CHECK(store.revoke_token(token.id));
    log_event("admin-token-revoked", {{"token", token.id}});
  }
  return {};
}

void observe(Metrics& metrics, const http::Answered& answered) {
  metrics.answered(answered);
  if (answered.status < 400) return;  // the events of a job are logged separately
  nlohmann::ordered_json fields = {{"method", answered.method},
                                   {"route", answered.route},
                                   {"status", answered.status},
                                   {"seconds", answered.seconds}};
  if (!answered.fault.empty()) fields["fault"] = answered.fault;
  log_event(answered.status < 500 ? "request-refused" : "request-failed", fields);
}

std::string url_of(const Address& address, const http::Server& server) {
  const bool any =
      address.host == "0.0.0.0" || address.host == "::";  // then its own workers connect to it on loopback
  const std::string host = any                                           ? "127.0.0.1"
                           : address.host.find(':') != std::string::npos ? "[" + address.host + "]"
                                                                         : address.host;
  return "http://" + host + ":" + std::to_string(server.port());
}

// A separate listener: its clients send the whole request at once.
http::ServerOptions status_listener(const Address& address) {
  http::ServerOptions listener;
  listener.host = address.host;
  listener.port = address.port;
  listener.connections = 256;
  listener.limits.head_time = std::chrono::milliseconds(500);
  listener.limits.wait = std::chrono::seconds(1);
  listener.refuse = [](const http::Request&, const http::Refusal& refusal) {
    return problem_response(refusal.error, refusal.status);
  };
  return listener;
}

// A full disk does not matter if the file already has that text.
Result<void> write_if_new(const std::filesystem::path& file, const std::string& text) {
  const auto old = read_text_file(file, 4096);
  return old && *old == text ? Result<void>() : write_text_file(file, text);
}

Result<void> tell_port(const std::filesystem::path& file, const http::Server& server) {
  if (file.empty()) return {};
  return write_if_new(file, std::to_string(server.port()) + "\n");
}

// Serves until SIGTERM or SIGINT.
Result<void> serve(const Configuration& options) {
  VACUFORM_CHECK(check(options));
  VACUFORM_TRY(address, listen_address(options.listen, "--listen", options.front));
  VACUFORM_TRY(status_address, listen_address(options.status_listen, "--status-listen", options.front));
  if (!options.log.empty()) VACUFORM_CHECK(log_into(options.log));
  if (!start_secrets()) return fail(Code::internal, "this machine provides no random numbers");
  // Blocked before the first thread starts, so that only this thread receives them.
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGCHLD}) sigaddset(&signals, signal);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
  raise_file_limit();
  when_flush_fails([] {
    log_event("disk-failed", {{"problem", "the disk did not take what it had accepted"}});
    std::_Exit(EX_IOERR);
  });

  Metrics metrics;
  StoreOptions store_options = options.store_options();
  store_options.job_ended = [&metrics](const Job& job) { metrics.job_ended(job); };
  store_options.lease = options.lease_seconds * Millis{1000};
  VACUFORM_TRY(store, open_store(options.data, store_options));
  // The workers, which this process starts, must not inherit them.
  for (const char* name : {"AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY", "AWS_SESSION_TOKEN"})
    ::unsetenv(name);
  std::optional<StoreWatch> watch;
  if (options.check_hours > 0)
    watch.emplace(*store, std::chrono::milliseconds(static_cast<std::int64_t>(options.check_hours * 3.6e6)),
                  static_cast<std::uint64_t>(options.check_mib_per_second) << 20);
  VACUFORM_TRY(kept, WorkerCaches::open(options.data, *store));
  const std::filesystem::path token_file = std::filesystem::absolute(options.data / "worker-token");
  VACUFORM_CHECK(first_tokens(*store, options.data, token_file));
  Access access(*store, *store);
  Workers seen_workers;
  VACUFORM_TRY(uploads, Uploads::open(*store, options.data / "uploads"));
  Service service{*store, access, seen_workers, *uploads, static_cast<int>(store_options.lease / 1000)};
  service.caches = kept.get();

  http::ServerOptions listener;
  listener.host = address.host;
  listener.port = address.port;
  listener.front_host = options.front_host();
  listener.refuse = refuse;
  listener.observe = [&metrics](const http::Answered& answered) { observe(metrics, answered); };
  VACUFORM_TRY(server, http::Server::start(listener, all_routes(service)));
  Status status{*store,
                metrics,
                options.data,
                [&server] { return server->connections(); },
                listener.connections,
                [&server] { return server->streams(); },
                listener.streams};
  VACUFORM_TRY(status_server, http::Server::start(status_listener(status_address), status_routes(status)));
  const std::string url = url_of(address, *server), status_url = url_of(status_address, *status_server);
  // For vacuform-server token; the service itself does not need it.
  if (const auto written = write_if_new(options.data / "server-url", url + "\n"); !written)
    log_event("file-not-written", {{"file", "server-url"}, {"problem", written.error().what}});
  VACUFORM_CHECK(tell_port(options.status_port_file, *status_server));
  VACUFORM_CHECK(tell_port(options.port_file, *server));
  log_event("server-started", {{"url", url},
                               {"status_url", status_url},
                               {"process", ::getpid()},
                               {"workers", options.workers},
                               {"version", version},
                               {"commit", commit()}});

  const auto log_expired = [&metrics](const Result<std::vector<Expired>>& expired) {
    if (!expired) return log_event("store-failed", {{"problem", expired.error().text()}});
    metrics.leases_lost(expired->size());
    for (const Expired& e : *expired) log_event("lease-expired", {{"job", e.job}, {"state", name(e.state)}});
  };
  // Workers of an earlier run died with it; their jobs do not have to wait for the leases to expire.
  for (int i = 0; i < options.workers; ++i)
    log_expired(store->end_leases_of(LocalWorkers::name_of(static_cast<std::size_t>(i))));
  LocalWorkers workers({std::filesystem::absolute(options.worker_program), url, token_file, kept->workers(),
                        options.worker_user},
                       options.workers);
  for (;;) {
    for (const std::string& dead : workers.tend()) log_expired(store->end_leases_of(dead));
    const timespec second{1, 0};
    const int signal = ::sigtimedwait(&signals, nullptr, &second);
    if (signal == SIGTERM || signal == SIGINT) break;
    log_expired(store->expire());
    kept->tidy(*store);
    bound_log(options.log);
    if (const auto collected = uploads->collect(); !collected)
      log_event("store-failed", {{"problem", collected.error().text()}});
  }
  log_event("server-stopping", nlohmann::ordered_json::object());
  workers.stop();         // they release their jobs while the server still answers
  status_server.reset();  // it reads the state of the main server
  server.reset();
  log_event("server-stopped", nlohmann::ordered_json::object());
  return {};
}

// What the program does besides serving.
using Commands = std::vector<StoreCommandPointer>;

Commands all_commands() {
  Commands commands;
  for (const auto make : {token_command, backup_command, restore_command, verify_command, adopt_command,
                          copy_store_command, orphans_command, migrate_command})
    commands.push_back(make());
  return commands;
}

Result<void> run(ConfigurationSources& sources, const Configuration& configuration, const Commands& commands,
                 int argc, char** argv) {
  VACUFORM_CHECK(sources.read(argc, argv));
  for (const auto& command : commands)
    if (command->asked()) return command->run(configuration.data, configuration.store_options());
  if (!sources.only_check()) return serve(configuration);
  VACUFORM_CHECK(check(configuration));
  std::printf("%s\n", sources.text().c_str());
  return {};
}

}  // namespace
}  // namespace vacuform

int main(int argc, char** argv) {
  ::umask(0077);  // only this user may read the scans of patients
  // The server passes it to its own workers directly: the file is for workers of another user or of another server.
  ::setenv("VACUFORM_WORKER_CONFIG", "", 0);
  CLI::App app(
      "The HTTP service of Vacuform: takes scans and patterns, hands jobs to workers, keeps the results.");
  app.set_version_flag("--version", vacuform::version_line("vacuform-server"));
  vacuform::ConfigurationSources sources(app, "server");
  vacuform::Configuration configuration;
  configuration.add_to(sources);
  const vacuform::Commands commands = vacuform::all_commands();
  for (const auto& command : commands) command->add_to(app);
  try {
    const auto done = vacuform::run(sources, configuration, commands, argc, argv);
    if (done) return 0;
    std::fprintf(stderr, "vacuform-server: %s\n", done.error().text().c_str());
    return vacuform::meaning(done.error().code).exit_code;
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "vacuform-server: internal fault: %s\n", fault.what());
    return 1;
  }
}
