#include "server/commands/configuration.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <string_view>

#include "api/base/text.hpp"
#include "server/messages/origin.hpp"
#include "server/store/blobs/s3/s3_address.hpp"

namespace vacuform {

namespace {

constexpr std::string_view scheme = "https://";

}  // namespace

std::string Configuration::front_host() const {
  return front.empty() ? front : lower(front.substr(scheme.size()));
}

StoreOptions Configuration::store_options() const {
  StoreOptions options;
  options.database = store;
  options.blobs = blobs;
  options.blobs_credentials = blobs_credentials;
  options.quarantine_days = quarantine_days;
  return options;
}

Result<Address> listen_address(const std::string& text, const std::string& option, const std::string& front) {
  const std::size_t colon = text.rfind(':');
  Address address;
  address.host = text.substr(0, colon);
  const std::string port = colon == std::string::npos ? "" : text.substr(colon + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
  if (port.empty() || error != std::errc() || end != port.data() + port.size() || address.port < 0 ||
      address.port > 65535)
    return fail(Code::bad_usage, "not an address with a port: " + text, option,
                "give for example 127.0.0.1:8080");
  if (!http::is_loopback_host(address.host) && front.empty())
    return fail(Code::bad_usage, "refusing to listen on " + address.host + " without a TLS front", option,
                "give 127.0.0.1, localhost or [::1], or name the front with --front (see deploy/nginx.conf)");
  if (address.host == "localhost") address.host = "127.0.0.1";
  if (address.host.starts_with('[') && address.host.ends_with(']'))
    address.host = address.host.substr(1, address.host.size() - 2);
  return address;
}

Result<void> check(const Configuration& configuration) {
  const std::string host = configuration.front_host();
  const bool plain = !host.empty() && std::all_of(host.begin(), host.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == ':' || c == '[' ||
           c == ']';
  });
  if (!configuration.front.empty() && (!configuration.front.starts_with(scheme) || !plain))
    return fail(Code::bad_usage, "not the address of a TLS front: " + configuration.front, "--front",
                "give for example https://vacuform.example.org");
  VACUFORM_CHECK(listen_address(configuration.listen, "--listen", configuration.front));
  VACUFORM_CHECK(check_database(configuration.store));
  VACUFORM_CHECK(check_blobs(configuration.blobs));
  VACUFORM_CHECK(listen_address(configuration.status_listen, "--status-listen", configuration.front));
  if (!configuration.worker_user.empty() && ::geteuid() != 0)
    return fail(Code::bad_usage, "only root can start workers as another user", "--worker-user",
                "leave --worker-user out, or start the server as root");
  if (configuration.workers > 0 && ::access(configuration.worker_program.c_str(), X_OK) != 0)
    return fail(Code::bad_usage, "there is no worker program", configuration.worker_program.string(),
                "give its path with --worker-program");
  return {};
}

void Configuration::add_to(ConfigurationSources& sources) {
  worker_program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "vacuform-worker";
  sources.add("listen", &listen,
              "Address and port, on loopback unless there is a --front; port 0 takes any free one");
  sources.add("status_listen", &status_listen,
              "Address and port of /healthz, /readyz and /metrics; port 0 takes any free one, which the log "
              "names");
  sources.add(
      "front", &front,
      "The TLS front through which other machines come, as https://NAME: requests under that name are "
      "answered, and --listen may lie beyond loopback");
  sources.add("data", &data, "Folder of the jobs, made when absent");
  sources
      .add("store", &store,
           "PostgreSQL database that keeps the jobs, as postgresql://USER@HOST/DATABASE without a password, "
           "instead "
           "of a file of SQLite in --data; scans and results stay in --data unless --blobs is given")
      ->type_name("URL");
  sources
      .add("blobs", &blobs,
           "Object store that keeps scans and results, as s3://BUCKET?endpoint=https://HOST&region=NAME, "
           "instead "
           "of files in --data")
      ->type_name("URL");
  sources
      .add("blobs_credentials", &blobs_credentials,
           "File with aws_access_key_id and aws_secret_access_key for --blobs, instead of AWS_ACCESS_KEY_ID "
           "and "
           "AWS_SECRET_ACCESS_KEY in the environment")
      ->type_name("FILE");
  sources.add("workers", &workers, "Workers to start on this machine")->check(CLI::Range(0, 256));
  sources
      .add("lease_seconds", &lease_seconds,
           "Silence of a worker after which another gets its job; workers report every second")
      ->check(CLI::Range(3, 3600));
  sources
      .add("check_hours", &check_hours,
           "Hours from one check of the database and of all files for damage to the next; 0: none")
      ->check(CLI::Range(0.0, 8760.0));
  sources
      .add("check_mib_per_second", &check_mib_per_second, "MiB that such a check reads in a second at most")
      ->check(CLI::Range(1, 10'000));
  sources
      .add("quarantine_days", &quarantine_days,
           "Days after which a file is deleted that belonged to no job and was moved to DATA/quarantine")
      ->check(CLI::Range(1, 3650));
  sources.add("worker_program", &worker_program, "The worker");
  sources
      .add("worker_user", &worker_user,
           "User that the workers become, when root starts this: it cannot read the folder of --data")
      ->type_name("NAME");
  sources
      .add("log", &log,
           "File for the log, of the workers too, instead of standard error; at 32 MiB its lines go to "
           "FILE.1, in place of "
           "those that are there")
      ->type_name("FILE");
  sources.add("port_file", &port_file, "File that receives the port when the server is ready");
  sources.add("status_port_file", &status_port_file, "File that receives the port of --status-listen");
}

}  // namespace vacuform
