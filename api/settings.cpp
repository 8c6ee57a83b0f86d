#include "api/settings.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

namespace vacuform {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

// The names of each enumeration's values, in the order of the values.
constexpr std::array<std::string_view, 5> unit_names{"auto", "mm", "cm", "m", "in"};
constexpr std::array<std::string_view, 7> up_names{"auto", "+x", "-x", "+y", "-y", "+z", "-z"};
constexpr std::array<std::string_view, 5> material_names{"petg", "pc", "abs", "hips", "pvc"};
constexpr std::array<std::string_view, 2> window_names{"rectangle", "circle"};
constexpr std::array<std::string_view, 3> source_names{"uniform", "heaters", "measured"};
constexpr std::array<std::string_view, 4> model_names{"membrane", "viscoplastic", "mass_spring",
                                                      "projection"};
constexpr std::array<std::string_view, 2> law_names{"neo_hookean", "mooney_rivlin"};
constexpr std::array<std::string_view, 2> integrator_names{"implicit_euler", "verlet"};
constexpr std::array<std::string_view, 5> method_names{"arap", "symmetric_dirichlet", "lscm", "cgal_arap",
                                                       "bfs"};
constexpr std::array<std::string_view, 3> weights_names{"uniform", "ink", "center"};
constexpr std::array<std::string_view, 3> placement_names{"auto", "elements", "chart"};
constexpr std::array<std::string_view, 2> face_names{"outer", "inner"};

std::span<const std::string_view> names_of(Unit) { return unit_names; }
std::span<const std::string_view> names_of(UpAxis) { return up_names; }
std::span<const std::string_view> names_of(Material) { return material_names; }
std::span<const std::string_view> names_of(WindowShape) { return window_names; }
std::span<const std::string_view> names_of(HeatSource) { return source_names; }
std::span<const std::string_view> names_of(FormingModel) { return model_names; }
std::span<const std::string_view> names_of(MembraneLaw) { return law_names; }
std::span<const std::string_view> names_of(Integrator) { return integrator_names; }
std::span<const std::string_view> names_of(FlatteningMethod) { return method_names; }
std::span<const std::string_view> names_of(FlatteningWeights) { return weights_names; }
std::span<const std::string_view> names_of(PatternPlacement) { return placement_names; }
std::span<const std::string_view> names_of(InkedFace) { return face_names; }

template <class E>
std::string_view name_of(E value) {
  return names_of(value)[static_cast<std::size_t>(value)];
}

struct Range {
  double low, high;
  std::string_view unit;
};

template <class S, class V>
void describe_heater(S& h, V& v) {
  v.field("x_mm", h.x_mm, {-2000, 2000, "mm"}, "Centre of the heater along x, from the sheet's centre");
  v.field("y_mm", h.y_mm, {-2000, 2000, "mm"}, "Centre of the heater along y, from the sheet's centre");
  v.field("z_mm", h.z_mm, {-2000, 2000, "mm"}, "Distance above the sheet; negative below it");
  v.field("width_mm", h.width_mm, {1, 4000, "mm"}, "Width of the heater, along x");
  v.field("height_mm", h.height_mm, {1, 4000, "mm"}, "Height of the heater, along y");
  v.field("celsius", h.celsius, {0, 1500, "C"}, "Temperature of its face; auto where the power is given");
  v.field("power_w", h.power_w, {0, 50000, "W"}, "Radiated power; auto where the temperature is given");
  v.field("emissivity", h.emissivity, {0.05, 1, "1"}, "Emissivity of its face");
  v.field("zone", h.zone, "Name of the zone that heat.gains turns up or down");
}

// The one description of all settings. A visitor has group(name, title) and, per kind of field,
// field(key, value&, text) for choices, switches, short names and the list of heaters, and
// field(key, value&, Range, text) for numbers and for numbers by name.
template <class S, class V>
void describe(S& s, V& v) {
  v.group("scan", "Scan: how the file becomes a mold");
  v.field("units", s.scan.units,
          "Unit of the scan's coordinates; auto guesses only when one unit makes a plausible size");
  v.field("size_mm", s.scan.size_mm, {10, 2000, "mm"},
          "Longest side of the whole scan, for models without a unit; auto goes by the unit");
  v.field("up", s.scan.up, "The axis of the scan that points to the ceiling of the machine");
  v.field("roll_deg", s.scan.roll_deg, {-180, 180, "deg"}, "Turn about the x axis, after up");
  v.field("pitch_deg", s.scan.pitch_deg, {-180, 180, "deg"}, "Turn about the y axis, after the roll");
  v.field("yaw_deg", s.scan.yaw_deg, {-180, 180, "deg"}, "Turn about the vertical axis, after the pitch");
  v.field("trim_mm", s.scan.trim_mm, {0, 2000, "mm"},
          "Height above the scan's lowest point at which it is cut; auto cuts where undercuts begin");
  v.field("clearance_mm", s.scan.clearance_mm, {0, 30, "mm"},
          "Offset skin around the scan, for padding or hair");

  v.group("sheet", "Sheet: the plastic");
  v.field("width_mm", s.sheet.width_mm, {50, 2000, "mm"}, "Width of the sheet, along x");
  v.field("height_mm", s.sheet.height_mm, {50, 2000, "mm"}, "Height of the sheet, along y");
  v.field("thickness_mm", s.sheet.thickness_mm, {0.05, 10, "mm"}, "Thickness before forming");
  v.field("material", s.sheet.material, "Plastic");
  v.field("resolution_mm", s.sheet.resolution_mm, {0.5, 20, "mm"}, "Grid spacing of the simulation");

  v.group("machine", "Machine: clamp frame and vacuum");
  v.field("window", s.machine.window, "Shape of the opening of the clamp frame");
  v.field("window_width_mm", s.machine.window_width_mm, {40, 2000, "mm"},
          "Width of the opening, or a circle's diameter");
  v.field("window_height_mm", s.machine.window_height_mm, {40, 2000, "mm"},
          "Height of the opening; a circle ignores it");
  v.field("drape_height_mm", s.machine.drape_height_mm, {0, 500, "mm"},
          "Height above the platform at which the frame stops");
  v.field("vacuum_start_mm", s.machine.vacuum_start_mm, {0, 1000, "mm"},
          "Height of the frame at which the vacuum starts; auto waits until the frame stops");
  v.field("drape_speed_mm_s", s.machine.drape_speed_mm_s, {0.1, 1000, "mm/s"},
          "Speed of the frame's descent");
  v.field("vacuum_kpa", s.machine.vacuum_kpa, {1, 101, "kPa"},
          "Pressure difference at the end of the vacuum ramp");
  v.field("vacuum_seconds", s.machine.vacuum_seconds, {0.01, 600, "s"}, "Length of the vacuum ramp");
  v.field("plug_height_mm", s.machine.plug_height_mm, {0, 500, "mm"},
          "Height of a straight plug under the mold, of the mold's own outline");
  v.field("heaters", s.machine.heaters,
          "Flat radiant heaters, as a list such as [{\"x_mm\": 0, \"y_mm\": 0, \"z_mm\": 150, "
          "\"width_mm\": 200, \"height_mm\": 200, \"celsius\": 500}]");
  v.field("reflector_mm", s.machine.reflector_mm, {0, 2000, "mm"},
          "Height of mirror walls around the heaters, from their face towards the sheet; 0 for none");
  v.field("reflectance", s.machine.reflectance, {0, 1, "1"}, "Reflectance of those walls");
  v.field("lip_mm", s.machine.lip_mm, {0, 200, "mm"},
          "Height of the clamp frame's inner edge over each face of the sheet, which shades it");

  v.group("heat", "Heat: how warm the sheet is when it meets the mold");
  v.field("source", s.heat.source,
          "Uniform, computed from the machine's heaters, or measured and given as a file");
  v.field("temperature_c", s.heat.temperature_c, {20, 300, "C"},
          "Temperature of the sheet; auto is the middle of the plastic's forming window");
  v.field("seconds", s.heat.seconds, {0.1, 3600, "s"},
          "Time under the heaters; auto heats until the mean of the sheet is at its temperature");
  v.field("transfer_seconds", s.heat.transfer_seconds, {0, 120, "s"},
          "Time between heaters and mold, in which the sheet cools");
  v.field("ambient_c", s.heat.ambient_c, {-20, 200, "C"},
          "Temperature of air and surroundings, and of the sheet at first");
  v.field("convection_w_m2k", s.heat.convection_w_m2k, {0, 100, "W/m2K"},
          "Heat transfer between each face and the air; 5 to 10 in still air");
  v.field("gains", s.heat.gains, {0, 10, "1"},
          "Share of their power at which zones of heaters run, such as {\"rim\": 1.2}");
  v.field("black_c", s.heat.black_c, {-50, 500, "C"}, "Temperature that black means in a measured picture");
  v.field("white_c", s.heat.white_c, {-50, 500, "C"}, "Temperature that white means in a measured picture");

  v.group("forming", "Forming: the simulation");
  v.field("model", s.forming.model, "Model of the sheet");
  v.field("law", s.forming.law, "Law of the membrane");
  v.field("edge_stiffness", s.forming.edge_stiffness, {0.1, 10, "1"},
          "Stiffness of the sheet at the clamp frame against its centre, as calibrated");
  v.field("sag", s.forming.sag, "The hot sheet sags under its own weight");
  v.field("thin_limit", s.forming.thin_limit, {0, 1, "1"},
          "Share of its thickness below which a thin place is a warning");
  v.field("yield_kpa", s.forming.yield_kpa, {0, 1000, "kPa"},
          "Stress below which a viscoplastic sheet stays elastic");
  v.field("integrator", s.forming.integrator, "Time integration of the mass-spring model");
  v.field("time_step_ms", s.forming.time_step_ms, {0.001, 1000, "ms"},
          "Time step of the mass-spring model; auto suits the integrator");

  v.group("flattening", "Flattening: from the formed sheet back to the drawing");
  v.field("method", s.flattening.method, "Method of flattening");
  v.field("lambda", s.flattening.lambda, {0, 1e6, "1"},
          "0 keeps angles, the larger the more areas too; auto is as rigid as possible");
  v.field("weights", s.flattening.weights, "Where the chart shall be least distorted");
  v.field("weight", s.flattening.weight, {1, 1000, "1"}, "How much more that counts than the rest");
  v.field("pins", s.flattening.pins, {-2000, 2000, "mm"},
          "Points of the sheet held at points of the chart, as rows [s, t, u, v]");

  v.group("pattern", "Pattern: how the drawing lies on the head");
  v.field("width_mm", s.pattern.width_mm, {1, 2000, "mm"},
          "Physical width of the drawing; auto takes the file's own");
  v.field(
      "placement", s.pattern.placement,
      "Each coil in its own neighbourhood, or all on one chart; auto: elements where the drawing has groups");
  v.field("offset_mm", s.pattern.offset_mm, {-500, 500, "mm"},
          "The drawing's centre, from the top of the mold");
  v.field("rotate_deg", s.pattern.rotate_deg, {-360, 360, "deg"}, "Turn of the drawing, counter-clockwise");
  v.field("scale", s.pattern.scale, {0.01, 100, "1"},
          "Size of the drawing on the head against the drawing itself");
  v.field("points", s.pattern.points, {-2000, 2000, "mm"},
          "Points of the drawing and of the mold that shall meet, as rows [u, v, x, y, z]");
  v.field("inked_face", s.pattern.inked_face,
          "Face of the sheet that carries the ink; the inner face touches the mold");

  v.group("coils", "Coils: loops that must not couple");
  v.field("decouple", s.coils.decouple, "Move and resize loops until neighbours no longer couple");
  v.field("size_limit", s.coils.size_limit, {0, 0.5, "1"}, "Largest change of a loop's size by decoupling");
  v.field("stretch_limit", s.coils.stretch_limit, {0, 5, "1"}, "Stretch at which the ink of a trace fails");

  v.group("print", "Print: the file for the printer");
  v.field("dpi", s.print.dpi, {72, 1200, "1/in"}, "Resolution of print.png");
  v.field("marks", s.print.marks, "Registration marks, ruler, sheet edge and text");
  v.field("margin_mm", s.print.margin_mm, {0, 50, "mm"}, "Free of marks along the sheet's edge");
  v.field("compensate_ink", s.print.compensate_ink,
          "More ink where the sheet stretches more; pictures in shades of gray only");
}

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

