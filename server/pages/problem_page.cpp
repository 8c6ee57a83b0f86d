// Explains each problem type to people: the page behind every "type" of the API's problems.
#include <nlohmann/json.hpp>

#include "api/problem.hpp"
#include "api/warning_kinds.hpp"
#include "server/pages/pages.hpp"
#include "server/pages/template.hpp"

namespace vacuform {

using nlohmann::ordered_json;

Page problem_page(Code code) {
  const CodeMeaning& kind = meaning(code);
  Page page;
  page.title = std::string(kind.title);
  page.main = rendered("problem", {{"title", page.title},
                                   {"why", kind.detail},
                                   {"help", kind.fix},
                                   {"slug", kind.slug},
                                   {"status", std::to_string(kind.http_status)},
                                   {"exit_code", std::to_string(kind.exit_code)}});
  return page;
}

Page problems_page() {
  ordered_json problems = ordered_json::array();
  for (int i = 0; i <= static_cast<int>(Code::internal); ++i) {
    const CodeMeaning& code = meaning(static_cast<Code>(i));
    problems.push_back({{"slug", code.slug}, {"title", code.title}});
  }
  Page page;
  page.title = "Problems and warnings explained";
  ordered_json warnings = ordered_json::array();
  for (const WarningKind& kind : warning_kinds())
    warnings.push_back({{"code", kind.code},
                        {"severity", name(kind.severity)},
                        {"meaning", kind.meaning},
                        {"fix", kind.fix}});
  page.main = rendered("problems", {{"problems", std::move(problems)}, {"warnings", std::move(warnings)}});
  return page;
}

Page refused_page(const http::Refusal& refusal) {
  Page page;
  page.title = std::string(meaning(refusal.error.code).title);
  page.status = refusal.status;
  page.main = rendered("refused", {{"problem", problem_values(refusal.error)}});
  return page;
}

}  // namespace vacuform
