// The templates of the pages, and how values come into them.
#include "server/pages/template.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/pages/assets.hpp"
#include "server/pages/html.hpp"
#include "server/pages/pages.hpp"

namespace vacuform {
namespace {

using nlohmann::json;

constexpr std::string_view tail = ".mustache";

TEST(Templates, AllCanBeParsedAndNeedTheirValues) {
  int found = 0;
  for (const Asset& file : assets()) {
    if (!file.name.ends_with(tail)) continue;
    ++found;
    const std::string name(file.name.substr(0, file.name.size() - tail.size()));
    try {
      rendered(name, json::object());
      ADD_FAILURE() << name << " shows something without any value";
    } catch (const std::logic_error& fault) {
      EXPECT_NE(std::string(fault.what()).find("there is no value for"), std::string::npos) << fault.what();
    }
  }
  EXPECT_GT(found, 10);
}

TEST(Templates, AllPagesAreRendered) {
  Job job;
  job.id = "x";
  job.settings = "{}";
  for (std::size_t i = 0; i < job_state_names.size(); ++i)
    for (const JobKind kind : {JobKind::print, JobKind::inspection, JobKind::layout}) {
      job.state = static_cast<JobState>(i);
      job.kind = kind;
      EXPECT_TRUE(html_response(job_page(job, json())).text.ends_with("</html>\n"));
    }
  for (int i = 0; i <= static_cast<int>(Code::internal); ++i)
    EXPECT_NE(problem_page(static_cast<Code>(i)).main.find("<h2>What to do</h2>"), std::string::npos);
  EXPECT_NE(problems_page().main.find("<li>"), std::string::npos);
  EXPECT_NE(sign_in_page().main.find("</form>"), std::string::npos);
  EXPECT_NE(list_page({job}).main.find("</table>"), std::string::npos);
  EXPECT_NE(list_page({}).main.find("There are no jobs yet."), std::string::npos);
  EXPECT_NE(refused_page({404, {Code::not_found, "what", "", ""}}).main.find("role=\"alert\""),
            std::string::npos);
}

TEST(Templates, ValuesAreText) {
  const std::string evil = "<script>&\"'{{title}}{{{main}}}";
  const std::string html =
      rendered("problems", {{"problems", {{{"slug", evil}, {"title", evil}}}}, {"warnings", json::array()}});
  const std::string shown = "&lt;script&gt;&amp;&quot;&apos;{{title}}{{{main}}}";
  EXPECT_NE(html.find("<li><a href=\"/problems/" + shown + "\">" + shown + "</a></li>"), std::string::npos)
      << html;
}

TEST(Templates, ABugStopsLoudly) {
  EXPECT_THROW(rendered("none", json::object()), std::logic_error);
  EXPECT_THROW(rendered("problems", {{"problems", 7}}), std::logic_error);
  EXPECT_THROW(rendered("problem", {{"title", "x"}}), std::logic_error);
  EXPECT_THROW(asset("none"), std::logic_error);
}

TEST(ReadableBytes, AreInTheLargestUnitThatFits) {
  EXPECT_EQ(readable_bytes(1023), "1023 B");
  EXPECT_EQ(readable_bytes(1024), "1 KiB");
  EXPECT_EQ(readable_bytes((1 << 20) - 1), "1.0 MiB");
  EXPECT_EQ(readable_bytes(3'600'000), "3.4 MiB");
  EXPECT_EQ(readable_bytes((1 << 30) - 1), "1.0 GiB");
  EXPECT_EQ(readable_bytes(std::uint64_t{1} << 31), "2.0 GiB");
}

}  // namespace
}  // namespace vacuform
