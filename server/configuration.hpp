// How vacuform-server is to run: from a file, from the environment and from the command line, each stronger than the one
// before it.
//
// Every setting has one name: `lease_seconds` in the file (a JSON object), VACUFORM_SERVER_LEASE_SECONDS in the
// environment, --lease-seconds on the command line. Unknown names are refused wherever they stand; an empty text says nothing. None of the settings is
// a secret: tokens are files in the data folder.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "api/error.hpp"

namespace vacuform {

struct Configuration {
  std::string listen = "127.0.0.1:8080";
  std::string status_listen = "127.0.0.1:0";
  std::string front;  // "https://vacuform.example.org", the TLS front; empty: there is none
  std::filesystem::path data = "vacuform-data";
  int workers = 0;
  int lease_seconds = 30;
  std::filesystem::path worker_program;  // empty: vacuform-worker beside this program
  std::filesystem::path port_file, status_port_file;

  // The front's name, with its port where one is given, as browsers send it in Host.
  std::string front_host() const;
};

struct Address {
  std::string host;
  int port = 0;
};

// "127.0.0.1:8080". Errors: bad_usage when it is no address, or lies beyond loopback and there is no front.
Result<Address> listen_address(const std::string& text, const std::string& option, const std::string& front);

// All of it that can be told without starting: addresses, the front, the worker program.
Result<void> check(const Configuration& configuration);

// The configuration as the file would have it.
std::string to_text(const Configuration& configuration);

// Where it comes from.
class ConfigurationSources {
 public:
  static constexpr const char* default_file = "/etc/vacuform/server.json";

  // Adds the options, whose values go to `into`; both must outlive this.
  ConfigurationSources(CLI::App& app, Configuration& into);
  // Reads the file (--config, else VACUFORM_SERVER_CONFIG, else default_file where it exists), the environment, and the
  // command line. Errors: bad_usage with the source, the name and, where it is unknown, the names there are; unreadable.
  // Throws CLI::Success for --help.
  Result<void> read(int argc, char** argv);
  bool only_check() const { return only_check_; }

 private:
  Result<void> read_file(const std::string& file);
  Result<void> read_environment();
  Result<void> take(const std::string& source, std::vector<std::string> words);

  CLI::App& app_;
  std::vector<std::string> names_;
  std::string file_;
  bool only_check_ = false;
};

}  // namespace vacuform
