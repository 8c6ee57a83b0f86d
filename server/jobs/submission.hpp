// A new job as submitted in a form: a file for each kind of input (api/job.hpp) or the id of an existing one (scan_id
// of a scan; scan_upload, pattern_upload... of a complete upload), kind (print by default, inspection or layout), profile (the
// name of the base settings), settings (JSON text), from (the id of a job whose files and settings are the default),
// priority, reference, rescan (true: another scan of the patient who has the reference), note, and fields named group.key.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "api/job_limits.hpp"
#include "server/jobs/service.hpp"
#include "server/messages/message.hpp"

namespace vacuform {

// Limits of the body of a form with one such file, or with all of them.
std::uint64_t largest_form(std::string_view input);
std::uint64_t largest_form();

// Streams the files into the store, without the names in them (api/redaction/redaction.hpp), and validates the settings.
// The JSON text overrides the profile, a field overrides both, an empty field keeps the default. An empty file counts
// as missing, because browsers send one for an empty field. A temperature file turns a uniform heat.source into a
// measured one, a weights file turns uniform flattening.weights into painted ones. A job that is no layout drops the group
// layout of its profile or of the job that it starts from, and refuses it in the form. Errors: too_large, bad_settings,
// bad_usage (a part is missing, unknown or repeated, the body is not a form), not_found, gone and conflict (of the object
// that an id names).
Result<NewJob> read_submission(Service& service, http::Request& request, const Caller& caller);

// Refuses a reference that belongs to another head, as create_job() does. `submission` is of a job that is not created yet.
Result<void> check_reference(Service& service, NewJob& submission);

// Creates the job, or returns the one that the same key created before, and logs which of the two. Errors: those of
// Store::create.
Result<Job> create_job(Service& service, NewJob submission, const Caller& caller);

// What a submission would be as a job: all its settings, and its files with the formats that they seem to have. Stores
// nothing. Errors: unsupported_format, and those of reading the files.
Result<nlohmann::ordered_json> plan_of(NewJob& job, Store& store);

}  // namespace vacuform
