#include "server/store/incoming.hpp"

#include <unistd.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>

#include "api/base/file.hpp"
#include "api/base/log.hpp"

namespace vacuform {

Result<void> delete_file(const std::filesystem::path& file) {
  if (::unlink(file.c_str()) == 0 || errno == ENOENT) return {};
  return fail(Code::unavailable, "deleting a file failed: " + std::generic_category().message(errno),
              file.filename().string(), "check that the server may write to its data folder");
}

Result<void> Incoming::open() const {
  VACUFORM_CHECK(make_directory(folder_));
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder_, error))
    if (const auto deleted = delete_file(entry.path()); !deleted)
      log_event("file-not-deleted", {{"folder", "incoming"}, {"problem", deleted.error().what}});
  return {};
}

Result<Upload> Incoming::upload(Use use) const {
  if (room_) VACUFORM_CHECK(room_->check(use));
  std::filesystem::path path = temporary_path();
  VACUFORM_TRY(file, File::create(path));
  return Upload(std::move(file), std::move(path), room_, use);
}

}  // namespace vacuform
