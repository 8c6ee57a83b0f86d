#include "worker/inspection/report_html.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/unit/fixtures/drawing_files.hpp"
#include "worker/inspection/caption.hpp"
#include "worker/inspection/html.hpp"
#include "worker/inspection/report_sections.hpp"
#include "worker/inspection/summary.hpp"
#include "worker/png/png_writer.hpp"

namespace vacuform {
namespace {

using namespace drawing_files;

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

TEST(Html, EscapesWhatCouldBeMarkup) {
  EXPECT_EQ(escaped("<b a=\"x\" c='y'>&amp;"), "&lt;b a=&quot;x&quot; c=&#39;y&#39;&gt;&amp;amp;");
  EXPECT_EQ(escaped("°C × ≥ 𝄞"), "°C × ≥ 𝄞");
  EXPECT_EQ(escaped(std::string("a\0b\x01\x7f\nc", 7)), "a?b?? c");
  // No UTF-8: a lone continuation, an overlong one, a cut one, one beyond Unicode.
  EXPECT_EQ(escaped("\x80 \xc0\xaf \xe2\x82"), "? ?? ??");
  EXPECT_EQ(escaped("\xf5\x80\x80\x80"), "????");
}

TEST(Html, TablesHaveCaptionsAndHeadings) {
  const std::string table =
      html::table("Two <coils>", {{"Coil"}, {"k", true}}, {{"a&b", "0.1"}, {"group"}, {"c", "–"}});
  EXPECT_NE(table.find("<caption>Two &lt;coils&gt;</caption>"), std::string::npos);
  EXPECT_NE(table.find("<th scope=\"col\" class=\"number\">k</th>"), std::string::npos);
  EXPECT_NE(table.find("<tr><th scope=\"row\">a&amp;b</th><td class=\"number\">0.1</td></tr>"),
            std::string::npos);
  EXPECT_NE(table.find("colspan=\"2\""), std::string::npos);
  EXPECT_EQ(count(table, "<tr>"), 4u);
}

TEST(Html, ChartsShowEveryValueAndHaveAName) {
  const std::string chart =
      html::histogram({"Shape", "ratio", 1, 0.1, {0.5, 0.3, 0.2}, {0.1, 0.1, 0.8}, true});
  EXPECT_NE(chart.find("role=\"img\" aria-label=\"Shape\""), std::string::npos);
  EXPECT_EQ(count(chart, "<rect class=\"with\""), 3u);
  EXPECT_EQ(count(chart, "<path class=\"without\""), 1u);
  // The highest bar ends where the axis does: 0.8 of 80 %.
  EXPECT_NE(chart.find(">80<"), std::string::npos);
  const std::string bars = html::bars(
      {"Diameter", "per cent", true, {{"a", 1.0, -3.0}, {"b", std::nullopt, 2.0}, {"<c>", {}, {}}}});
  EXPECT_EQ(count(bars, "<rect class=\"with\""), 1u);
  EXPECT_EQ(count(bars, "<rect class=\"without\""), 2u);
  EXPECT_NE(bars.find("&lt;c&gt;"), std::string::npos);
  EXPECT_EQ(bars.find("nan"), std::string::npos);
}

TEST(ReportHtml, NumbersThatAreNotThereAreDashes) {
  EXPECT_EQ(number_text(nullptr, 2, "mm"), "–");
  EXPECT_EQ(number_text(1.005e-9, 2, "mm"), "0.00 mm");
  EXPECT_EQ(percent_text(0.01234), "1.23 %");
  EXPECT_EQ(signed_percent_text(0.5, 0), "+50 %");
  EXPECT_EQ(signed_percent_text(-0.5, 0), "-50 %");
  const ReportJson json{{"a", {{"b", 3}}}};
  EXPECT_EQ(at(json, {"a", "b"}), 3);
  EXPECT_TRUE(at(json, {"a", "c"}).is_null());
  EXPECT_TRUE(at(json, {"a", "b", "c"}).is_null());
}

// A report with nothing in it is still a page, and so is one with strange texts.
TEST(ReportHtml, LeavesOutWhatIsNotThere) {
  const std::string empty = report_html(ReportJson::object(), {});
  EXPECT_EQ(empty.find("<!DOCTYPE html>"), 0u);
  EXPECT_EQ(empty.find("<h2>Coils</h2>"), std::string::npos);
  EXPECT_EQ(empty.find("<img"), std::string::npos);
  ReportJson report;
  report["label"] = "<script>alert(1)</script>";
  report["warnings"] = {{{"stage", "scan"},
                         {"code", "a<b"},
                         {"severity", "<i>"},
                         {"what", "\"quoted\" & <i>"},
                         {"place", "<i>"},
                         {"fix", "<i>"},
                         {"marks", {{{"place_mm", {1.0, 2.0, 3.0}}, {"size_mm", 4.0}}}}}};
  report["coils"] = {{{"id", "</td><svg onload='x'>"},
                      {"drawn_diameter_mm", 40.0},
                      {"with", nullptr},
                      {"without", {{"on_head", true}, {"circularity", 0.12}, {"shape_error", 0.12}}}}};
  report["settings"] = {{"print", {{"dpi", 600}, {"unknown", "<u>"}}}, {"pattern", {{"scale", 1.0}}}};
  const std::string page = report_html(report, {});
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find("<i>"), std::string::npos);
  EXPECT_EQ(page.find("<svg onload"), std::string::npos);
  EXPECT_EQ(page.find("<u>"), std::string::npos);
  EXPECT_NE(page.find("1. (1.0, 2.0, 3.0) 4.0"), std::string::npos);
  EXPECT_NE(page.find("12.0 %"), std::string::npos);
  // What differs from the defaults comes before what does not.
  EXPECT_LT(page.find("print.dpi"), page.find("pattern.scale"));
  EXPECT_NE(page.find("<td>600</td><td>300</td><td>1/in</td>"), std::string::npos);
  EXPECT_EQ(page, report_html(report, {}));
}

TEST(ReportHtml, HoldsThePreviewsWithoutTheirTitles) {
  PngWriter writer(1000, caption_top + 200, 3);
  std::vector<std::uint8_t> row(3000);
  for (int y = 0; y < caption_top + 200; ++y) {
    std::fill(row.begin(), row.end(), static_cast<std::uint8_t>(y < caption_top ? 0 : 200));
    writer.row(row.data());
  }
  const auto png = writer.finish();
  const std::string text = embedded_png(png, 500, caption_top);
  std::vector<std::uint8_t> bytes;  // base64 by hand
  std::uint32_t word = 0;
  int bits = 0;
  for (const char c : text) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    if (c == '=') break;
    word = word << 6 | static_cast<std::uint32_t>(digits.find(c)), bits += 6;
    if (bits >= 8) bits -= 8, bytes.push_back(static_cast<std::uint8_t>(word >> bits));
  }
  const Decoded picture = decode_png(bytes);
  EXPECT_EQ(picture.width, 500);
  EXPECT_EQ(picture.height, 100);
  for (const int y : {0, 50, 99}) EXPECT_EQ(picture.at(250, y, 0), 200);
  EXPECT_EQ(embedded_png({1, 2, 3}, 500, 0), "");
  EXPECT_EQ(embedded_png(png, 500, 1000), "");

