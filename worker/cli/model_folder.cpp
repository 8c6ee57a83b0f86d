#include "worker/cli/model_folder.hpp"

#include <zip.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "api/base/text.hpp"
#include "worker/pipeline/inputs.hpp"

namespace vacuform::cli {

namespace fs = std::filesystem;

namespace {

using FileBytes = std::vector<std::uint8_t>;

std::string_view as_text(const FileBytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// What follows the lines that begin with `begin`, up to the end of a head.
std::vector<std::string> lines_after(std::string_view text, std::string_view begin) {
  std::vector<std::string> found;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find_first_of("\r\n", at), text.size());
    const std::string_view line = text.substr(at, end - at);
    if (line.starts_with(begin)) found.emplace_back(trimmed(line.substr(begin.size())));
    if (line == "end_header") break;
    at = end + 1;
  }
  return found;
}

// The libraries that an OBJ names, as one. A name may contain blanks, and a line may contain several names. Errors:
// unusable_scan (one is missing), those of read_file().
Result<FileBytes> libraries(const std::vector<std::string>& lines, const fs::path& folder,
                            const std::string& where) {
  FileBytes all;
  std::set<fs::path> read;
  const auto there = [&](std::string_view name) {
    std::error_code error;
    std::string plain(name);
    std::replace(plain.begin(), plain.end(), '\\', '/');
    const fs::path file_name = fs::path(plain).filename();
    if (!file_name.empty() && fs::is_regular_file(folder / file_name, error)) return folder / file_name;
    // Windows does not tell cases apart.
    for (const auto& entry : fs::directory_iterator(folder, error))
      if (lower(entry.path().filename().string()) == lower(file_name.string()) &&
          entry.is_regular_file(error))
        return entry.path();
    return fs::path();
  };
  for (const std::string& line : lines) {
    std::vector<std::string> names{line};
    if (there(line).empty()) {
      std::istringstream words(line);
      names.assign(std::istream_iterator<std::string>(words), {});
      if (std::ranges::none_of(names, [&](const std::string& name) { return !there(name).empty(); }))
        names = {line};
    }
    for (const std::string& name : names) {
      const fs::path path = there(name);
      if (path.empty())
        return fail(Code::unusable_scan,
                    "the OBJ names the material library " + name.substr(0, 100) + ", which is not beside it",
                    where, "put it into the folder of the OBJ, or correct the line mtllib");
      if (!read.insert(path).second) continue;
      VACUFORM_TRY(bytes, read_file(path));
      all.insert(all.end(), bytes.begin(), bytes.end());
      all.push_back('\n');
    }
  }
  return all;
}

// Whether numbers of a colour follow the place of the first vertex.
bool has_vertex_colours(std::string_view obj) {
  const std::size_t at = obj.starts_with("v ") ? 0 : obj.find("\nv ");
  if (at == std::string_view::npos) return false;
  std::string_view line = obj.substr(at + 1, 400);
  std::istringstream words{std::string(line.substr(0, line.find_first_of("\r\n")))};
  return std::distance(std::istream_iterator<std::string>(words), {}) >= 6;
}

bool is_image(const fs::path& file) {
  constexpr std::array<std::string_view, 8> extensions{".png",  ".jpg", ".jpeg", ".webp",
                                                       ".ktx2", ".tga", ".bmp",  ".tif"};
  return one_of(lower(file.extension().string()), extensions);
}

// The images in the folder and in those below it whose names are in the text, in the order of their names.
std::vector<fs::path> images_named(const fs::path& folder, std::string_view text) {
  const std::string named = lower(text);
  std::vector<fs::path> found;
  std::error_code error;
  fs::recursive_directory_iterator files(folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && files != fs::recursive_directory_iterator(); files.increment(error)) {
    if (files.depth() > 0) files.disable_recursion_pending();
    const fs::path& file = files->path();
    if (is_image(file) && named.find(lower(file.filename().string())) != std::string::npos &&
        files->is_regular_file(error))
      found.push_back(file);
  }
  std::sort(found.begin(), found.end());
  return found;
}

Result<FileBytes> packed(const std::map<std::string, FileBytes>& files, const std::string& where) {
  zip_error_t error;
  ::zip_error_init(&error);
  zip_source_t* whole = ::zip_source_buffer_create(nullptr, 0, 0, &error);
  zip_t* archive = whole ? ::zip_open_from_source(whole, ZIP_TRUNCATE, &error) : nullptr;
  bool good = archive != nullptr;
  if (good) ::zip_source_keep(whole);
  for (const auto& [name, bytes] : files) {
    zip_source_t* source = good ? ::zip_source_buffer(archive, bytes.data(), bytes.size(), 0) : nullptr;
    const zip_int64_t index = source ? ::zip_file_add(archive, name.c_str(), source, ZIP_FL_ENC_UTF_8) : -1;
    if (source && index < 0) ::zip_source_free(source);
    good = good && index >= 0 &&
           ::zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), ZIP_CM_STORE, 0) == 0;
  }
  good = good && ::zip_close(archive) == 0;
  if (!good && archive) ::zip_discard(archive);
  FileBytes out;
  zip_stat_t about;
  if (good && ::zip_source_stat(whole, &about) == 0 && ::zip_source_open(whole) == 0) {
    out.resize(about.size);
    good = ::zip_source_read(whole, out.data(), out.size()) == static_cast<zip_int64_t>(out.size());
    ::zip_source_close(whole);
  }
  if (whole) ::zip_source_free(whole);
  ::zip_error_fini(&error);
  if (!good || out.empty())
    return fail(Code::unreadable, "the files of the model cannot be packed", where, "give them as a zip");
  return out;
}

}  // namespace

Result<void> add_files_beside(std::vector<std::uint8_t>& bytes, std::string& file) {
  const fs::path scan(file), folder = scan.has_parent_path() ? scan.parent_path() : fs::path(".");
  const std::string extension = lower(scan.extension().string());
  std::map<std::string, FileBytes> files;
  std::string names;  // the text that names the images
  if (extension == ".obj") {
    const auto lines = lines_after(as_text(bytes), "mtllib ");
    if (lines.empty()) return {};
    auto found = libraries(lines, folder, file);
    if (!found && found.error().code == Code::unusable_scan && has_vertex_colours(as_text(bytes))) return {};
    VACUFORM_TRY(mtl, std::move(found));
    names = as_text(mtl);
    files["model.mtl"] = std::move(mtl);
  } else if (extension == ".ply") {
    const auto textures = lines_after(as_text(bytes), "comment TextureFile ");
    if (textures.empty()) return {};
    for (const std::string& texture : textures) names += texture + "\n";
  } else {
    return {};
  }
  for (const fs::path& image : images_named(folder, names)) {
    VACUFORM_TRY(picture, read_file(image));
    files[image.lexically_relative(folder).generic_string()] = std::move(picture);
  }
  files["model" + extension] = std::move(bytes);
  VACUFORM_TRY(zip, packed(files, file));
  bytes = std::move(zip);
  file += ".zip";
  return {};
}

}  // namespace vacuform::cli
