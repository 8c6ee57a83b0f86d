// A new job as it arrives in a form: a file for each kind of input (api/job.hpp) or the id of one that is there already
// (scan_id of a scan; scan_upload, pattern_upload... of a whole upload), kind (print where it is not said, or inspection),
// profile (the name of settings to begin with), settings (JSON text), from (the id of a job, to share its files and begin
// with its settings), priority, and fields named group.key as the HTML form sends them.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "api/job_limits.hpp"
#include "server/http/message.hpp"
#include "server/jobs/service.hpp"

namespace vacuform {

// Of the body of a form with such a file, or with all of them.
std::uint64_t largest_form(std::string_view input);
std::uint64_t largest_form();

// Streams the files into the store, without the names in them (api/redaction/names.hpp), and validates the settings; the JSON text goes
// before the same setting of the profile, a field before both, an empty field keeps the default. An empty file is none, as a browser sends
// it. A temperature turns a uniform heat.source into a measured one, weights turn uniform flattening.weights into painted
// ones. `fields` receives what the form held, also when the result is an error. Errors: too_large, bad_settings, bad_usage
// (a part is missing, unknown or doubled, the body is no form), not_found, gone and conflict (of what an id names).
Result<NewJob> read_submission(Service& service, http::Request& request, const Caller& caller,
                               std::map<std::string, std::string>& fields);

// Creates the job, or gives the one that the same key created before, and logs which of the two. Errors: those of
// Store::create.
Result<Job> create_job(Service& service, NewJob submission, const Caller& caller);

// What a submission would be as a job: its settings in full and its files with the formats that they seem to be of. Keeps
// nothing. Errors: unsupported_format, and those of reading the files.
Result<nlohmann::ordered_json> plan_of(NewJob& job, Store& store);

}  // namespace vacuform
