#include <nlohmann/json.hpp>

#include "api/problem.hpp"
#include "server/pages/pages.hpp"
#include "server/pages/template.hpp"

namespace vacuform {

Page sign_in_page(const std::optional<Error>& error, const std::string& link) {
  Page page;
  page.title = "Sign in";
  page.status = error ? meaning(error->code).http_status : 200;
  page.main = rendered("sign_in", {{"problem", problem_values(error)}, {"link", link}});
  return page;
}

}  // namespace vacuform
