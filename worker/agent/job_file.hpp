// A file that the process of a job left, opened so that only a regular file in its folder is ever read.
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

// Opens `name` in `folder`, a subfolder of the open folder `home`; nothing if the entry does not exist. Call it after
// every process of the job has ended. It follows no links and does not block on a FIFO. The file must be a regular one
// of this user, with a single hard link and at most `largest` bytes. Errors: internal (anything else has that name).
Result<std::optional<JobFile>> open_job_file(int home, const char* folder, const char* name,
                                             std::uint64_t largest);

}  // namespace vacuform
