#include "api/base/configuration.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "api/base/strict_json.hpp"
#include "api/base/text.hpp"

namespace vacuform {

namespace {

// lease_seconds -> --lease-seconds
std::string option_of(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return name.insert(0, "--");
}

std::string raised(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

ConfigurationSources::ConfigurationSources(CLI::App& app, const std::string& program)
    : app_(app),
      default_file_("/etc/vacuform/" + program + ".json"),
      prefix_("VACUFORM_" + raised(program) + "_") {
  app_.add_option("--config", file_,
                  "File of these settings, a JSON object. --some-name is some_name there and " + prefix_ +
                      "SOME_NAME in the environment, which is stronger than the file and weaker than the "
                      "command line")
      ->type_name("FILE")
      ->default_str(default_file_);
  app_.add_flag("--check-config", only_check_, "Print the settings that would be in force, and do not start");
}

CLI::Option* ConfigurationSources::add(const std::string& name, Value value, const std::string& text) {
  settings_.push_back({name, value});
  if (bool* const* flag = std::get_if<bool*>(&value)) return app_.add_flag(option_of(name), **flag, text);
  return std::visit(
      [&](auto* target) { return app_.add_option(option_of(name), *target, text)->capture_default_str(); },
      value);
}

std::string ConfigurationSources::text() const {
  nlohmann::ordered_json all;
  for (const Setting& setting : settings_) {
    nlohmann::ordered_json& entry = all[setting.name];
    std::visit([&entry](const auto* value) { entry = *value; }, setting.value);
  }
  return all.dump(2);
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
  const char* named = ::getenv((prefix_ + "CONFIG").c_str());
  std::string file = named ? named : std::filesystem::exists(default_file_) ? default_file_ : "";
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i].starts_with("--config=")) file = words[i].substr(9);
    if (words[i] == "--config" && i + 1 < words.size()) file = words[i + 1];
  }
  if (!file.empty()) VACUFORM_CHECK(read_file(file));
  VACUFORM_CHECK(read_environment());
  return take("", std::move(words));
}

bool ConfigurationSources::has(const std::string& name) const {
  return std::any_of(settings_.begin(), settings_.end(), [&](const Setting& s) { return s.name == name; });
}

Error ConfigurationSources::unknown(const std::string& name, const std::string& source) const {
  std::string known;
  for (const Setting& setting : settings_) known.append(known.empty() ? "" : ", ").append(setting.name);
  return {Code::bad_usage, "there is no such setting: " + name, source, "known are " + known};
}

Result<void> ConfigurationSources::read_file(const std::string& file) {
  std::ifstream in(file);
  if (!in) return fail(Code::unreadable, "the configuration cannot be read", file, "see --config");
  auto object = strict_json<nlohmann::json>(std::string(std::istreambuf_iterator<char>(in), {}));
  if (!object) {
    object.error().where = file;
    return tl::make_unexpected(object.error());
  }
  if (!object->is_object()) return fail(Code::bad_usage, "the configuration is not a JSON object", file);
  std::vector<std::string> words;
  for (const auto& [name, value] : object->items()) {
    if (!has(name)) return tl::make_unexpected(unknown(name, file));
    if (!value.is_string() && !value.is_number() && !value.is_boolean())
      return fail(Code::bad_usage, "neither a text, nor a number, nor true or false: " + name, file);
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    if (!text.empty()) words.push_back(option_of(name) + "=" + text);
  }
  return take(file, std::move(words));
}

Result<void> ConfigurationSources::read_environment() {
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry;
    const std::size_t equals = text.find('=');
    if (!text.starts_with(prefix_) || equals == std::string::npos) continue;
    const std::string variable = text.substr(0, equals), name = lower(variable.substr(prefix_.size()));
    if (name == "config") continue;
    if (!has(name)) return tl::make_unexpected(unknown(name, variable));
    if (equals + 1 < text.size())
      VACUFORM_CHECK(take(variable, {option_of(name) + "=" + text.substr(equals + 1)}));
  }
  return {};
}

}  // namespace vacuform
