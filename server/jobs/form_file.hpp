// A file of a request on its way into the store: encrypted on the disk until it is whole (sealed_file.hpp), then stored
// without the names in it (api/redaction/redaction.hpp).
#pragma once

#include <string>
#include <string_view>

#include "api/job.hpp"
#include "server/store/sealed_file.hpp"
#include "server/store/store.hpp"

namespace vacuform {

class FormFile {
 public:
  // Keeps a reference to the store. Errors: disk_full, unavailable.
  static Result<FormFile> begin(Store& store, const InputKind& kind, std::string extension);

  // Errors: too_large (for its kind), disk_full, unavailable.
  Result<void> write(std::string_view bytes);
  // Ends the file. Errors: those of redact(), disk_full, unavailable.
  Result<void> end();

  bool given() const { return upload && upload->bytes() > 0; }
  std::optional<Upload> upload;  // once it has ended
  std::string extension;

 private:
  FormFile(Store& store, const InputKind& kind, std::string of_name, SealedFile file)
      : extension(std::move(of_name)), store_(&store), kind_(&kind), file_(std::move(file)) {}

  Store* store_;
  const InputKind* kind_;
  SealedFile file_;
};

// A file in the store's place for new ones, without the names in `file`, which is the job's `input`. Errors: as of
// FormFile::end().
Result<Upload> redacted_upload(Store& store, SealedFile& file, std::string_view input,
                               const std::string& extension);
// Whether such an error is one of the file, which comes again whenever it is tried.
bool is_fault_of_file(Code code);

}  // namespace vacuform
