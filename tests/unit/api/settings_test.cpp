#include "api/settings.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace vacuform {
namespace {

TEST(Settings, EmptyTextIsAllDefaults) {
  const auto settings = settings_from_text("  \n");
  ASSERT_TRUE(settings);
  EXPECT_EQ(to_json(*settings), to_json(Settings{}));
}

TEST(Settings, WrittenSettingsReadBackTheSame) {
  Settings s;
  s.scan.up = UpAxis::minus_y;
  s.scan.trim_mm = 42.5;
  s.machine.window = WindowShape::circle;
  s.pattern.offset_mm = {3, -4};
  s.pattern.inked_face = InkedFace::inner;
  s.coils.keep = CoilKeep::diameter;
  s.print.dpi = 1200;
  const auto text = to_json(s).dump();
  const auto back = settings_from_text(text);
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(to_json(*back).dump(), text);
}

TEST(Settings, HeatersAndGainsReadBackTheSame) {
  const auto settings = settings_from_text(
      R"({"machine": {"heaters": [{"x_mm": -75, "width_mm": 150, "celsius": 500, "zone": "left"},
                                  {"x_mm": 75, "width_mm": 150, "power_w": 800}]},
          "heat": {"source": "heaters", "gains": {"left": 0.8}, "seconds": 40}})");
  ASSERT_TRUE(settings) << settings.error().text();
  ASSERT_EQ(settings->machine.heaters.size(), 2u);
  EXPECT_EQ(settings->machine.heaters[0].celsius, 500);
  EXPECT_EQ(settings->machine.heaters[0].zone, "left");
  EXPECT_EQ(settings->machine.heaters[1].power_w, 800);
  EXPECT_FALSE(settings->machine.heaters[1].celsius);
  EXPECT_EQ(settings->heat.gains.at("left"), 0.8);
  const auto text = to_json(*settings).dump();
  const auto back = settings_from_text(text);
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(to_json(*back).dump(), text);
}

struct Refusal {
  const char* text;
  const char* where;
  const char* says;
};
class SettingsRefusal : public testing::TestWithParam<Refusal> {};

TEST_P(SettingsRefusal, NamesTheSetting) {
  const auto settings = settings_from_text(GetParam().text);
  ASSERT_FALSE(settings);
  EXPECT_EQ(settings.error().code, Code::bad_settings);
  EXPECT_EQ(settings.error().where, GetParam().where);
  EXPECT_NE(settings.error().text().find(GetParam().says), std::string::npos) << settings.error().text();
}

