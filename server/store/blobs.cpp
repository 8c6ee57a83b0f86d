#include "server/store/blobs.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <vector>

namespace vacuform {

namespace fs = std::filesystem;

Upload::Upload(Upload&& other) noexcept
    : file_(std::move(other.file_)),
      path_(std::move(other.path_)),
      hash_(std::move(other.hash_)),
      blob_(std::move(other.blob_)) {
  other.path_.clear();
}

Upload::~Upload() {
  if (!path_.empty()) ::unlink(path_.c_str());
}

Result<void> Upload::write(std::string_view bytes) {
  VACUFORM_CHECK(file_.write(bytes));
  hash_.add(bytes);
  blob_.bytes += bytes.size();
  return {};
}

Result<Blob> Upload::seal() {
  if (blob_.sha256.empty()) {
    VACUFORM_CHECK(file_.sync());
    blob_.sha256 = hash_.hex();
  }
  return blob_;
}

Result<Blobs> Blobs::open(const fs::path& data) {
  Blobs blobs(data);
  VACUFORM_CHECK(make_directory(blobs.blobs_));
  VACUFORM_CHECK(make_directory(blobs.incoming_));
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(blobs.incoming_, error)) fs::remove(entry.path(), error);
  return blobs;
}

Result<Upload> Blobs::upload() const {
  fs::path path = temporary_path();
  VACUFORM_TRY(file, File::create(path));
  return Upload(std::move(file), std::move(path));
}

Upload Blobs::adopt(fs::path path, Blob blob) const {
  Upload upload({}, std::move(path));
  upload.blob_ = std::move(blob);
  return upload;
}

Result<void> Blobs::keep(Upload& upload) const {
  VACUFORM_TRY(blob, upload.seal());
  const fs::path path = place(blob.sha256);
  std::error_code error;
  if (fs::exists(path, error)) return {};  // the upload's own file goes with it
  const bool new_folder = !fs::exists(path.parent_path(), error);
  VACUFORM_CHECK(make_directory(path.parent_path()));
  if (new_folder) VACUFORM_CHECK(sync_directory(blobs_));
  if (std::rename(upload.path_.c_str(), path.c_str()) != 0)
    return fail(Code::unavailable, "keeping an upload failed: " + std::generic_category().message(errno), {},
                "see that the server may write to its data folder");
  upload.path_.clear();
  return sync_directory(path.parent_path());
}

Result<File> Blobs::read(const std::string& sha256) const { return File::open(place(sha256)); }

void Blobs::remove(const std::string& sha256) const { ::unlink(place(sha256).c_str()); }

Result<void> Blobs::sweep(const std::function<bool(const std::string&)>& wanted) const {
  std::error_code error;
  std::vector<fs::path> unwanted;
  for (const auto& entry : fs::recursive_directory_iterator(blobs_, error))
    if (!entry.is_directory(error) && !wanted(entry.path().filename().string()))
      unwanted.push_back(entry.path());
  if (error) return fail(Code::unavailable, "reading the blobs' folder failed: " + error.message(), "blobs");
  for (const auto& path : unwanted) ::unlink(path.c_str());
  return {};
}

}  // namespace vacuform