  const std::string page = report_html(ReportJson::object(), {{"preview-with.png", png}, {"print.png", png}});
  EXPECT_EQ(count(page, "<img alt=\"Formed part with the pre-distorted print\" src=\"data:image/png;base64,"),
            1u);
  EXPECT_EQ(count(page, "<img"), 1u);
}

ReportJson small_report() {
  ReportJson report;
  report["label"] = "3f9a12c4";
  report["pattern"] = {{"size_mm", {200.0, 180.0}}, {"ink_printed", 1.0}, {"ink_on_head", 0.412}};
  report["print"] = {{"inked_face", "outer"}, {"mirrored", false}};
  report["coils"] = ReportJson::array();
  for (int i = 0; i < 19; ++i) report["coils"].push_back({{"id", "coil-" + std::to_string(i)}});
  report["figures"] = {
      {"without", {{"coils", {{"on_head", 5}, {"mean_circularity", 0.083}, {"worst_circularity", 0.2}}}}},
      {"with", {{"coils", {{"on_head", 6}, {"mean_circularity", 0.001}, {"worst_circularity", 0.002}}}}}};
  report["warnings"] = {{{"stage", "scan"},
                         {"code", "up-guessed"},
                         {"severity", "warning"},
                         {"what", "Up was guessed."},
                         {"place", "the whole scan"},
                         {"fix", "Set scan.up."}},
                        {{"stage", "printing"},
                         {"code", "coil-off-head"},
                         {"severity", "serious"},
                         {"what", "coil-3 lies off."},
                         {"place", "coil-3"},
                         {"fix", "Move it."}}};
  report["artifacts"] = {{{"name", "print.svg"}, {"title", "The print"}}};
  return report;
}

