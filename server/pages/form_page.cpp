#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/base/secrets.hpp"
#include "api/job_text.hpp"
#include "api/problem.hpp"
#include "api/settings.hpp"
#include "server/jobs/job_json.hpp"
#include "server/pages/pages.hpp"
#include "server/pages/template.hpp"

namespace vacuform {

using nlohmann::ordered_json;

namespace {

// The groups as a user meets them: what changes from job to job first.
constexpr std::array<std::string_view, 10> group_order{"pattern", "coils", "layout", "scan",       "sheet",
                                                       "machine", "heat",  "print",  "flattening", "forming"};

// "window_width_mm" -> "Window width"; the unit is shown beside the field.
std::string label_of(std::string key) {
  for (const std::string_view unit : {"_mm", "_deg", "_kpa", "_w_m2k", "_c"})
    if (key.ends_with(unit)) key.erase(key.size() - unit.size());
  std::replace(key.begin(), key.end(), '_', ' ');
  if (key == "dpi") return "DPI";
  key[0] = static_cast<char>(key[0] >= 'a' && key[0] <= 'z' ? key[0] - 'a' + 'A' : key[0]);
  return key;
}

// A default or a bound as a person writes it: 300, not 300.0.
std::string plain(const ordered_json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float() && std::abs(value.get<double>()) < 1e9 &&
      std::floor(value.get<double>()) == value.get<double>())
    return std::to_string(value.get<std::int64_t>());
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const auto& item : value) text += (text.empty() ? "" : ", ") + plain(item);
  return text;
}

// What a select offers. With nothing chosen the field says nothing, and a profile's value or the default holds.
ordered_json choices(const std::vector<std::string>& values, const std::string& chosen,
                     const std::string& nothing) {
  ordered_json list = ordered_json::array();
  for (const auto& value : values) list.push_back({{"value", value}, {"chosen", value == chosen}});
  return {{"nothing", nothing}, {"choices", std::move(list)}};
}

// What a refused form had in a field.
std::string filled_in(const std::map<std::string, std::string>& fields, const std::string& name) {
  const auto found = fields.find(name);
  return found == fields.end() ? std::string() : found->second;
}

// One setting: a label, the control that its schema asks for, and its description.
ordered_json field_values(const std::string& name, const std::string& key, const ordered_json& schema,
                          const std::map<std::string, std::string>& fields) {
  const std::string fallback = plain(schema.at("default")), type = schema.value("type", "");
  const std::string value = filled_in(fields, name);
  const ordered_json* innermost = schema.contains("oneOf") ? &schema["oneOf"][0] : &schema;
  while (innermost->contains("items")) innermost = &(*innermost)["items"];  // of rows of numbers
  const ordered_json& numeric = *innermost;
  std::string unit = numeric.value("x-unit", "");
  if (unit == "1") unit.clear();

  ordered_json select, input;
  if (schema.contains("enum")) {
    select = choices(schema["enum"].get<std::vector<std::string>>(), value, "(" + fallback + ")");
  } else if (type == "boolean") {
    select = choices({"true", "false"}, value, "(" + fallback + ")");
  } else {
    ordered_json range;  // null: a text
    if (type != "array" && type != "object")
      range = {{"step", type == "integer" ? "1" : "any"},
               {"least", plain(numeric.at("minimum"))},
               {"most", plain(numeric.at("maximum"))}};
    input = {{"default", fallback}, {"value", value}, {"range", std::move(range)}};
  }
  std::string hint = schema.value("description", "");
  if (numeric.contains("minimum"))
    hint += " (" + plain(numeric["minimum"]) + " to " + plain(numeric["maximum"]) + ")";
  return {{"name", name},     {"label", label_of(key)}, {"unit", unit},
          {"select", select}, {"input", input},         {"hint", hint}};
}

