#include "worker/scan/model_zip.hpp"

#include <zip.h>

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>

namespace vacuform {

namespace {

// The limits of the archive that api/redaction writes without names.
constexpr zip_int64_t most_entries = 1000;
constexpr std::uint64_t most_ratio = 200, small_entry = 1 << 20;

struct CloseZip {
  void operator()(zip_t* archive) const { ::zip_discard(archive); }
  void operator()(zip_file_t* file) const { ::zip_fclose(file); }
};
using Archive = std::unique_ptr<zip_t, CloseZip>;

// Keeps a reference to the bytes.
Archive open_zip(Bytes bytes) {
  zip_error_t error;
  ::zip_error_init(&error);
  zip_source_t* source = ::zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  zip_t* archive = source ? ::zip_open_from_source(source, ZIP_RDONLY | ZIP_CHECKCONS, &error) : nullptr;
  if (source && !archive) ::zip_source_free(source);
  ::zip_error_fini(&error);
  return Archive(archive);
}

bool is_texture(std::string_view name) {
  return name.starts_with("texture-") && name.size() > 8 && name.size() <= 16 &&
         std::all_of(name.begin() + 8, name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

Result<ModelFiles> read_model_zip(Bytes bytes, const std::string& where, const ScanProgress& progress,
                                  ScanParts parts) {
  const auto damaged = [&](const std::string& what) {
    return fail(Code::corrupt_file, "the zip " + what, where, "pack the model again");
  };
  const Archive archive = open_zip(bytes);
  if (!archive) return damaged("cannot be opened");
  const zip_int64_t entries = ::zip_get_num_entries(archive.get(), 0);
  if (entries > most_entries) return damaged("has more than " + std::to_string(most_entries) + " entries");
  ModelFiles files;
  bool model = false;
  std::uint64_t left = scan_limits.bytes;
  for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(entries); ++i) {
    VACUFORM_CHECK(progress.tick());
    zip_stat_t about;
    constexpr zip_uint64_t wanted =
        ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_ENCRYPTION_METHOD;
    if (::zip_stat_index(archive.get(), i, 0, &about) != 0 || (about.valid & wanted) != wanted)
      return damaged("does not list the names and sizes of its entries");
    const std::string name(about.name);
    if (about.encryption_method != ZIP_EM_NONE)
      return fail(Code::unsupported_format, "the zip is encrypted", where, "pack it without a password");
    std::vector<std::uint8_t>* file = nullptr;
    if ((name == "model.obj" || name == "model.ply") && !model) {
      model = true;
      files.ply = name == "model.ply";
      file = &files.model;
    } else if (name == "model.mtl" && files.library.empty()) {
      file = &files.library;
    } else if (is_texture(name) && !files.images.contains(name)) {
      file = &files.images[name];
    } else {
      return damaged("has an entry that does not belong to a model");
    }
    if (about.size > left || (about.size > small_entry && about.size / most_ratio > about.comp_size))
      return fail(Code::too_large, "the zip unpacks to too many bytes", where,
                  "reduce the scan (quadric decimation) to a few hundred thousand triangles");
    left -= about.size;
    if (file != &files.model && parts == ScanParts::shape) continue;
    const std::unique_ptr<zip_file_t, CloseZip> opened(::zip_fopen_index(archive.get(), i, 0));
    file->resize(about.size);
    if (!opened ||
        ::zip_fread(opened.get(), file->data(), about.size) != static_cast<zip_int64_t>(about.size))
      return damaged("is damaged");
    // libzip compares the checksum when it reaches the end.
    if (char more = 0; ::zip_fread(opened.get(), &more, 1) != 0) return damaged("is damaged");
  }
  if (!model) return fail(Code::unusable_scan, "the zip holds no model", where, "pack one OBJ or one PLY");
  return files;
}

}  // namespace vacuform