TEST(Summary, SaysHowManyCoilsLieOnTheHead) {
  const std::string text = summary_text(small_report(), "out");
  EXPECT_NE(text.find("41.2 % of its ink lies on the head, with 6 of 19 coils."), std::string::npos) << text;
  EXPECT_NE(text.find("Files: out"), std::string::npos);
  std::istringstream lines(text);
  std::string figures;
  while (std::getline(lines, figures) && !figures.starts_with("Circles out of round")) {
  }
  EXPECT_NE(figures.find("8.30 % (20.00 %)"), std::string::npos) << text;
  EXPECT_TRUE(figures.ends_with("0.10 % (0.20 %)")) << text;
}

// Of three coils two lie on the head as drawn and two as printed: one can be compared.
TEST(Summary, ComparesTheSameCoils) {
  ReportJson report = small_report();
  const auto way = [](bool on_head, double round) {
    return ReportJson{{"on_head", on_head}, {"circularity", round}, {"area_error", -round}};
  };
  report["coils"] = {{{"id", "a"}, {"with", way(true, 0.001)}, {"without", way(true, 0.05)}},
                     {{"id", "b"}, {"with", way(true, 0.003)}, {"without", way(false, 0.4)}},
                     {{"id", "c"}, {"with", way(false, 0.5)}, {"without", way(true, 0.2)}}};
  const auto line_of = [&](const std::string& start) {
    std::istringstream lines(summary_text(report, "out"));
    std::string line;
    while (std::getline(lines, line))
      if (line.find(start) != std::string::npos) return line;
    return std::string();
  };
  const std::string round =
      line_of("1 of the coils, on the head with both prints: circles out of round, mean");
  EXPECT_NE(round.find("5.00 %"), std::string::npos) << summary_text(report, "out");
  EXPECT_TRUE(round.ends_with("0.10 %")) << round;
  EXPECT_NE(line_of("areas inside coils off, mean").find("5.00 %"), std::string::npos);
  report["coils"].erase(2);
  report["coils"].erase(1);
  EXPECT_EQ(line_of("with both prints"), "");  // then the means above are of the same coils
}

TEST(Summary, ListsSeriousWarningsFirstWithPlaceAndFix) {
  const std::string text = summary_text(small_report(), "out");
  EXPECT_NE(text.find("1 serious warning, 1 warning, 0 notes\n  serious: coil-3 lies off. [coil-off-head]\n"
                      "    Where: coil-3\n    Fix: Move it.\n  warning: Up was guessed."),
            std::string::npos)
      << text;
  ReportJson none = small_report();
  none["warnings"] = ReportJson::array();
  EXPECT_NE(summary_text(none, "out").find("No warnings."), std::string::npos);
}

