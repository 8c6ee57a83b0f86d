// vacuform-server: the options, the lifetime, the signals.
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/log.hpp"
#include "server/http/origin.hpp"
#include "server/http/server.hpp"
#include "server/local_workers.hpp"
#include "server/problem.hpp"
#include "server/secrets.hpp"
#include "server/service.hpp"
#include "server/status_routes.hpp"
#include "server/token_command.hpp"
#include "server/tokens.hpp"

namespace vacuform {
namespace {

struct Options {
  std::string listen = "127.0.0.1:8080", status_listen = "127.0.0.1:0";
  std::filesystem::path data = "vacuform-data";
  int workers = 0;
  int lease_seconds = 30;
  std::filesystem::path worker_program;
  std::filesystem::path port_file, status_port_file;
};

struct Address {
  std::string host;
  int port = 0;
};

Result<Address> loopback_address(const std::string& listen, const std::string& option) {
  const std::size_t colon = listen.rfind(':');
  Address address;
  address.host = listen.substr(0, colon);
  const std::string port = colon == std::string::npos ? "" : listen.substr(colon + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
  if (port.empty() || error != std::errc() || end != port.data() + port.size() || address.port < 0 ||
      address.port > 65535)
    return fail(Code::bad_usage, "not an address with a port: " + listen, option,
                "give for example 127.0.0.1:8080");
  if (!http::is_loopback_host(address.host))
    return fail(Code::bad_usage, "refusing to listen on " + address.host + " without a TLS front", option,
                "give 127.0.0.1, localhost or [::1]");
  if (address.host == "localhost") address.host = "127.0.0.1";
  if (address.host == "[::1]") address.host = "::1";
  return address;
}

// The tokens that a service needs to begin with, each in a file of its own in the data folder.
Result<void> first_tokens(Store& store, const std::filesystem::path& data,
                          const std::filesystem::path& worker_token) {
  VACUFORM_CHECK(token_in_file(store, worker_token, {"local-workers", {Scope::work}, std::nullopt}));
  VACUFORM_TRY(tokens, store.tokens());
  const bool someone_can_make_more = std::any_of(tokens.begin(), tokens.end(), [](const Token& token) {
    return token.scopes.has(Scope::admin) && usable(token, wall_clock());
  });
  if (someone_can_make_more) return {};
  VACUFORM_CHECK(token_in_file(store, data / "admin-token", {"admin", {Scope::admin}, std::nullopt}));
  log_event("admin-token-made", {{"file", "admin-token"}});
  return {};
}

void observe(Metrics& metrics, const http::Answered& answered) {
  metrics.answered(answered);
  if (answered.status < 400) return;  // what a job went through is logged by its own events
  nlohmann::ordered_json fields = {{"method", answered.method},
                                   {"route", answered.route},
                                   {"status", answered.status},
                                   {"seconds", answered.seconds}};
  if (!answered.fault.empty()) fields["fault"] = answered.fault;
  log_event(answered.status < 500 ? "request-refused" : "request-failed", fields);
}

std::string url_of(const Address& address, const http::Server& server) {
  const std::string host = address.host == "::1" ? "[::1]" : address.host;
  return "http://" + host + ":" + std::to_string(server.port());
}

// Its few threads are its own, and a slow client keeps one for a second at most.
http::ServerOptions status_listener(const Address& address) {
  http::ServerOptions listener;
  listener.host = address.host;
  listener.port = address.port;
  listener.threads = 8;
  listener.streams = 0;
  listener.limits.head_time = std::chrono::seconds(1);
  listener.limits.wait = std::chrono::seconds(1);
  listener.refuse = [](const http::Request&, const http::Refusal& refusal) {
    return problem_response(refusal.error, refusal.status);
  };
  return listener;
}

Result<void> tell_port(const std::filesystem::path& file, const http::Server& server) {
  if (file.empty()) return {};
  return write_text_file(file, std::to_string(server.port()) + "\n");
}

// Serves until SIGTERM or SIGINT.
Result<void> serve(const Options& options) {
  VACUFORM_TRY(address, loopback_address(options.listen, "--listen"));
  VACUFORM_TRY(status_address, loopback_address(options.status_listen, "--status-listen"));
  if (!start_secrets()) return fail(Code::internal, "this machine gives no random numbers");
  const std::filesystem::path program =
      options.worker_program.empty()
          ? std::filesystem::read_symlink("/proc/self/exe").parent_path() / "vacuform-worker"
          : std::filesystem::absolute(options.worker_program);
  if (options.workers > 0 && ::access(program.c_str(), X_OK) != 0)
    return fail(Code::bad_usage, "there is no worker program", program.string(),
                "give its path with --worker-program");

  // Blocked before the first thread starts, so that only this thread hears them.
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGCHLD}) sigaddset(&signals, signal);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  ::signal(SIGPIPE, SIG_IGN);