INSTANTIATE_TEST_SUITE_P(
    All, SettingsRefusal,
    testing::Values(
        Refusal{R"({"prnt": {}})", "prnt", "unknown group"},
        Refusal{R"({"print": {"dip": 300}})", "print.dip", "dpi, marks, margin_mm"},
        Refusal{R"({"print": {"dpi": 71}})", "print.dpi", "from 72 to 1200"},
        Refusal{R"({"print": {"dpi": 300.5}})", "print.dpi", "whole number"},
        Refusal{R"({"print": {"dpi": "300"}})", "print.dpi", "not a number"},
        Refusal{R"({"print": {"marks": 1}})", "print.marks", "true or false"},
        Refusal{R"({"print": 300})", "print", "JSON object"},
        Refusal{R"({"scan": {"trim_mm": "automatic"}})", "scan.trim_mm", "auto"},
        Refusal{R"({"scan": {"units": "furlong"}})", "scan.units", "auto, um, mm, cm, m, in, ft"},
        Refusal{R"({"coils": {"keep": "radius"}})", "coils.keep", "area, diameter"},
        Refusal{R"({"layout": {"count": 3}})", "layout.count", "from 4 to 64"},
        Refusal{R"({"layout": {"count": 65}})", "layout.count", "from 4 to 64"},
        Refusal{R"({"layout": {"diameter_mm": 9.9}})", "layout.diameter_mm", "10 to 300"},
        Refusal{R"({"layout": {"diameter_mm": 301}})", "layout.diameter_mm", "from 0 to 300"},
        Refusal{R"({"layout": {"overlap": 0.49}})", "layout.overlap", "0.5 to 1.5"},
        Refusal{R"({"layout": {"overlap": 1.51}})", "layout.overlap", "from 0 to 1.5"},
        Refusal{R"({"layout": {"region": "side"}})", "layout.region", "dome, front, back"},
        Refusal{R"({"pattern": {"offset_mm": [1]}})", "pattern.offset_mm", "[u, v]"},
        Refusal{R"({"pattern": {"offset_mm": [1, 1e9]}})", "pattern.offset_mm", "out of range"},
        Refusal{R"({"print": {"ink_curve": [[0, 0, 0], [1, 1, 1]]}})", "print.ink_curve", "4 numbers"},
        Refusal{R"({"print": {"ink_curve": [[0, 0, 0, 0], [1, 1, 1, 4.1]]}})", "print.ink_curve",
                "from 0 to 4"},
        Refusal{R"({"print": {"ink_curve": [[0, 0, 0, 0]]}})", "print.ink_curve", "printed 1"},
        Refusal{R"({"print": {"ink_curve": [[0, 0, 0.1, 0], [1, 1, 1, 1]]}})", "print.ink_curve",
                "[0, 0, 0, 0]"},
        Refusal{R"({"print": {"ink_curve": [[0, 0, 0, 0], [0.9, 1, 1, 1]]}})", "print.ink_curve",
                "printed 1"},
        Refusal{R"({"print": {"ink_curve": [[0, 0, 0, 0], [0.6, 0.9, 0.8, 0.7], [1, 0.8, 1, 1]]}})",
                "print.ink_curve", "row 3"},
        Refusal{R"({"print": {"ink_curve": [[0, 0, 0, 0], [0, 1, 1, 1], [1, 1, 1, 1]]}})", "print.ink_curve",
                "row 2"},
        Refusal{R"({"print": {"ink_curve": [[0, 0, 0, 0], [1, 1, 0, 1]]}})", "print.ink_curve", "hardly any"},
        Refusal{R"({"scan": {"units": "cm", "size_mm": 200}})", "scan.size_mm", "give one of them"},
        Refusal{R"({"machine": {"window_width_mm": 400}})", "machine.window_width_mm",
                "larger than the sheet"},
        Refusal{R"({"flattening": {"weights": "ink"}, "pattern": {"points": [[0, 0, 1, 2, 3]]}})",
                "flattening.weights", "offset_mm"},
        Refusal{R"({"pattern": {"points": [[0, 0, 1, 2]]}})", "pattern.points", "5 numbers"},
        Refusal{R"({"sheet": {"width_mm": 2000, "height_mm": 2000, "resolution_mm": 0.5}})",
                "sheet.resolution_mm", "coarser"},
        Refusal{R"({"sheet": {"resolution_mm": 0.6}, "forming": {"quality": "fine"}})", "sheet.resolution_mm",
                "coarser"},
        Refusal{R"({"forming": {"quality": "fast", "model": "viscoplastic"}})", "forming.quality",
                "membrane"},
        Refusal{R"({"forming": {"quality": "fast"}, "sheet": {"resolution_mm": 3.1}})", "forming.quality",
                "at most 3"},
        Refusal{R"({"forming": {"quality": "best"}})", "forming.quality", "fast, standard, fine"},
        Refusal{R"({"machine": {"heaters": 3}})", "machine.heaters", "a list"},
        Refusal{R"({"machine": {"heaters": [3]}})", "machine.heaters[0]", "JSON object"},
        Refusal{R"({"machine": {"heaters": [{"celsius": 1}, {"watt": 3}]}})", "machine.heaters[1].watt",
                "unknown setting"},
        Refusal{R"({"machine": {"heaters": [{"celsius": 9999}]}})", "machine.heaters[0].celsius",
                "out of range"},
        Refusal{R"({"machine": {"heaters": [{"celsius": 400, "zone": "a b"}]}})", "machine.heaters[0].zone",
                "short name"},
        Refusal{R"({"machine": {"heaters": [{}]}})", "machine.heaters[0]", "celsius and power_w"},
        Refusal{R"({"machine": {"heaters": [{"celsius": 400}, {"celsius": 400, "x_mm": 99}]}})",
                "machine.heaters[1]", "overlap"},
        Refusal{R"({"machine": {"heaters": [{"celsius": 400, "z_mm": 1}]}})", "machine.heaters[0]", "closer"},
        Refusal{R"({"heat": {"source": "heaters"}})", "machine.heaters", "no heaters"},
        Refusal{R"({"heat": {"gains": {"rim": 1}}})", "heat.gains.rim", "no heater"},
        Refusal{R"({"heat": {"gains": {"rim": -1}}})", "heat.gains.rim", "from 0 to 10"},
        Refusal{R"({"heat": {"black_c": 20}})", "heat.black_c", "a temperature each"},
        Refusal{"[1, 2]", "", "JSON object"}, Refusal{"{\"print\": {", "settings", "not valid JSON"},
        Refusal{"[[[[[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]]]]]", "settings", "nested"},
        Refusal{R"({"print": {"dpi": 1e999}})", "settings", "too large"},
        Refusal{R"({"print": {"dpi": 72}, "print": {}})", "settings", "twice"}));