TEST(Summary, SaysWhereTheColoursOfAScanTouchIt) {
  ReportJson report = small_report();
  report["pattern"]["colours"] = {{"faded_share", 0.0484}};
  const std::string text = summary_text(report, "out");
  EXPECT_NE(text.find("of the colours of the scan.\n95.2 % of the coloured area touches the scan"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("as drawn"), std::string::npos);
  report["pattern"]["colours"]["faded_share"] = 0.0;
  EXPECT_NE(summary_text(report, "out").find("The coloured area touches the scan everywhere."),
            std::string::npos);
}

TEST(Summary, OfADrawingOverTheColoursNamesBothPrints) {
  ReportJson report = small_report();
  report["settings"]["pattern"]["source"] = "both";
  report["pattern"]["colours"] = {{"faded_share", 0.0484}};
  const std::string text = summary_text(report, "out");
  EXPECT_NE(text.find("as drawn"), std::string::npos) << text;
  EXPECT_NE(text.find("95.2 % of the coloured area touches the scan"), std::string::npos) << text;
  EXPECT_NE(text.find("of the colours colours.svg, colours.pdf and colours.png"), std::string::npos) << text;
}

TEST(Summary, HasTheSameAsJson) {
  const ReportJson report = small_report(), summary = summary_json(report, "out");
  EXPECT_EQ(summary["coils"], 19);
  EXPECT_EQ(summary["coils_on_head"], 6);
  EXPECT_EQ(summary["ink_on_head"], 0.412);
  EXPECT_EQ(summary["serious_warnings"], 1);
  EXPECT_EQ(summary["warnings"], report["warnings"]);
  EXPECT_EQ(summary["files"], ReportJson::array({"print.svg"}));
  ReportJson none = report;
  none["figures"]["with"]["coils"] = nullptr;
  EXPECT_EQ(summary_json(none, "out")["coils_on_head"], 0);
  none["coils"] = ReportJson::array();
  EXPECT_EQ(summary_json(none, "out")["coils_on_head"], nullptr);
}

TEST(ReportHtml, SaysWhoseItIsAndWhichSideIsConfirmed) {
  ReportJson report = small_report();
  const std::string before = report_html(report, {});
  EXPECT_EQ(before.find("reference"), std::string::npos);
  EXPECT_EQ(before.find("confirmed by a person"), std::string::npos);
  report["label"] = "3f9a12c4";
  report["reference"] = "Köln <12> & \"7\"";
  report["scan"]["left_side"] = "minus_x";
  const std::string page = report_html(report, {});
  EXPECT_NE(page.find("<h1>Vacuform report 3f9a12c4, reference Köln &lt;12&gt; &amp; &quot;7&quot;</h1>"),
            std::string::npos)
      << page;
  EXPECT_NE(page.find("The patient&#39;s left is at -x, confirmed by a person."), std::string::npos);
  EXPECT_NE(summary_text(report, "out").find("Print 3f9a12c4, reference Köln <12> & \"7\", for the"),
            std::string::npos);
  EXPECT_EQ(summary_json(report, "out")["reference"], report["reference"]);
}

TEST(ReportHtml, OfTheColoursOfAScanSpeaksOfNoDrawing) {
  ReportJson report = small_report();
  EXPECT_NE(report_html(report, {}).find("The drawing&#39;s centre lies"), std::string::npos);
  report["settings"]["pattern"]["source"] = "scan";
  const std::string page = report_html(report, {});
  EXPECT_NE(page.find("<p>The colours of the scan for a sheet of "), std::string::npos);
  EXPECT_EQ(page.find("drawing&#39;s centre"), std::string::npos);
}

TEST(ReportHtml, ShowsSeverityPlaceAndFixOfAWarning) {
  const std::string page = report_html(small_report(), {});
  EXPECT_NE(page.find("<li class=\"serious\"><b>serious</b> coil-3 lies off.<br><span class=\"soft\">Where: "
                      "coil-3.</span> <b>Fix:</b> Move it. <code class=\"soft\">coil-off-head</code>"),
            std::string::npos)
      << page;
  EXPECT_NE(page.find("6 of 19"), std::string::npos);
}

}  // namespace
}  // namespace vacuform
