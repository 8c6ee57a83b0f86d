#include "worker/cli/settings_options.hpp"

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "api/settings.hpp"

namespace vacuform::cli {

void SettingsOptions::add_to(CLI::App& command) {
  command.add_option("--settings", file, "JSON file of settings; what is absent keeps its default")
      ->type_name("FILE");
  command
      .add_option("--set", assignments,
                  "One setting, on top of the file's, such as print.dpi=600; may be repeated")
      ->type_name("GROUP.KEY=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

Result<nlohmann::json> SettingsOptions::read() const {
  nlohmann::json object = nlohmann::json::object();
  if (!file.empty()) {
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (!in || text.size() > 1u << 20)
      return fail(Code::unreadable, "the settings cannot be read", file, "give a JSON file of at most 1 MiB");
    object = nlohmann::json::parse(text, nullptr, false);
    if (!object.is_object())
      return fail(Code::bad_settings, "the settings are not a JSON object", file,
                  "write {\"print\": {\"dpi\": 300}}");
  }
  for (const std::string& assignment : assignments) VACUFORM_CHECK(set_in_json(object, assignment));
  VACUFORM_CHECK(settings_from_json(object));
  return object;
}

}  // namespace vacuform::cli