TEST(Settings, RefuseThoseOfALayoutInOtherJobs) {
  for (const char* text : {R"({"layout": {"count": 9}})", R"({"layout": {"diameter_mm": 40}})",
                           R"({"layout": {"region": "back"}})", R"({"layout": {"overlap": 0.5}})"}) {
    const auto settings = settings_from_text(text);
    ASSERT_TRUE(settings) << settings.error().text();
    EXPECT_TRUE(check_for(JobKind::layout, *settings));
    for (const JobKind kind : {JobKind::print, JobKind::inspection}) {
      const auto checked = check_for(kind, *settings);
      ASSERT_FALSE(checked);
      EXPECT_EQ(checked.error().code, Code::bad_settings);
      const std::string key = nlohmann::json::parse(text)["layout"].begin().key();
      EXPECT_EQ(checked.error().where, "layout." + key);
    }
  }
  const auto defaults = settings_from_text(R"({"layout": {"count": 16, "overlap": 0}})");
  for (const JobKind kind : {JobKind::print, JobKind::inspection, JobKind::layout})
    EXPECT_TRUE(check_for(kind, *defaults));
}

TEST(Settings, ALayoutHasNoDrawingToWeighTheFlatteningBy) {
  for (const auto& [weights, accepted] : {std::pair{FlatteningWeights::uniform, true},
                                          {FlatteningWeights::center, true},
                                          {FlatteningWeights::ink, false},
                                          {FlatteningWeights::painted, false}}) {
    Settings settings;
    settings.flattening.weights = weights;
    const auto checked = check_for(JobKind::layout, settings);
    EXPECT_EQ(checked.has_value(), accepted);
    if (!checked) {
      EXPECT_EQ(checked.error().where, "flattening.weights");
    }
    EXPECT_TRUE(check_for(JobKind::print, settings));
  }
}

TEST(Settings, SetReadsJsonAndBareWords) {
  nlohmann::json object;
  for (const char* text :
       {"print.dpi=600", "sheet.material=pc", "scan.trim_mm=auto", "pattern.offset_mm=[1.5, -2]"})
    ASSERT_TRUE(set_in_json(object, text)) << text;
  const auto settings = settings_from_json(object);
  ASSERT_TRUE(settings) << settings.error().text();
  EXPECT_EQ(settings->print.dpi, 600);
  EXPECT_EQ(settings->sheet.material, Material::pc);
  EXPECT_FALSE(settings->scan.trim_mm);
  EXPECT_EQ(settings->pattern.offset_mm[1], -2);
  for (const char* text : {"dpi=600", "print.dpi", ".dpi=3", "print.=3", ""})
    EXPECT_FALSE(set_in_json(object, text)) << text;
}

TEST(Settings, SchemaDescribesEveryField) {
  const auto schema = settings_schema();
  const auto values = to_json(Settings{});
  for (const auto& [group, fields] : values.items())
    for (const auto& [key, value] : fields.items()) {
      const auto& field = schema["properties"][group]["properties"][key];
      EXPECT_TRUE(field.contains("description")) << group << "." << key;
      EXPECT_EQ(field["default"], value) << group << "." << key;
    }
}

}  // namespace
}  // namespace vacuform
