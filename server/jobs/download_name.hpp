// The names of downloads: for the folder of a person who has many of them.
#pragma once

#include <string>
#include <string_view>

#include "server/store/job.hpp"

namespace vacuform {

// "CASE-12-outer-print.pdf": the reference of the job, or the last eight characters of its id; of the print the inked
// face; the name of the artifact, or "artifacts.zip". UTF-8, without characters that some system does not take in the
// name of a file.
std::string download_name(const Job& job, std::string_view artifact);

// The value of Content-Disposition; `how` is inline or attachment. `filename` has letters, digits, '.', '_' and '-'
// alone; where that is not the whole name, `filename*` has it (RFC 6266).
std::string content_disposition(std::string_view how, const Job& job, std::string_view artifact);

}  // namespace vacuform
