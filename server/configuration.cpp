#include "server/configuration.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>

#include "server/http/origin.hpp"

namespace vacuform {

namespace {

constexpr std::string_view prefix = "VACUFORM_SERVER_";
constexpr std::string_view scheme = "https://";

// lease_seconds <-> lease-seconds
std::string exchanged(std::string text, char from, char to) {
  std::replace(text.begin(), text.end(), from, to);
  return text;
}

std::string lowered(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string listed(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

std::filesystem::path beside_this_program(const std::filesystem::path& name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
}

}  // namespace

std::string Configuration::front_host() const {
  return front.empty() ? front : lowered(front.substr(scheme.size()));
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
  VACUFORM_CHECK(listen_address(configuration.status_listen, "--status-listen", configuration.front));
  if (configuration.workers > 0 && ::access(configuration.worker_program.c_str(), X_OK) != 0)
    return fail(Code::bad_usage, "there is no worker program", configuration.worker_program.string(),
                "give its path with --worker-program");
  return {};
}

std::string to_text(const Configuration& c) {
  return nlohmann::ordered_json({{"listen", c.listen},
                                 {"status_listen", c.status_listen},
                                 {"front", c.front},
                                 {"data", c.data.string()},
                                 {"workers", c.workers},
                                 {"lease_seconds", c.lease_seconds},
                                 {"worker_program", c.worker_program.string()},
                                 {"port_file", c.port_file.string()},
                                 {"status_port_file", c.status_port_file.string()}})
      .dump(2);
}

ConfigurationSources::ConfigurationSources(CLI::App& app, Configuration& into) : app_(app) {
  into.worker_program = beside_this_program("vacuform-worker");
  const auto add = [this](const std::string& name, auto& value, const std::string& text) {
    names_.push_back(name);
    return app_.add_option("--" + exchanged(name, '_', '-'), value, text)->capture_default_str();
  };
  add("listen", into.listen,
      "Address and port, on loopback unless there is a --front; port 0 takes any free one");
  add("status_listen", into.status_listen,
      "Address and port of /healthz, /readyz and /metrics; port 0 takes any free one, which the log names");
  add("front", into.front,
      "The TLS front through which other machines come, as https://NAME: requests under that name are "
      "answered, and "
      "--listen may lie beyond loopback");
  add("data", into.data, "Folder of the jobs, made when absent");
  add("workers", into.workers, "Workers to start on this machine")->check(CLI::Range(0, 256));
  add("lease_seconds", into.lease_seconds,
      "Silence of a worker after which its job is given to another; workers give a sign of life every second")
      ->check(CLI::Range(3, 3600));
  add("worker_program", into.worker_program, "The worker");
  add("port_file", into.port_file, "File that receives the port when the server is ready");
  add("status_port_file", into.status_port_file, "File that receives the port of --status-listen");
  app_.add_option("--config", file_,
                  "File of these settings, as JSON: lease_seconds for --lease-seconds; "
                  "VACUFORM_SERVER_LEASE_SECONDS in "
                  "the environment is stronger than the file, the command line than both")
      ->default_str(default_file);
  app_.add_flag("--check-config", only_check_, "Print the settings that would be in force, and do not start");
}

Result<void> ConfigurationSources::take(const std::string& source, std::vector<std::string> words) {
  std::reverse(words.begin(), words.end());  // as CLI11 takes them
  try {
    app_.parse(std::move(words));
  } catch (const CLI::Success&) {
    throw;
  } catch (const CLI::ParseError& error) {
    return fail(Code::bad_usage, error.what(), source, "see --help");
  }
  return {};
}

Result<void> ConfigurationSources::read(int argc, char** argv) {
  // The file's name first: what it says is weaker than the rest.
  std::vector<std::string> words(argv + 1, argv + argc);
  const char* named = ::getenv("VACUFORM_SERVER_CONFIG");
  std::string file = named ? named : std::filesystem::exists(default_file) ? default_file : "";
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i].starts_with("--config=")) file = words[i].substr(9);
    if (words[i] == "--config" && i + 1 < words.size()) file = words[i + 1];
  }
  if (!file.empty()) VACUFORM_CHECK(read_file(file));
  VACUFORM_CHECK(read_environment());
  return take("", std::move(words));
}

Result<void> ConfigurationSources::read_file(const std::string& file) {
  std::ifstream in(file);
  if (!in) return fail(Code::unreadable, "the configuration cannot be read", file, "see --config");
  const auto object = nlohmann::json::parse(in, nullptr, false);
  if (!object.is_object()) return fail(Code::bad_usage, "the configuration is not a JSON object", file);
  std::vector<std::string> words;
  for (const auto& [name, value] : object.items()) {
    if (std::find(names_.begin(), names_.end(), name) == names_.end())
      return fail(Code::bad_usage, "there is no such setting: " + name, file, "known are " + listed(names_));
    if (!value.is_string() && !value.is_number_integer())
      return fail(Code::bad_usage, "neither a text nor a whole number: " + name, file);
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    if (!text.empty()) words.push_back("--" + exchanged(name, '_', '-') + "=" + text);
  }
  return take(file, std::move(words));
}

Result<void> ConfigurationSources::read_environment() {
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry;
    const std::size_t equals = text.find('=');
    if (!text.starts_with(prefix) || equals == std::string::npos) continue;
    const std::string variable = text.substr(0, equals), name = lowered(variable.substr(prefix.size()));
    if (name == "config") continue;
    if (std::find(names_.begin(), names_.end(), name) == names_.end())
      return fail(Code::bad_usage, "there is no such setting: " + name, variable,
                  "known are " + listed(names_));
    if (equals + 1 < text.size())
      VACUFORM_CHECK(take(variable, {"--" + exchanged(name, '_', '-') + "=" + text.substr(equals + 1)}));
  }
  return {};
}

}  // namespace vacuform
