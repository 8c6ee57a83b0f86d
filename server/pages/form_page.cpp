#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/base/secrets.hpp"
#include "api/problem.hpp"
#include "api/settings.hpp"
#include "server/jobs/job_json.hpp"
#include "server/pages/pages.hpp"

namespace vacuform {

using nlohmann::ordered_json;

namespace {

// The groups as a user meets them: what changes from job to job first.
constexpr std::array<std::string_view, 9> group_order{"pattern", "coils", "scan",       "sheet",  "machine",
                                                      "heat",    "print", "flattening", "forming"};

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

// With nothing chosen the field says nothing, and a profile's value or the default holds.
std::string choices(const std::vector<std::string>& values, const std::string& chosen,
                    const std::string& nothing) {
  std::string html = "<option value=\"\">" + escaped(nothing) + "</option>";
  for (const auto& value : values)
    html += "<option" + std::string(value == chosen ? " selected" : "") + ">" + escaped(value) + "</option>";
  return html;
}

// One setting: a label, the control that its schema asks for, and its description.
std::string field_html(const std::string& name, const std::string& key, const ordered_json& schema,
                       const std::map<std::string, std::string>& fields) {
  const std::string id = "f-" + name, fallback = plain(schema.at("default"));
  const auto filled = fields.find(name);
  const std::string value = filled == fields.end() ? "" : filled->second;
  const ordered_json* innermost = schema.contains("oneOf") ? &schema["oneOf"][0] : &schema;
  while (innermost->contains("items")) innermost = &(*innermost)["items"];  // of rows of numbers
  const ordered_json& numeric = *innermost;
  std::string unit = numeric.value("x-unit", "");
  if (unit == "1") unit.clear();
  const std::string common = " id=\"" + escaped(id) + "\" name=\"" + escaped(name) +
                             "\" aria-describedby=\"" + escaped(id) + "-hint\"";

  std::string control;
  if (schema.contains("enum")) {
    control = "<select" + common + ">" +
              choices(schema["enum"].get<std::vector<std::string>>(), value, "(" + fallback + ")") +
              "</select>";
  } else if (schema.value("type", "") == "boolean") {
    control =
        "<select" + common + ">" + choices({"true", "false"}, value, "(" + fallback + ")") + "</select>";
  } else {
    const bool text = schema.value("type", "") == "array" || schema.value("type", "") == "object";
    control =
        "<input" + common + " placeholder=\"" + escaped(fallback) + "\" value=\"" + escaped(value) + "\"";
    if (text)
      control += " type=\"text\" inputmode=\"text\" autocomplete=\"off\"";
    else
      control += " type=\"number\" step=\"" +
                 std::string(schema.value("type", "") == "integer" ? "1" : "any") + "\" min=\"" +
                 plain(numeric.at("minimum")) + "\" max=\"" + plain(numeric.at("maximum")) + "\"";
    control += ">";
  }
  std::string hint = escaped(schema.value("description", ""));
  if (numeric.contains("minimum"))
    hint += " (" + plain(numeric["minimum"]) + " to " + plain(numeric["maximum"]) + ")";
  return "<div class=\"field\"><label for=\"" + escaped(id) + "\">" + escaped(label_of(key)) +
         (unit.empty() ? "" : " <span class=\"unit\">" + escaped(unit) + "</span>") + "</label>" + control +
         "<p class=\"hint\" id=\"" + escaped(id) + "-hint\">" + hint + "</p></div>\n";
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

std::string file_html(const InputKind& kind) {
  const std::string name(kind.name), id = "f-" + name;
  return "<div class=\"field\"><label for=\"" + id + "\">" + escaped(kind.title) +
         "</label><input type=\"file\"" + (kind.always ? " required" : "") + " id=\"" + id + "\" name=\"" +
         name + "\" accept=\"" + escaped(kind.extensions) + "\" aria-describedby=\"" + id +
         "-hint\"><p class=\"hint\" id=\"" + id + "-hint\">" + formats(kind.extensions) + "; at most " +
         readable_bytes(kind.most_bytes) + "</p></div>\n";
}

std::string files_html() {
  std::string html;
  for (const InputKind& kind : input_kinds) html += file_html(kind);
  return html;
}

std::string settings_html(const std::map<std::string, std::string>& fields) {
  const ordered_json schema = settings_schema();
  const ordered_json& groups = schema.at("properties");
  std::string html;
  const auto add = [&](const std::string& group) {
    const ordered_json& description = groups.at(group);
    const ordered_json& properties = description.at("properties");
    const bool touched = std::any_of(fields.begin(), fields.end(), [&](const auto& field) {
      return field.first.starts_with(group + ".") && !field.second.empty();
    });
    const bool open = group == "pattern" || touched;
    html += std::string("<details") + (open ? " open" : "") + ">\n<summary>" +
            escaped(description.value("title", group)) + "</summary>\n<fieldset>\n<legend>" +
            escaped(description.value("title", group)) + "</legend>\n";
    for (const auto& [key, field] : properties.items())
      html += field_html(group + "." + key, key, field, fields);
    html += "</fieldset>\n</details>\n";
  };
  for (const auto group : group_order)
    if (groups.contains(std::string(group))) add(std::string(group));
  for (const auto& [group, description] : groups.items())  // groups that the order above does not know yet
    if (std::find(group_order.begin(), group_order.end(), group) == group_order.end()) add(group);
  return html;
}

std::string recent_html(const std::vector<Job>& recent) {
  if (recent.empty()) return "<p>There are no jobs yet.</p>\n";
  std::string html =
      "<div class=\"wide\"><table>\n<thead><tr><th scope=\"col\">Created</th><th scope=\"col\">Job</th><th "
      "scope=\"col\">State</th></tr>"
      "</thead>\n<tbody>\n";
  for (const Job& job : recent) {
    const std::string time = rfc3339(job.created),
                      shown = time.substr(0, 10) + " " + time.substr(11, 5) + " UTC";
    html += "<tr><td><time datetime=\"" + time + "\">" + shown + "</time></td><td><a href=\"/jobs/" +
            escaped(job.id) + "\"><code>" + escaped(job.id) + "</code></a>" +
            (job.kind == JobKind::inspection ? ", inspection" : "") + "</td><td><span class=\"state " +
            std::string(name(job.state)) + "\">" + std::string(name(job.state)) + "</span>" +
            serious_html(job);
    if (job.state == JobState::running)
      html += " " + std::to_string(static_cast<int>(100 * whole_progress(job))) + " %";
    html += "</td></tr>\n";
  }
  return html + "</tbody>\n</table></div>\n";
}

std::string profiles_html(const std::vector<Profile>& profiles,
                          const std::map<std::string, std::string>& fields) {
  if (profiles.empty()) return "";
  std::vector<std::string> names;
  for (const Profile& profile : profiles) names.push_back(profile.name);
  const auto chosen = fields.find("profile");
  return "<div class=\"field\"><label for=\"f-profile\">Profile</label><select id=\"f-profile\" "
         "name=\"profile\" "
         "aria-describedby=\"f-profile-hint\">" +
         choices(names, chosen == fields.end() ? "" : chosen->second, "(none)") +
         "</select><p class=\"hint\" id=\"f-profile-hint\">A machine or a sheet, whose settings stand in for "
         "the "
         "defaults below</p></div>\n";
}

}  // namespace

Page form_page(const std::vector<Job>& recent, const std::vector<Profile>& profiles,
               const std::optional<Error>& error, const std::map<std::string, std::string>& fields) {
  Page page;
  page.title = error ? "The job was not accepted" : "New job";
  page.signed_in = true;
  page.status = error ? meaning(error->code).http_status : 200;
  page.main = "<h1>" + page.title + "</h1>\n";
  if (error)
    page.main += problem_box(*error) +
                 "<p>Nothing was started. Your settings are kept below; choose the files again.</p>\n";
  page.main +=
      "<form method=\"post\" action=\"/jobs\" enctype=\"multipart/form-data\">\n"
      "<input type=\"hidden\" name=\"idempotency_key\" value=\"" +
      random_hex(16) +
      "\">\n<fieldset class=\"files\">\n"
      "<legend>Files</legend>\n" +
      files_html() +
      "</fieldset>\n<h2>Settings</h2>\n<p>All have a default: an empty field keeps the value that it shows "
      "in grey "
      "or in brackets, unless a profile has another.</p>\n" +
      profiles_html(profiles, fields) + settings_html(fields) +
      "<p><button type=\"submit\">Start the job</button></p>\n"
      "<p><button type=\"submit\" name=\"kind\" value=\"inspection\" formnovalidate>Inspect the scan "
      "only</button> "
      "<span class=\"hint\">In seconds: what is in it, and what mold it makes</span></p>\n"
      "</form>\n<h2>Recent jobs</h2>\n" +
      recent_html(recent);
  return page;
}

}  // namespace vacuform