// ".svg,.png" -> "SVG, PNG".
std::string formats(std::string_view extensions) {
  std::string text;
  for (const char c : extensions)
    if (c == ',')
      text += ", ";
    else if (c != '.')
      text += static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  return text;
}

ordered_json files_values() {
  ordered_json files = ordered_json::array();
  for (const InputKind& kind : input_kinds)
    files.push_back({{"name", kind.name},
                     {"title", kind.title},
                     {"required", kind.always},
                     {"extensions", kind.extensions},
                     {"formats", formats(kind.extensions)},
                     {"size", readable_bytes(kind.most_bytes)}});
  return files;
}

ordered_json groups_values(const std::map<std::string, std::string>& fields) {
  const ordered_json schema = settings_schema();
  const ordered_json& groups = schema.at("properties");
  ordered_json list = ordered_json::array();
  const auto add = [&](const std::string& group) {
    const ordered_json& description = groups.at(group);
    const bool touched = std::any_of(fields.begin(), fields.end(), [&](const auto& field) {
      return field.first.starts_with(group + ".") && !field.second.empty();
    });
    ordered_json settings = ordered_json::array();
    for (const auto& [key, field] : description.at("properties").items())
      settings.push_back(field_values(group + "." + key, key, field, fields));
    list.push_back({{"title", description.value("title", group)},
                    {"open", group == "pattern" || touched},
                    {"fields", std::move(settings)}});
  };
  for (const auto group : group_order)
    if (groups.contains(std::string(group))) add(std::string(group));
  for (const auto& [group, description] : groups.items())  // groups that the order above does not know yet
    if (std::find(group_order.begin(), group_order.end(), group) == group_order.end()) add(group);
  return list;
}

ordered_json recent_values(const std::vector<Job>& recent) {
  if (recent.empty()) return nullptr;
  ordered_json jobs = ordered_json::array();
  for (const Job& job : recent) {
    const std::string time = rfc3339(job.created);
    const bool running = job.state == JobState::running;
    jobs.push_back({{"created", time},
                    {"shown", time.substr(0, 10) + " " + time.substr(11, 5) + " UTC"},
                    {"id", job.id},
                    {"reference", job.reference},
                    {"kind", job.kind == JobKind::print ? "" : name(job.kind)},
                    {"state", name(job.state)},
                    {"serious", serious_text(job)},
                    {"percent", running ? std::to_string(static_cast<int>(100 * whole_progress(job))) : ""}});
  }
  return {{"jobs", std::move(jobs)}};
}

ordered_json profile_values(const std::vector<Profile>& profiles,
                            const std::map<std::string, std::string>& fields) {
  if (profiles.empty()) return nullptr;
  std::vector<std::string> names;
  std::string chosen = filled_in(fields, "profile");
  for (const Profile& profile : profiles) {
    names.push_back(profile.name);
    if (fields.empty() && profile.is_default) chosen = profile.name;
  }
  return choices(names, chosen, "(none)");
}

}  // namespace

Page form_page(const std::vector<Job>& recent, const std::vector<Profile>& profiles,
               const std::optional<Error>& error, const std::map<std::string, std::string>& fields) {
  Page page;
  page.title = error ? "The job was not accepted" : "New job";
  page.signed_in = true;
  page.status = error ? meaning(error->code).http_status : 200;
  page.main = rendered("form", {{"title", page.title},
                                {"problem", problem_values(error)},
                                {"key", random_hex(16)},
                                {"files", files_values()},
                                {"reference", filled_in(fields, "reference")},
                                {"reference_hint", reference_hint},
                                {"longest_reference", std::to_string(longest_reference)},
                                {"rescan", filled_in(fields, "rescan") == "true"},
                                {"note", filled_in(fields, "note")},
                                {"note_hint", note_hint},
                                {"longest_note", std::to_string(longest_note)},
                                {"profile", profile_values(profiles, fields)},
                                {"groups", groups_values(fields)},
                                {"recent", recent_values(recent)}});
  return page;
}

}  // namespace vacuform
