#include "api/settings.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "api/base/strict_json.hpp"
#include "api/job_limits.hpp"
#include "api/settings_fields.hpp"

namespace vacuform {

using nlohmann::json;

namespace {

// 300, not 300.0.
std::string number(double value) {
  return value == std::floor(value) ? std::to_string(static_cast<long long>(value)) : json(value).dump();
}

struct Parser {
  const json& object;
  std::optional<Error> error;
  std::string group_name;
  const json* group_object = nullptr;
  std::vector<std::string> groups, keys;  // known so far, keys of the current group

  void refuse(const std::string& where, std::string what, std::string fix) {
    if (!error) error = Error{Code::bad_settings, std::move(what), where, std::move(fix)};
  }
  void refuse_unknown() {
    if (!group_object) return;
    for (const auto& [key, value] : group_object->items())
      if (std::find(keys.begin(), keys.end(), key) == keys.end())
        refuse(group_name + "." + key, "unknown setting", "the settings of this group are " + list(keys));
  }
  static std::string list(const std::vector<std::string>& words) {
    std::string text;
    for (const auto& word : words) text += (text.empty() ? "" : ", ") + word;
    return text;
  }

  void group(std::string_view name, std::string_view) {
    refuse_unknown();
    keys.clear();
    group_name = name;
    groups.emplace_back(name);
    const auto it = object.find(group_name);
    group_object = it == object.end() ? nullptr : &*it;
    if (group_object && !group_object->is_object()) {
      refuse(group_name, "a group of settings must be a JSON object",
             "write {\"" + group_name + "\": {...}}");
      group_object = nullptr;
    }
  }
  void finish() {
    refuse_unknown();
    for (const auto& [key, value] : object.items())
      if (std::find(groups.begin(), groups.end(), key) == groups.end())
        refuse(key, "unknown group of settings", "the groups are " + list(groups));
  }

  // The JSON of a field, or nullptr when it is absent.
  const json* take(std::string_view key) {
    keys.emplace_back(key);
    if (!group_object) return nullptr;
    const auto it = group_object->find(key);
    return it == group_object->end() ? nullptr : &*it;
  }
  std::string dotted(std::string_view key) const { return group_name + "." + std::string(key); }

  bool in_range(std::string_view key, const json& value, Range range) {
    const std::string bounds = "give a number from " + number(range.low) + " to " + number(range.high) +
                               (range.unit == "1" ? "" : " " + std::string(range.unit));
    if (!value.is_number()) return refuse(dotted(key), "not a number: " + value.dump(), bounds), false;
    const double x = value.get<double>();
    if (!std::isfinite(x) || x < range.low || x > range.high)
      return refuse(dotted(key), "out of range: " + value.dump(), bounds), false;
    return true;
  }

