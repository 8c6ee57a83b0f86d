#include "worker/cli/settings_options.hpp"

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "api/settings.hpp"

namespace vacuform::cli {

void SettingsOptions::add_to(CLI::App& command) {
  command
      .add_option(
          "--settings", files,
          "JSON file of settings, such as one of deploy/profiles; what is absent keeps its default; may "
          "be repeated, and a later file wins")
      ->type_name("FILE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      .add_option("--set", assignments,
                  "One setting, on top of the files', such as print.dpi=600; may be repeated")
      ->type_name("GROUP.KEY=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_flag("--preview", preview,
                   "A quick look: a grid of 6 mm and a print of 100 dpi, unless they are set");
}

namespace {

Result<nlohmann::json> read_object(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in || text.size() > 1u << 20)
    return fail(Code::unreadable, "the settings cannot be read", file, "give a JSON file of at most 1 MiB");
  auto parsed = settings_json(text);
  if (!parsed) {
    parsed.error().where = file;
    return parsed;
  }
  nlohmann::json& object = *parsed;
  if (!object.is_object())
    return fail(Code::bad_settings, "the settings are not a JSON object", file,
                "write {\"print\": {\"dpi\": 300}}");
  object.erase("calibration");  // the notes of a machine profile about itself are not settings
  return parsed;
}

void put_over(nlohmann::json& under, nlohmann::json&& over) {
  for (auto& [group, values] : over.items())
    if (values.is_object() && under[group].is_object())
      under[group].update(values);
    else
      under[group] = std::move(values);
}

}  // namespace

Result<nlohmann::json> SettingsOptions::read() const {
  nlohmann::json object = nlohmann::json::object();
  if (preview) object = {{"sheet", {{"resolution_mm", 6}}}, {"print", {{"dpi", 100}}}};
  for (const std::string& file : files) {
    VACUFORM_TRY(of_file, read_object(file));
    put_over(object, std::move(of_file));
  }
  for (const std::string& assignment : assignments) VACUFORM_CHECK(set_in_json(object, assignment));
  VACUFORM_CHECK(settings_from_json(object));
  return object;
}

}  // namespace vacuform::cli
