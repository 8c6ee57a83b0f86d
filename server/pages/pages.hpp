// The pages, each a function of its content.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "server/pages/html.hpp"
#include "server/store/store.hpp"

namespace vacuform {

// The newest jobs, each with a link to its page, and how to start one.
Page list_page(const std::vector<Job>& recent);

// A job: progress while it runs, then previews, figures and downloads; the content of the scan, the coils of a layout.
// `made` is the job's artifact report_of(kind), or null; missing parts are omitted. `log` is the beginning of the job's
// log, `estimate` what those who wait are told.
Page job_page(const Job& job, const nlohmann::json& made, const std::vector<LogLine>& log = {},
              const Estimate& estimate = {});

// Text next to the state of a job, on its page and in lists: "2 serious warnings", or empty.
std::string serious_text(const Job& job);

// The form for signing in with a token, or with the code of a link if there is one; after a refusal `error` is shown above
// it.
Page sign_in_page(const std::optional<Error>& error = std::nullopt, const std::string& link = {});

// The meaning of each problem and its fix; an empty slug returns the list of all.
Page problems_page();
Page problem_page(Code code);

// Replaces a page that could not be shown.
Page refused_page(const http::Refusal& refusal);

}  // namespace vacuform
