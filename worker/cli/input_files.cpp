#include "worker/cli/input_files.hpp"

#include "api/redaction/redaction.hpp"

namespace vacuform::cli {

Result<std::optional<InputFile>> read_input(const std::string& path, std::uint64_t limit) {
  if (path.empty()) return std::optional<InputFile>();
  VACUFORM_TRY(bytes, read_file(path, limit));
  VACUFORM_CHECK(redact(bytes, path));
  return std::optional(InputFile{std::move(bytes), path});
}

}  // namespace vacuform::cli