  StoreOptions store_options;
  store_options.lease = options.lease_seconds * Millis{1000};
  VACUFORM_TRY(store, open_store(options.data, store_options));
  const std::filesystem::path token_file = std::filesystem::absolute(options.data / "worker-token");
  VACUFORM_CHECK(first_tokens(*store, options.data, token_file));
  Access access(*store);
  Workers seen_workers;
  Service service{*store, access, seen_workers, static_cast<int>(store_options.lease / 1000)};

  Metrics metrics;
  http::ServerOptions listener;
  listener.host = address.host;
  listener.port = address.port;
  listener.refuse = refuse;
  listener.observe = [&metrics](const http::Answered& answered) { observe(metrics, answered); };
  VACUFORM_TRY(server, http::Server::start(listener, all_routes(service)));
  Status status{*store,
                metrics,
                options.data,
                [&server] { return server->connections(); },
                listener.threads + listener.streams,
                [&server] { return server->streams(); },
                listener.streams};
  VACUFORM_TRY(status_server, http::Server::start(status_listener(status_address), status_routes(status)));
  const std::string url = url_of(address, *server), status_url = url_of(status_address, *status_server);
  VACUFORM_CHECK(write_text_file(options.data / "server-url", url + "\n"));  // for vacuform-server token
  VACUFORM_CHECK(tell_port(options.status_port_file, *status_server));
  VACUFORM_CHECK(tell_port(options.port_file, *server));
  log_event(
      "server-started",
      {{"url", url}, {"status_url", status_url}, {"process", ::getpid()}, {"workers", options.workers}});

  const auto log_expired = [&metrics](const Result<std::vector<Expired>>& expired) {
    if (!expired) return log_event("store-failed", {{"problem", expired.error().text()}});
    metrics.leases_lost(expired->size());
    for (const Expired& e : *expired) log_event("lease-expired", {{"job", e.job}, {"state", name(e.state)}});
  };
  // Workers of an earlier run died with it; their jobs need not wait for the leases to end.
  for (int i = 0; i < options.workers; ++i)
    log_expired(store->bury(LocalWorkers::name_of(static_cast<std::size_t>(i))));
  LocalWorkers workers({program, url, token_file}, options.workers);
  for (;;) {
    for (const std::string& dead : workers.tend()) log_expired(store->bury(dead));
    const timespec second{1, 0};
    const int signal = ::sigtimedwait(&signals, nullptr, &second);
    if (signal == SIGTERM || signal == SIGINT) break;
    log_expired(store->expire());
  }
  log_event("server-stopping", nlohmann::ordered_json::object());
  workers.stop();         // they give their jobs back while the server still answers
  status_server.reset();  // it looks at the other one
  server.reset();
  log_event("server-stopped", nlohmann::ordered_json::object());
  return {};
}

}  // namespace
}  // namespace vacuform

int main(int argc, char** argv) {
  ::umask(0077);  // scans of patients are nobody else's to read
  vacuform::Options options;
  CLI::App app(
      "The HTTP service of Vacuform: takes scans and patterns, hands jobs to workers, keeps the results.");
  app.add_option("--listen", options.listen, "Loopback address and port; port 0 takes any free one")
      ->capture_default_str();
  app.add_option("--data", options.data, "Folder of the jobs, made when absent")->capture_default_str();
  app.add_option("--workers", options.workers, "Workers to start on this machine")
      ->check(CLI::Range(0, 256))
      ->capture_default_str();
  app.add_option("--lease-seconds", options.lease_seconds,
                 "Silence of a worker after which its job is given to another; workers give a sign of life "
                 "every second")
      ->check(CLI::Range(3, 3600))
      ->capture_default_str();
  app.add_option("--worker-program", options.worker_program,
                 "The worker (default: vacuform-worker beside this program)");
  app.add_option("--port-file", options.port_file, "File that receives the port when the server is ready");
  app.add_option(
         "--status-listen", options.status_listen,
         "Loopback address and port of /healthz, /readyz and /metrics; port 0 takes any free one, which "
         "the log names")
      ->capture_default_str();
  app.add_option("--status-port-file", options.status_port_file,
                 "File that receives the port of --status-listen");
  vacuform::TokenCommand token;
  token.add_to(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "vacuform-server: %s; see --help\n", error.what());
    return 2;
  }
  try {
    const auto served = token.asked() ? token.run() : vacuform::serve(options);
    if (served) return 0;
    std::fprintf(stderr, "vacuform-server: %s\n", served.error().text().c_str());
    return vacuform::meaning(served.error().code).exit_code;
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "vacuform-server: internal fault: %s\n", fault.what());
    return 1;
  }
}
