#include "server/jobs/form_file.hpp"

#include "api/redaction/redaction.hpp"

namespace vacuform {

Result<FormFile> FormFile::begin(Store& store, const InputKind& kind, std::string extension) {
  VACUFORM_TRY(file, SealedFile::temporary(store.temporary_path()));
  return FormFile(store, kind, std::move(extension), std::move(file));
}

Result<void> FormFile::write(std::string_view bytes) {
  if (file_.bytes() + bytes.size() > kind_->most_bytes)
    return fail(Code::too_large,
                "the " + std::string(kind_->name) + " is larger than " +
                    std::to_string(kind_->most_bytes >> 20) + " MiB",
                std::string(kind_->name), "send a smaller file");
  VACUFORM_CHECK(store_->room_for(bytes.size()));
  return file_.take(bytes);
}

Result<void> FormFile::end() {
  VACUFORM_TRY(redacted, redacted_upload(*store_, file_, kind_->name, extension));
  upload.emplace(std::move(redacted));
  return {};
}

Result<Upload> redacted_upload(Store& store, SealedFile& file, std::string_view input,
                               const std::string& extension) {
  VACUFORM_CHECK(file.seal());
  VACUFORM_TRY(upload, store.upload());
  auto done = redact(file, extension, [&](std::string_view bytes) { return upload.write(bytes); });
  if (done) return upload;
  if (done.error().where.empty())
    done.error().where = std::string(input) + (extension.empty() ? "" : "." + extension);
  return tl::make_unexpected(std::move(done.error()));
}

bool is_fault_of_file(Code code) {
  return code == Code::corrupt_file || code == Code::unsupported_format || code == Code::unusable_scan ||
         code == Code::too_large;
}

}  // namespace vacuform
