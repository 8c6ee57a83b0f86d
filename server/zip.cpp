#include "server/zip.hpp"

#include <unistd.h>
#include <zip.h>

#include <cstdio>
#include <memory>

#include "server/secrets.hpp"

namespace vacuform {

namespace {

struct Discard {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};

tl::unexpected<Error> zip_failed(const char* why) {
  return fail(Code::unavailable, std::string("making the zip failed: ") + why, "artifacts.zip",
              "free some space on the server's disk, or download the artifacts one by one");
}

// The archive reads through a stream of its own, which it closes.
zip_source_t* source_of(zip_t* archive, const File& file) {
  const int descriptor = ::dup(file.descriptor());
  std::FILE* stream = descriptor < 0 ? nullptr : ::fdopen(descriptor, "rb");
  if (!stream) {
    if (descriptor >= 0) ::close(descriptor);
    return nullptr;
  }
  zip_source_t* source = zip_source_filep(archive, stream, 0, -1);
  if (!source) std::fclose(stream);
  return source;
}

}  // namespace

std::string zip_etag(const Job& job) {
  std::string text = "zip 1\n";
  for (const auto& artifact : job.artifacts) text += artifact.name + " " + artifact.blob.sha256 + "\n";
  return text_hash(text);
}

Result<File> make_zip(Store& store, const Job& job) {
  const std::string path = store.temporary_path().string();
  int code = 0;
  std::unique_ptr<zip_t, Discard> archive(zip_open(path.c_str(), ZIP_CREATE | ZIP_EXCL, &code));
  if (!archive) return zip_failed("no file");
  for (const auto& artifact : job.artifacts) {
    VACUFORM_TRY(file, store.open(artifact.blob));
    zip_source_t* source = source_of(archive.get(), file);
    if (!source) return zip_failed(zip_strerror(archive.get()));
    const zip_int64_t index = zip_file_add(archive.get(), artifact.name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) {
      zip_source_free(source);
      return zip_failed(zip_strerror(archive.get()));
    }
    const auto entry = static_cast<zip_uint64_t>(index);
    // PNG is compressed already; level 1 takes most of what meshes give at a tenth of the time.
    const bool packed = artifact.name.ends_with(".png");
    zip_set_file_compression(archive.get(), entry, packed ? ZIP_CM_STORE : ZIP_CM_DEFLATE, packed ? 0 : 1);
    zip_file_set_dostime(archive.get(), entry, 0, 0x21,
                         0);  // 1980-01-01: no clock and no time zone in the bytes
  }
  if (zip_close(archive.get()) != 0) {
    const std::string why = zip_strerror(archive.get());
    ::unlink(path.c_str());
    return zip_failed(why.c_str());
  }
  (void)archive.release();
  auto file = File::open(path);
  ::unlink(path.c_str());
  return file;
}

}  // namespace vacuform
