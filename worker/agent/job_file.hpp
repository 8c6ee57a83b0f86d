// A file that a job's process left, opened so that nothing but a plain file of its own is ever read.
#pragma once

#include <cstdint>
#include <optional>

#include "api/base/error.hpp"
#include "api/base/file_tree.hpp"

namespace vacuform {

struct JobFile {
  Descriptor descriptor;
  std::uint64_t bytes = 0;
};

// Opens `name` in `folder`, a subfolder of the open folder `home`; nothing where there is no such entry. Call it when
// every process of the job is dead. No link is followed, a FIFO does not block, and the file must be a regular one of
// this user with a single name and at most `largest` bytes. Errors: internal (anything else has that name).
Result<std::optional<JobFile>> open_job_file(int home, const char* folder, const char* name,
                                             std::uint64_t largest);

}  // namespace vacuform
