#include "worker/sample/sample_files.hpp"

#include <fstream>
#include <system_error>

#include "worker/sample/painted_model.hpp"
#include "worker/surface/stl.hpp"

namespace vacuform {

namespace {

template <class Bytes>
Result<void> write(const std::filesystem::path& path, const Bytes& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file)
    return fail(Code::unreadable, "cannot write the file", path.string(),
                "choose a folder you may write to, with room");
  return {};
}

}  // namespace

Result<void> write_sample(const std::filesystem::path& folder, const std::string& model, HeadForm form) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return fail(Code::unreadable, "cannot make the folder: " + error.message(), folder.string(),
                "choose a folder you may write to");
  if (model != "head")
    return write(folder / (model + ".glb"), painted_glb(model == "mask" ? Model::mask : Model::figurine));
  VACUFORM_CHECK(write(folder / "head.stl", stl_bytes(sample_head(form))));
  return write(folder / "pattern.svg", sample_pattern());
}

}  // namespace vacuform
