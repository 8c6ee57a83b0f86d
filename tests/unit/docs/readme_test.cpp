// The table of settings in README.md says what the schema says.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "api/settings.hpp"

namespace vacuform {
namespace {

using nlohmann::ordered_json;

std::string plain(const ordered_json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

// "3.0" and "[0.0,0.0]" as people write them.
std::string number(const ordered_json& value) {
  if (value.is_array()) {
    std::string list;
    for (const auto& item : value) list.append(list.empty() ? "[" : ", ").append(number(item));
    return list.append("]");
  }
  std::string text = plain(value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text;
}

std::string values_of(const ordered_json& field) {
  std::string text;
  if (field.contains("enum")) {
    for (const auto& choice : field["enum"]) text.append(text.empty() ? "" : ", ").append(plain(choice));
    return text;
  }
  if (field.value("type", "") == "boolean") return "true, false";
  const auto& numeric = field.contains("oneOf")   ? field["oneOf"][0]
                        : field.contains("items") ? field["items"]
                                                  : field;
  text = field.contains("oneOf") ? "auto, or " : field.contains("items") ? "[u, v], each " : "";
  text.append(number(numeric["minimum"])).append(" to ").append(number(numeric["maximum"]));
  if (numeric["x-unit"] != "1") text.append(" ").append(plain(numeric["x-unit"]));
  return text;
}

std::string row(const std::string& group, const std::string& key, const ordered_json& field) {
  return "| `" + group + "." + key + "` | " + number(field["default"]) + " | " + values_of(field) + " | " +
         plain(field["description"]) + " |";
}

TEST(Readme, TableOfSettingsIsTheSchemas) {
  std::ifstream file(VACUFORM_README);
  ASSERT_TRUE(file) << VACUFORM_README;
  const auto groups = settings_schema()["properties"];
  int rows = 0;
  bool in_section = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## ")) in_section = line == "## Settings that matter";
    if (!in_section || !line.starts_with("| `")) continue;
    const auto dot = line.find('.'), end = line.find('`', 3);
    ASSERT_LT(dot, end) << line;
    const std::string group = line.substr(3, dot - 3);
    ASSERT_TRUE(groups.contains(group)) << line;
    const std::string key = line.substr(dot + 1, end - dot - 1);
    ASSERT_TRUE(groups[group]["properties"].contains(key)) << "no such setting: " << group << "." << key;
    EXPECT_EQ(line, row(group, key, groups[group]["properties"][key]));
    ++rows;
  }
  EXPECT_GE(rows, 10);
}

}  // namespace
}  // namespace vacuform
