// A job as the API shows it (the schema Job of api/openapi.yaml).
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "server/store/store.hpp"

namespace vacuform {

nlohmann::ordered_json job_json(const Job& job, Detail detail = Detail::full);
// The whole job with the estimates for those who wait.
nlohmann::ordered_json job_json(const Job& job, const Estimate& estimate);
nlohmann::ordered_json artifact_json(const Job& job, const StoredArtifact& artifact);
nlohmann::ordered_json input_json(const Input& input);
nlohmann::ordered_json backup_json(const BackupReport& report);
nlohmann::ordered_json orphans_json(const OrphanReport& report);
nlohmann::ordered_json log_line_json(const LogLine& line);
nlohmann::ordered_json inputs_json(const Job& job);  // by name, those that the job has
nlohmann::ordered_json reference_changes_json(const Job& job);
std::string etag_of(const Job& job);  // of the job as it is now, with its quotes

// Progress of the whole job in 0..1, from the stage and the progress within it. It never falls while an
// attempt runs.
double whole_progress(const Job& job);

}  // namespace vacuform
