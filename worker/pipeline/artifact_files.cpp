#include "worker/pipeline/artifact_files.hpp"

#include <fstream>

namespace vacuform {

namespace {

Result<void> write_whole(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
  const std::filesystem::path part = path.string() + ".part";
  const auto refuse = [&](const char* what) {
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    return fail(Code::unreadable, what, path.string(), "check the folder's permissions and the free space");
  };
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) return refuse("the file cannot be written");
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (error) return refuse("the file cannot be put in its place");
  return {};
}

}  // namespace

Result<void> write_artifacts(const std::filesystem::path& out, const std::vector<Artifact>& files) {
  std::error_code error;
  std::filesystem::create_directories(out, error);
  if (error)
    return fail(Code::unreadable, "the folder cannot be made", out.string(),
                "check its name and permissions");
  for (const Artifact& file : files) VACUFORM_CHECK(write_whole(out / file.name, file.bytes));
  return {};
}

}  // namespace vacuform
