#include <nlohmann/json.hpp>

#include "server/jobs/job_json.hpp"
#include "server/pages/pages.hpp"
#include "server/pages/template.hpp"

namespace vacuform {

using nlohmann::ordered_json;

namespace {

ordered_json recent_values(const std::vector<Job>& recent) {
  if (recent.empty()) return nullptr;
  ordered_json jobs = ordered_json::array();
  for (const Job& job : recent) {
    const std::string time = rfc3339(job.created);
    const bool running = job.state == JobState::running;
    jobs.push_back({{"created", time},
                    {"shown", time.substr(0, 10) + " " + time.substr(11, 5) + " UTC"},
                    {"id", job.id},
                    {"reference", job.reference},
                    {"kind", job.kind == JobKind::print ? "" : name(job.kind)},
                    {"state", name(job.state)},
                    {"serious", serious_text(job)},
                    {"percent", running ? std::to_string(static_cast<int>(100 * whole_progress(job))) : ""}});
  }
  return {{"jobs", std::move(jobs)}};
}

}  // namespace

Page list_page(const std::vector<Job>& recent) {
  Page page;
  page.title = "Recent jobs";
  page.signed_in = true;
  page.main = rendered("list", {{"title", page.title}, {"recent", recent_values(recent)}});
  return page;
}

}  // namespace vacuform
