// The pages, each a function of what it shows.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "server/pages/html.hpp"
#include "server/store/store.hpp"

namespace vacuform {

// The form for a new job, made from settings_schema(), with the newest jobs below. After a refusal `error`
// stands above it and `fields` (by their names) fill it again; files cannot be filled again, the page says
// so.
Page form_page(const std::vector<Job>& recent, const std::vector<Profile>& profiles,
               const std::optional<Error>& error = std::nullopt,
               const std::map<std::string, std::string>& fields = {});

// A job: progress while it runs, then previews, figures and downloads; what is in the scan, and after an inspection a
// form that makes the print. `made` is report.json or findings.json, null when there is none; parts that it lacks are left out. `log` is the beginning of the job's log.
Page job_page(const Job& job, const nlohmann::json& made, const std::vector<LogLine>& log = {});

// Beside the state of a job, on its page and in lists: "2 serious warnings", or nothing.
std::string serious_text(const Job& job);

// The form that takes a token; after a refusal `error` stands above it.
Page sign_in_page(const std::optional<Error>& error = std::nullopt);

// What each problem means and what helps; an empty slug gives the list of all.
Page problems_page();
Page problem_page(Code code);

// In place of a page that could not be shown.
Page refused_page(const http::Refusal& refusal);

}  // namespace vacuform
