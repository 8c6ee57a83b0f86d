#include "server/pages/findings_html.hpp"

#include <nlohmann/json.hpp>

#include "server/pages/html.hpp"

namespace vacuform {

using nlohmann::json;

namespace {

std::string text(const json& value) {
  return value.is_string() ? value.get<std::string>() : std::string("-");
}

std::string size_text(const json& size) {
  if (!size.is_array() || size.size() != 3) return "-";
  return number(size[0], 1) + " x " + number(size[1], 1) + " x " + number(size[2], 1) + " mm";
}

bool is_true(const json& object, const char* key) { return at(object, {key}) == json(true); }

}  // namespace

std::string findings_html(const json& findings) {
  const json& scan = at(findings, {"scan"});
  if (!scan.is_object()) return "";
  std::string html = "<h2>The scan</h2>\n<dl>\n";
  const auto row = [&](const char* title, const std::string& value) {
    html += std::string("<dt>") + title + "</dt><dd>" + escaped(value) + "</dd>\n";
  };
  const auto count = [&](const char* key) { return number(at(scan, {key}), 0); };
  const auto guessed = [&](const char* key, const char* flag) {
    return text(at(scan, {key})) + (is_true(scan, flag) ? " (guessed)" : "");
  };
  row("Format", text(at(scan, {"format"})) + ", " + count("triangles_read") + " triangles");
  row("Unit",
      is_true(scan, "size_given") ? "none, scaled to the size given" : guessed("unit", "unit_guessed"));
  row("Up", guessed("up", "up_guessed"));
  row("Face", guessed("front", "front_assumed") + (is_true(scan, "mirrored") ? ", mirrored" : ""));
  row("Size, upright", size_text(at(scan, {"size_mm"})));
  row("Pieces", count("components") + ", " + count("components_dropped") + " dropped as debris or inside");
  row("Openings", count("holes_closed") + " closed, " + count("holes_capped") +
                      " walled in down to the platform" +
                      (is_true(scan, "rebuilt") ? ", the skin replaced by a new one" : ""));
  row("Left out", count("outliers_dropped") + " outliers, " + count("crumbs_dropped") +
                      " crumbs that the trim left beside the mold");
  row("Trim above its lowest point", number(at(scan, {"trim_mm"}), 1) + " mm");
  row("Mold", size_text(at(findings, {"mold", "size_mm"})));
  row("Undercuts", number(at(findings, {"mold", "undercut_count"}), 0));
  if (!at(findings, {"fits"}).is_boolean()) return html + "</dl>\n";  // a print: it did fit
  const json& misfit = at(findings, {"problem"});
  row("Fits the machine", is_true(findings, "fits")
                              ? "yes"
                              : "no: " + text(at(misfit, {"what"})) + "; " + text(at(misfit, {"mend"})));
  return html + "</dl>\n";
}

std::string print_form_html(const Job& job) {
  if (job.kind != JobKind::inspection || job.state != JobState::succeeded) return "";
  const InputKind& pattern = *input_kind("pattern");
  const bool waits = job.input("pattern");
  return "<h2>Make the print</h2>\n<form method=\"post\" action=\"/jobs\" "
         "enctype=\"multipart/form-data\">\n<input type=\"hidden\" name=\"from\" value=\"" +
         escaped(job.id) + "\"><div class=\"field\"><label for=\"f-pattern\">" + escaped(pattern.title) +
         "</label><input type=\"file\" id=\"f-pattern\" name=\"pattern\"" + (waits ? "" : " required") +
         " accept=\"" + escaped(pattern.extensions) +
         "\" aria-describedby=\"f-pattern-hint\"><p class=\"hint\" id=\"f-pattern-hint\">" +
         (waits ? "None chosen: the one that came with the scan"
                : "The scan and the settings are those of this job") +
         "</p></div>\n<p><button type=\"submit\">Make the print of this scan</button></p>\n</form>\n";
}

const json& at(const json& object, std::initializer_list<const char*> keys) {
  static const json nothing;
  const json* here = &object;
  for (const char* key : keys) {
    const auto it = here->is_object() ? here->find(key) : here->end();
    if (!here->is_object() || it == here->end()) return nothing;
    here = &*it;
  }
  return *here;
}

std::string number(const json& value, int places) {
  if (!value.is_number()) return "-";
  char text[400];
  std::snprintf(text, sizeof text, "%.*f", places, value.get<double>());
  return text;
}

}  // namespace vacuform
