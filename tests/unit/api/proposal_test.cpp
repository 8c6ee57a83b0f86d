// Proposals as text, as JSON, and back from untrusted JSON.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "api/base/error.hpp"

namespace vacuform {
namespace {

const std::vector<Proposal> two{{{{"machine.window_width_mm", 320.0}, {"sheet.width_mm", 340.5}}, ""},
                                {{{"scan.up", std::string_view("-z")}}, "keeps 47 % of its height"}};

TEST(Proposals, TextAndJsonSayTheSame) {
  EXPECT_EQ(
      advice_with("give more room", two, "turn it"),
      "give more room: --set machine.window_width_mm=320 --set sheet.width_mm=340.5 or --set scan.up=-z "
      "(keeps 47 % of its height); or turn it");
  EXPECT_EQ(proposals_json(two).dump(),
            R"([{"set":{"machine":{"window_width_mm":320},"sheet":{"width_mm":340.5}},"text":""},)"
            R"({"set":{"scan":{"up":"-z"}},"text":"keeps 47 % of its height"}])");
  EXPECT_EQ(advice_with("", {}, "turn it"), "turn it");
  EXPECT_EQ(advice_with("give more room", {}), "give more room");
}

TEST(Proposals, ARefusalIsWrittenFromThem) {
  const Result<int> refused = fail(Code::does_not_fit, "too wide", "mold", "give more room", two);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fix, advice_with("give more room", two));
  EXPECT_EQ(refused.error().proposals.size(), 2u);
}

TEST(Proposals, ComeBackFromJson) {
  const auto back = proposals_from(nlohmann::json(proposals_json(two)));
  ASSERT_TRUE(back);
  EXPECT_EQ(proposals_json(*back).dump(), proposals_json(two).dump());
  EXPECT_EQ(proposals_from(nullptr)->size(), 0u);
}

TEST(Proposals, AnythingElseIsRefused) {
  nlohmann::json many = nlohmann::json::array(), large;
  for (int i = 0; i < 17; ++i) many.push_back({{"set", {{"scan", {{"trim_mm", i}}}}}});
  for (int i = 0; i < 9; ++i) large["scan"]["key" + std::to_string(i)] = 1;
  for (const nlohmann::json& wrong :
       {nlohmann::json(7), nlohmann::json("text"), nlohmann::json::object(), nlohmann::json::array({1}),
        nlohmann::json::array({{{"text", "x"}}}),
        nlohmann::json::array({{{"set", nlohmann::json::object()}}}),
        nlohmann::json::array({{{"set", {{"scan", 3}}}}}),
        nlohmann::json::array({{{"set", {{"Scan", {{"a", 1}}}}}}}),
        nlohmann::json::array({{{"set", {{"scan", {{"<b>", 1}}}}}}}),
        nlohmann::json::array({{{"set", {{"scan", {{"up", true}}}}}}}),
        nlohmann::json::array({{{"set", {{"scan", {{"up", std::string(65, 'x')}}}}}}}),
        nlohmann::json::array({{{"set", {{"scan", {{"up", "+z"}}}}}, {"text", std::string(301, 'x')}}}), many,
        nlohmann::json::array({{{"set", large}}})})
    EXPECT_FALSE(proposals_from(wrong)) << wrong.dump();
}

}  // namespace
}  // namespace vacuform
