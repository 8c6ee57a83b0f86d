// How a program is to run: from a file, from the environment and from the command line, each stronger than the one before it.
//
// Every setting has one name: of vacuform-server, `lease_seconds` in the file (a JSON object), VACUFORM_SERVER_LEASE_SECONDS in
// the environment, --lease-seconds on the command line. Unknown names are refused wherever they stand; an empty text says
// nothing. No setting is a secret: tokens are files of their own, which settings name at most.
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "api/base/error.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace vacuform {

class ConfigurationSources {
 public:
  using Value = std::variant<std::string*, int*, double*, bool*, std::filesystem::path*>;

  // `program` is "server" or "worker": the file is /etc/vacuform/<program>.json unless --config or
  // VACUFORM_<PROGRAM>_CONFIG names another (an empty text: none), and the variables begin with VACUFORM_<PROGRAM>_. Adds
  // --config and --check-config. `app` must outlive this.
  ConfigurationSources(CLI::App& app, const std::string& program);
  // Adds a setting under its name in the file. `value` holds its default, receives what is read, and must outlive this. Gives
  // the option of the command line, for checks of its values.
  CLI::Option* add(const std::string& name, Value value, const std::string& text);
  // Errors: bad_usage with the source, the name and, where it is unknown, the names there are; unreadable. Throws CLI::Success
  // for --help and --version.
  Result<void> read(int argc, char** argv);
  // What is in force, as the file would have it.
  std::string text() const;
  // --check-config: print that text, and do not start.
  bool only_check() const { return only_check_; }

 private:
  struct Setting {
    std::string name;
    Value value;
  };
  bool has(const std::string& name) const;
  Error unknown(const std::string& name, const std::string& source) const;
  Result<void> read_file(const std::string& file);
  Result<void> read_environment();
  Result<void> take(const std::string& source, std::vector<std::string> words);

  CLI::App& app_;
  std::string default_file_, prefix_;  // VACUFORM_SERVER_
  std::vector<Setting> settings_;
  std::string file_;
  bool only_check_ = false;
};

}  // namespace vacuform
