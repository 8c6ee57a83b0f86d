// The files in an uploaded zip, each checked before it is read. Internal to api/redaction.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "api/base/error.hpp"
#include "api/redaction/formats.hpp"

namespace vacuform::redaction {

// Errors of a file in the zip, or of the zip itself.
tl::unexpected<Error> refuse_zip(Code code, std::string what, const std::string& path, std::string fix);
tl::unexpected<Error> damaged_zip(std::string what, const std::string& path = {});

// The name without its folders, and its extension without the dot, in lower case.
std::string base_name(std::string_view path);
std::string extension_of(std::string_view path);

// Called with each file in the order of the archive; folders, and what macOS adds to an archive, are left out. The path has no
// parent folder in it.
using UseEntry = std::function<Result<void>(const std::string& path, Cursor& in)>;

class ZipEntries {
 public:
  // Keeps a reference to the source. Errors: corrupt_file, unsupported_format, too_large (redaction.hpp), those of the source.
  static Result<ZipEntries> open(const ByteSource& file);
  ~ZipEntries();
  ZipEntries(ZipEntries&&) noexcept;

  bool holds(std::span<const std::string_view> extensions) const;
  Result<void> each(const UseEntry& use);

 private:
  struct Archive;
  explicit ZipEntries(std::unique_ptr<Archive> archive);
  std::unique_ptr<Archive> archive_;
};

}  // namespace vacuform::redaction