  template <class E>
  requires std::is_enum_v<E>
  void field(std::string_view key, E& value, std::string_view) {
    const json* j = take(key);
    if (!j) return;
    const auto names = names_of(E{});
    const auto it = j->is_string() ? std::find(names.begin(), names.end(), j->get_ref<const std::string&>())
                                   : names.end();
    if (it == names.end())
      return refuse(dotted(key), "no such choice: " + j->dump(),
                    "choose one of " + list(std::vector<std::string>(names.begin(), names.end())));
    value = static_cast<E>(it - names.begin());
  }
  void field(std::string_view key, bool& value, std::string_view) {
    const json* j = take(key);
    if (!j) return;
    if (!j->is_boolean()) return refuse(dotted(key), "not true or false: " + j->dump(), "give true or false");
    value = j->get<bool>();
  }
  void field(std::string_view key, double& value, Range range, std::string_view) {
    const json* j = take(key);
    if (j && in_range(key, *j, range)) value = j->get<double>();
  }
  void field(std::string_view key, int& value, Range range, std::string_view) {
    const json* j = take(key);
    if (!j || !in_range(key, *j, range)) return;
    if (j->get<double>() != std::floor(j->get<double>()))
      return refuse(dotted(key), "not a whole number: " + j->dump(), "give a whole number");
    value = static_cast<int>(j->get<double>());
  }
  void field(std::string_view key, std::optional<double>& value, Range range, std::string_view) {
    const json* j = take(key);
    if (!j) return;
    if (j->is_string() && *j == "auto")
      value.reset();
    else if (j->is_string())
      refuse(dotted(key), "neither a number nor auto: " + j->dump(), "give a number or \"auto\"");
    else if (in_range(key, *j, range))
      value = j->get<double>();
  }
  // A name that people give: short, and fit for a message.
  static bool short_name(const std::string& text) {
    return text.size() <= 32 && std::all_of(text.begin(), text.end(), [](char c) {
             return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
                    c == '_';
           });
  }
  void field(std::string_view key, std::string& value, std::string_view) {
    const json* j = take(key);
    if (!j) return;
    if (!j->is_string() || !short_name(j->get_ref<const std::string&>()))
      return refuse(dotted(key), "not a short name", "give at most 32 letters, digits, - and _");
    value = j->get<std::string>();
  }
  void field(std::string_view key, std::vector<Heater>& value, std::string_view) {
    const json* j = take(key);
    if (!j) return;
    if (!j->is_array() || j->size() > 400)
      return refuse(dotted(key), "not a list of at most 400 heaters", "write [{...}, {...}]");
    for (std::size_t i = 0; i < j->size(); ++i) {
      Parser item{object, {}, dotted(key) + "[" + std::to_string(i) + "]", &(*j)[i], {}, {}};
      if (!(*j)[i].is_object()) return refuse(item.group_name, "not a JSON object", "write {...}");
      describe_heater(value.emplace_back(), item);
      item.refuse_unknown();
      if (item.error) return refuse(item.error->where, item.error->what, item.error->fix);
    }
  }
  void field(std::string_view key, std::map<std::string, double>& value, Range range, std::string_view) {
    const json* j = take(key);
    if (!j) return;
    if (!j->is_object() || j->size() > 400)
      return refuse(dotted(key), "not an object of at most 400 numbers by name", "write {\"rim\": 1.2}");
    for (const auto& [name, number_of] : j->items()) {
      if (!short_name(name))
        return refuse(dotted(key), "not a short name", "give at most 32 letters, digits, - and _");
      if (in_range(std::string(key) + "." + name, number_of, range)) value[name] = number_of.get<double>();
    }
  }
  void field(std::string_view key, std::array<double, 2>& value, Range range, std::string_view) {
    const json* j = take(key);
    if (!j) return;
    if (!j->is_array() || j->size() != 2)
      return refuse(dotted(key), "not a pair of numbers: " + j->dump(), "give [u, v]");
    if (in_range(key, (*j)[0], range) && in_range(key, (*j)[1], range))
      value = {(*j)[0].get<double>(), (*j)[1].get<double>()};
  }
  template <std::size_t N>
  void field(std::string_view key, std::vector<std::array<double, N>>& value, Range range, std::string_view) {
    const json* j = take(key);
    if (!j) return;
    if (!j->is_array() || j->size() > 100)
      return refuse(dotted(key), "not a list of at most 100 rows", "write [[...], [...]]");
    for (const json& row : *j) {
      if (!row.is_array() || row.size() != N)
        return refuse(dotted(key), "not a row of " + std::to_string(N) + " numbers: " + row.dump(),
                      "give " + std::to_string(N) + " numbers in each row");
      auto& numbers = value.emplace_back();
      for (std::size_t i = 0; i < N; ++i)
        if (in_range(key, row[i], range)) numbers[i] = row[i].get<double>();
    }
  }
};

// What the heaters and the source of heat must agree on.
Result<void> check_heat(const Settings& s) {
  const auto& heaters = s.machine.heaters;
  const auto place = [](std::size_t i) { return "machine.heaters[" + std::to_string(i) + "]"; };
  for (std::size_t i = 0; i < heaters.size(); ++i) {
    const Heater& a = heaters[i];
    if (a.celsius.has_value() == a.power_w.has_value())
      return fail(Code::bad_settings, "a heater needs either a temperature or a power", place(i),
                  "give one of celsius and power_w");
    if (std::abs(a.z_mm) < 5)
      return fail(Code::bad_settings, "a heater is closer to the sheet than 5 mm", place(i),
                  "give z_mm, its distance above the sheet, negative below it");
    for (std::size_t k = 0; k < i; ++k) {
      const Heater& b = heaters[k];
      constexpr double touching = 1e-6;
      if ((a.z_mm > 0) == (b.z_mm > 0) &&
          2 * std::abs(a.x_mm - b.x_mm) < a.width_mm + b.width_mm - touching &&
          2 * std::abs(a.y_mm - b.y_mm) < a.height_mm + b.height_mm - touching)
        return fail(Code::bad_settings,
                    "two heaters on one side of the sheet overlap: " + place(k) + " and it", place(i),
                    "move one of them or make it smaller");
    }
  }
  for (const auto& [zone, gain] : s.heat.gains)
    if (std::none_of(heaters.begin(), heaters.end(),
                     [&zone = zone](const Heater& h) { return h.zone == zone; }))
      return fail(Code::bad_settings, "no heater is in this zone", "heat.gains." + zone,
                  "give it to a heater as its zone, or leave it out");
  if (s.heat.source == HeatSource::heaters && heaters.empty())
    return fail(Code::bad_settings, "there are no heaters to compute the temperature from", "machine.heaters",
                "describe the machine's heaters, or choose another heat.source");
  if (s.heat.black_c.has_value() != s.heat.white_c.has_value() ||
      (s.heat.black_c && *s.heat.black_c == *s.heat.white_c))
    return fail(Code::bad_settings, "black and white of a measured picture need a temperature each",
                "heat.black_c", "give heat.black_c and heat.white_c, which differ");
  return {};
}

// The colours of a scan lie where the scan has them: there is no drawing to lay, to weigh or to decouple.
Result<void> check_source(const Settings& s) {
  if (s.pattern.source != PatternSource::scan) return {};
  const auto refuse = [](const char* key, const char* fix) {
    return fail(Code::bad_settings, "the setting is for a drawing, and pattern.source=scan has none", key,
                fix);
  };
  if (s.pattern.placement != PatternPlacement::automatic && s.pattern.placement != PatternPlacement::chart)
    return refuse("pattern.placement", "leave it out");
  if (!s.pattern.points.empty()) return refuse("pattern.points", "leave it out");
  if (s.coils.decouple) return refuse("coils.decouple", "leave it out");
  if (s.flattening.weights == FlatteningWeights::ink || s.flattening.weights == FlatteningWeights::painted)
    return refuse("flattening.weights", "give uniform or center");
  return {};
}

Result<void> check_gaps(const CoilSettings& coils) {
  if (coils.gap_rule == GapRule::count || coils.gaps == 0) return {};
  return fail(Code::bad_settings,
              "coils.gap_rule=frequency chooses the number of gaps, and coils.gaps gives one", "coils.gaps",
              "leave one of them out");
}

// From nothing to full coverage, and never less ink for more coverage.
Result<void> check_ink_curve(const InkCurveRows& rows) {
  if (rows.empty()) return {};
  const auto refuse = [](std::string what, const char* fix) {
    return fail(Code::bad_settings, std::move(what), "print.ink_curve", fix);
  };
  const char* example = "give rows such as [[0, 0, 0, 0], [0.5, 0.6, 0.6, 0.55], [1, 1, 1, 1]]";
  if (rows.size() < 2 || rows.front() != std::array<double, 4>{0, 0, 0, 0} || rows.back()[0] != 1)
    return refuse("the curve of the ink does not go from [0, 0, 0, 0] to a row with printed 1", example);
  for (std::size_t i = 1; i < rows.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k)
      if (k == 0 ? rows[i][k] <= rows[i - 1][k] : rows[i][k] < rows[i - 1][k])
        return refuse("row " + std::to_string(i + 1) + " of the curve of the ink falls behind the one before",
                      "sort the rows by what is printed, and give no less ink for more coverage");
  for (std::size_t k = 1; k < 4; ++k)
    if (rows.back()[k] < 0.05)
      return refuse("full coverage gives hardly any ink", "give at least 0.05 in the last row");
  return {};
}

constexpr double coarsest_fast_mm = 3;  // then the coarsest grid is one of 12 mm

// What no single field can know.
Result<void> check_together(const Settings& s) {
  if (s.scan.size_mm && s.scan.units != Unit::automatic)
    return fail(Code::bad_settings, "scan.units and scan.size_mm both say how large the scan is",
                "scan.size_mm", "give one of them");
  if (s.scan.front != FrontSide::automatic && std::abs(s.scan.yaw_deg) > 45)
    return fail(Code::bad_settings, "the yaw turns the face, which scan.front brings to +y, away from there",
                "scan.yaw_deg", "give -45 to 45 degrees, and another scan.front for quarter turns");
  const auto& m = s.machine;
  const double height = m.window == WindowShape::circle ? m.window_width_mm : m.window_height_mm;
  if (m.window_width_mm > s.sheet.width_mm || height > s.sheet.height_mm)
    return fail(Code::bad_settings, "the window of the clamp frame is larger than the sheet",
                "machine.window_width_mm",
                "give a window of at most " + number(s.sheet.width_mm) + " x " + number(s.sheet.height_mm) +
                    " mm, or a larger sheet");
  VACUFORM_CHECK(check_heat(s));
  if (s.layout.diameter_mm > 0 && s.layout.diameter_mm < 10)
    return fail(Code::bad_settings, "the coils would be smaller than 10 mm", "layout.diameter_mm",
                "give 10 to 300 mm, or 0 to fit them to the region");
  if (s.layout.overlap > 0 && s.layout.overlap < 0.5)
    return fail(Code::bad_settings, "the centres would be closer than half a diameter", "layout.overlap",
                "give 0.5 to 1.5, or 0 to decouple neighbours");
  if (s.flattening.weights == FlatteningWeights::ink && !s.pattern.points.empty())
    return fail(Code::bad_settings, "where the ink lies is known by pattern.offset_mm, not by pattern.points",
                "flattening.weights",
                "lay the drawing by pattern.offset_mm and rotate_deg, or choose other weights");
  VACUFORM_CHECK(check_source(s));
  VACUFORM_CHECK(check_gaps(s.coils));
  VACUFORM_CHECK(check_ink_curve(s.print.ink_curve));
  if (s.forming.quality == FormingQuality::fast && s.forming.model != FormingModel::membrane)
    return fail(Code::bad_settings, "only the membrane model can be extrapolated from coarser grids",
                "forming.quality", "give standard, or forming.model=membrane");
  if (s.forming.quality == FormingQuality::fast && s.sheet.resolution_mm > coarsest_fast_mm)
    return fail(Code::bad_settings, "a coarse grid cannot be extrapolated from still coarser ones",
                "forming.quality",
                "give standard, or a sheet.resolution_mm of at most " + number(coarsest_fast_mm));
  const double spacing = grid_spacing_mm(s);
  const double cells = (s.sheet.width_mm / spacing) * (s.sheet.height_mm / spacing);
  if (cells > static_cast<double>(job_limits.sheet_cells))
    return fail(Code::bad_settings, "the grid of the sheet would have more than 640,000 cells",
                "sheet.resolution_mm", "give a coarser resolution");
  return {};
}

}  // namespace

std::string_view name(Unit value) { return name_of(value); }
std::string_view name(BodyChoice value) { return name_of(value); }
std::string_view name(UpAxis value) { return name_of(value); }
std::string_view name(FrontSide value) { return name_of(value); }
std::string_view name(LeftSide value) { return name_of(value); }
std::string_view name(Material value) { return name_of(value); }
std::string_view name(CoilKeep value) { return name_of(value); }
std::string_view name(InkedFace value) { return name_of(value); }
std::string_view name(HeatSource value) { return name_of(value); }
std::string_view name(FormingModel value) { return name_of(value); }
std::string_view name(MembraneLaw value) { return name_of(value); }
std::string_view name(FormingQuality value) { return name_of(value); }

Result<Settings> settings_from_json(const json& object) {
  if (!object.is_object())
    return fail(Code::bad_settings, "settings must be a JSON object", "",
                "write {\"print\": {\"dpi\": 300}}");
  Settings settings;
  Parser parser{object, {}, {}, nullptr, {}, {}};
  describe(settings, parser);
  parser.finish();
  if (parser.error) return tl::make_unexpected(*parser.error);
  VACUFORM_CHECK(check_together(settings));
  return settings;
}

Result<void> check_for(JobKind kind, const Settings& settings) {
  if (kind == JobKind::layout) {
    const FlatteningWeights weights = settings.flattening.weights;
    if (weights != FlatteningWeights::ink && weights != FlatteningWeights::painted) return {};
    return fail(Code::bad_settings, "a layout has no drawing that could weigh the flattening",
                "flattening.weights", "give uniform or center");
  }
  const auto given = to_json(settings)["layout"], defaults = to_json(Settings{})["layout"];
  for (const auto& [key, value] : given.items())
    if (value != defaults[key])
      return fail(Code::bad_settings, "the setting is for layouts, and this job is not one", "layout." + key,
                  "leave it out, or make a layout: send kind=layout, or run vacuform layout");
  return {};
}

Result<json> settings_json(std::string_view text) {
  auto object = strict_json<json>(text);
  if (!object)
    return fail(Code::bad_settings, object.error().what, "settings", "write {\"print\": {\"dpi\": 300}}");
  return object;
}

Result<Settings> settings_from_text(std::string_view text) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) return Settings{};
  VACUFORM_TRY(object, settings_json(text));
  return settings_from_json(object);
}

Result<void> set_in_json(json& object, std::string_view assignment) {
  const auto equals = assignment.find('=');
  const auto dot = assignment.find('.');
  if (equals == std::string_view::npos || dot == std::string_view::npos || dot == 0 || dot + 1 >= equals)
    return fail(Code::bad_usage, "not of the form group.key=value: " + std::string(assignment), "--set",
                "write for example --set print.dpi=600");
  if (!object.is_object()) object = json::object();
  const std::string group(assignment.substr(0, dot)), key(assignment.substr(dot + 1, equals - dot - 1));
  const std::string_view text = assignment.substr(equals + 1);
  json value = std::string(text);
  if (json::accept(text)) {
    VACUFORM_TRY(parsed, strict_json<json>(text));
    value = std::move(parsed);
  }
  if (!object[group].is_object()) object[group] = json::object();
  object[group][key] = std::move(value);
  return {};
}

}  // namespace vacuform