  void refuse(const std::string& where, std::string what, std::string mend) {
    if (!error) error = Error{Code::bad_settings, std::move(what), where, std::move(mend)};
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
      if (item.error) return refuse(item.error->where, item.error->what, item.error->mend);
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

struct Writer {
  ordered_json out = ordered_json::object();
  ordered_json* current = nullptr;
  void group(std::string_view name, std::string_view) {
    current = &(out[std::string(name)] = ordered_json::object());
  }
  template <class E>
  requires std::is_enum_v<E>
  void field(std::string_view key, const E& value, std::string_view) {
    (*current)[std::string(key)] = std::string(name_of(value));
  }
  void field(std::string_view key, const bool& value, std::string_view) {
    (*current)[std::string(key)] = value;
  }
  void field(std::string_view key, const std::string& value, std::string_view) {
    (*current)[std::string(key)] = value;
  }
  void field(std::string_view key, const std::vector<Heater>& value, std::string_view);
  template <class T>
  void field(std::string_view key, const T& value, Range, std::string_view) {
    (*current)[std::string(key)] = value;
  }
  void field(std::string_view key, const std::optional<double>& value, Range, std::string_view) {
    auto& slot = (*current)[std::string(key)];
    if (value)
      slot = *value;
    else
      slot = "auto";
  }
};

void Writer::field(std::string_view key, const std::vector<Heater>& value, std::string_view) {
  ordered_json list = ordered_json::array();
  for (const Heater& heater : value) {
    Writer item;
    ordered_json fields = ordered_json::object();
    item.current = &fields;
    describe_heater(heater, item);
    list.push_back(std::move(fields));
  }
  (*current)[std::string(key)] = std::move(list);
}

struct SchemaWriter {
  ordered_json groups = ordered_json::object();
  ordered_json* current = nullptr;
  void group(std::string_view name, std::string_view title) {
    auto& g = groups[std::string(name)];
    g = {{"type", "object"},
         {"title", title},
         {"additionalProperties", false},
         {"properties", ordered_json::object()}};
    current = &g["properties"];
  }
  ordered_json& add(std::string_view key, std::string_view text) {
    return (*current)[std::string(key)] = {{"description", text}};
  }
  static void limit(ordered_json& f, Range range) {
    f["minimum"] = range.low;
    f["maximum"] = range.high;
    f["x-unit"] = range.unit;
  }
  template <class E>
  requires std::is_enum_v<E>
  void field(std::string_view key, const E& value, std::string_view text) {
    auto& f = add(key, text);
    f["type"] = "string";
    for (const auto n : names_of(E{})) f["enum"].push_back(n);
    f["default"] = name_of(value);
  }
  void field(std::string_view key, const bool& value, std::string_view text) {
    auto& f = add(key, text);
    f["type"] = "boolean";
    f["default"] = value;
  }
  void field(std::string_view key, const double& value, Range range, std::string_view text) {
    auto& f = add(key, text);
    f["type"] = "number";
    limit(f, range);
    f["default"] = value;
  }
  void field(std::string_view key, const int& value, Range range, std::string_view text) {
    auto& f = add(key, text);
    f["type"] = "integer";
    limit(f, range);
    f["default"] = value;
  }
  void field(std::string_view key, const std::optional<double>&, Range range, std::string_view text) {
    auto& f = add(key, text);
    ordered_json numeric = {{"type", "number"}};
    limit(numeric, range);
    f["oneOf"] = ordered_json::array({numeric, {{"const", "auto"}}});
    f["default"] = "auto";
  }
  void field(std::string_view key, const std::array<double, 2>& value, Range range, std::string_view text) {
    auto& f = add(key, text);
    ordered_json item = {{"type", "number"}};
    limit(item, range);
    f["type"] = "array";
    f["items"] = item;
    f["minItems"] = f["maxItems"] = 2;
    f["default"] = value;
  }
  template <std::size_t N>
  void field(std::string_view key, const std::vector<std::array<double, N>>&, Range range,
             std::string_view text) {
    ordered_json item = {{"type", "number"}};
    limit(item, range);
    auto& f = add(key, text);
    f["type"] = "array";
    f["items"] = {{"type", "array"}, {"items", std::move(item)}, {"minItems", N}, {"maxItems", N}};
    f["maxItems"] = 100;
    f["default"] = ordered_json::array();
  }
  void field(std::string_view key, const std::string& value, std::string_view text) {
    auto& f = add(key, text);
    f["type"] = "string";
    f["maxLength"] = 32;
    f["default"] = value;
  }
  void field(std::string_view key, const std::vector<Heater>&, std::string_view text) {
    SchemaWriter item;
    ordered_json properties = ordered_json::object();
    item.current = &properties;
    const Heater defaults;
    describe_heater(defaults, item);
    auto& f = add(key, text);
    f["type"] = "array";
    f["items"] = {{"type", "object"}, {"additionalProperties", false}, {"properties", std::move(properties)}};
    f["maxItems"] = 400;
    f["default"] = ordered_json::array();
  }
  void field(std::string_view key, const std::map<std::string, double>&, Range range, std::string_view text) {
    ordered_json item = {{"type", "number"}};
    limit(item, range);
    auto& f = add(key, text);
    f["type"] = "object";
    f["additionalProperties"] = item;
    f["default"] = ordered_json::object();
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
    if (std::none_of(heaters.begin(), heaters.end(), [&](const Heater& h) { return h.zone == zone; }))
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

// What no single field can know.
Result<void> check_together(const Settings& s) {
  if (s.scan.size_mm && s.scan.units != Unit::automatic)
    return fail(Code::bad_settings, "scan.units and scan.size_mm both say how large the scan is",
                "scan.size_mm", "give one of them");
  const auto& m = s.machine;
  const double height = m.window == WindowShape::circle ? m.window_width_mm : m.window_height_mm;
  if (m.window_width_mm > s.sheet.width_mm || height > s.sheet.height_mm)
    return fail(Code::bad_settings, "the window of the clamp frame is larger than the sheet",
                "machine.window_width_mm",
                "give a window of at most " + number(s.sheet.width_mm) + " x " + number(s.sheet.height_mm) +
                    " mm, or a larger sheet");
  VACUFORM_CHECK(check_heat(s));
  if (s.flattening.weights == FlatteningWeights::ink && !s.pattern.points.empty())
    return fail(Code::bad_settings, "where the ink lies is known by pattern.offset_mm, not by pattern.points",
                "flattening.weights",
                "lay the drawing by pattern.offset_mm and rotate_deg, or choose other weights");
  const double cells =
      (s.sheet.width_mm / s.sheet.resolution_mm) * (s.sheet.height_mm / s.sheet.resolution_mm);
  if (cells > 640000)
    return fail(Code::bad_settings, "the grid of the sheet would have more than 640,000 cells",
                "sheet.resolution_mm", "give a coarser resolution");
  return {};
}

}  // namespace

std::string_view name(Unit value) { return name_of(value); }
std::string_view name(UpAxis value) { return name_of(value); }
std::string_view name(Material value) { return name_of(value); }
std::string_view name(InkedFace value) { return name_of(value); }
std::string_view name(HeatSource value) { return name_of(value); }
std::string_view name(FormingModel value) { return name_of(value); }
std::string_view name(MembraneLaw value) { return name_of(value); }

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

Result<Settings> settings_from_text(std::string_view text) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) return Settings{};
  constexpr std::size_t deepest = 8;  // a parser that recurses must not be led down
  const auto shallow = [](int depth, json::parse_event_t, json&) {
    return static_cast<std::size_t>(depth) <= deepest;
  };
  const json object = json::parse(text, shallow, false);
  if (object.is_discarded())
    return fail(Code::bad_settings, "the settings are not valid JSON", "",
                "write {\"print\": {\"dpi\": 300}}");
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
  json value = json::parse(text, nullptr, false);
  if (value.is_discarded()) value = std::string(text);
  if (!object[group].is_object()) object[group] = json::object();
  object[group][key] = std::move(value);
  return {};
}

ordered_json to_json(const Settings& settings) {
  Writer writer;
  describe(settings, writer);
  return writer.out;
}

ordered_json settings_schema() {
  SchemaWriter writer;
  const Settings defaults;
  describe(defaults, writer);
  return {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
          {"title", "Settings of a Vacuform job"},
          {"type", "object"},
          {"additionalProperties", false},
          {"properties", writer.groups}};
}

}  // namespace vacuform
