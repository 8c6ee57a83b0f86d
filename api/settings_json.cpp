// Settings as JSON, and the schema of that JSON.
#include <nlohmann/json.hpp>

#include "api/settings.hpp"
#include "api/settings_fields.hpp"

namespace vacuform {

using nlohmann::ordered_json;

namespace {

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

}  // namespace

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
