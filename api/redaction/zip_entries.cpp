#include "api/redaction/zip_entries.hpp"

#include <zip.h>

#include <algorithm>
#include <optional>

#include "api/base/text.hpp"
#include "api/redaction/model_names.hpp"
#include "api/redaction/redaction.hpp"

namespace vacuform::redaction {

namespace {

constexpr std::size_t longest_path = 1024;
constexpr std::uint64_t small_entry = 1 << 20;  // below it, any ratio is fine

tl::unexpected<Error> too_many_entries() {
  return refuse_zip(Code::too_large,
                    "the zip has more than " + std::to_string(zip_limits.entries) + " entries", {},
                    "pack the files alone");
}

// Shows a source to libzip.
class Shown {
 public:
  explicit Shown(const ByteSource& file, std::uint64_t size) : file_(file), size_(size) {
    ::zip_error_init(&error_);
  }
  ~Shown() { ::zip_error_fini(&error_); }
  Shown(const Shown&) = delete;
  Shown& operator=(const Shown&) = delete;

  static zip_int64_t call(void* self, void* data, zip_uint64_t length, zip_source_cmd_t command) {
    return static_cast<Shown*>(self)->answer(data, length, command);
  }
  std::optional<Error> problem;  // of the source

 private:
  zip_int64_t answer(void* data, zip_uint64_t length, zip_source_cmd_t command) {
    switch (command) {
      case ZIP_SOURCE_OPEN:
        at_ = 0;
        return 0;
      case ZIP_SOURCE_READ: {
        auto read = file_.read_at(at_, {static_cast<char*>(data), static_cast<std::size_t>(length)});
        if (!read) {
          problem = std::move(read.error());
          return ::zip_error_set(&error_, ZIP_ER_READ, 0), -1;
        }
        at_ += *read;
        return static_cast<zip_int64_t>(*read);
      }
      case ZIP_SOURCE_SEEK: {
        const zip_int64_t to = ::zip_source_seek_compute_offset(at_, size_, data, length, &error_);
        if (to < 0) return -1;
        at_ = static_cast<std::uint64_t>(to);
        return 0;
      }
      case ZIP_SOURCE_TELL:
        return static_cast<zip_int64_t>(at_);
      case ZIP_SOURCE_STAT: {
        auto* const about = static_cast<zip_stat_t*>(data);
        ::zip_stat_init(about);
        about->size = size_;
        about->valid |= ZIP_STAT_SIZE;
        return sizeof *about;
      }
      case ZIP_SOURCE_ERROR:
        return ::zip_error_to_data(&error_, data, length);
      case ZIP_SOURCE_SUPPORTS:
        return ::zip_source_make_command_bitmap(ZIP_SOURCE_OPEN, ZIP_SOURCE_READ, ZIP_SOURCE_CLOSE,
                                                ZIP_SOURCE_STAT, ZIP_SOURCE_ERROR, ZIP_SOURCE_FREE,
                                                ZIP_SOURCE_SEEK, ZIP_SOURCE_TELL, ZIP_SOURCE_SUPPORTS, -1);
      case ZIP_SOURCE_CLOSE:
      case ZIP_SOURCE_FREE:
        return 0;
      default:
        return ::zip_error_set(&error_, ZIP_ER_OPNOTSUPP, 0), -1;
    }
  }

  const ByteSource& file_;
  const std::uint64_t size_;
  std::uint64_t at_ = 0;
  zip_error_t error_;
};

struct CloseZip {
  void operator()(zip_t* archive) const { ::zip_discard(archive); }
  void operator()(zip_file_t* file) const { ::zip_fclose(file); }
};

// libzip keeps the whole directory in memory, so the records that state its length are looked at before: they stand at the end
// of the file, with a comment of 64 KiB at most behind them.
Result<void> check_count(const ByteSource& file, std::uint64_t size) {
  constexpr std::size_t record = 22,
                        locator = 20;  // bytes; the second is of an archive of 64 bits, before the first
  std::string tail(static_cast<std::size_t>(std::min<std::uint64_t>(size, 65'535 + record + locator)), '\0');
  for (std::size_t had = 0; had < tail.size();) {
    VACUFORM_TRY(n, file.read_at(size - tail.size() + had, {tail.data() + had, tail.size() - had}));
    if (n == 0) return damaged_zip("the zip ends within its data");
    had += n;
  }
  for (std::size_t at = 0; (at = tail.find("PK\5\6", at)) != std::string::npos; ++at) {
    if (at >= locator && tail.compare(at - locator, 4, "PK\6\7") == 0)
      return refuse_zip(Code::unsupported_format, "the zip is one of 64 bits", {},
                        "pack fewer or smaller files");
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(tail[at + i]); };
    if (at + record <= tail.size() && (byte(10) | byte(11) << 8) > static_cast<int>(zip_limits.entries))
      return too_many_entries();
  }
  return {};
}

Result<void> use_entry(zip_t* archive, zip_uint64_t i, const UseEntry& use) {
  zip_stat_t about;
  constexpr zip_uint64_t wanted =
      ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
  if (::zip_stat_index(archive, i, ZIP_FL_ENC_RAW, &about) != 0 || (about.valid & wanted) != wanted)
    return damaged_zip("the zip does not list the names and sizes of its entries");
  const std::string_view name = about.name;
  if (name.empty() || name.size() > longest_path)
    return damaged_zip("an entry has no name, or one of more than 1024 bytes");
  VACUFORM_TRY(path, plain_path(name, "the zip"));
  zip_uint8_t system = 0;
  zip_uint32_t attributes = 0;
  ::zip_file_get_external_attributes(archive, i, 0, &system, &attributes);
  if (system == ZIP_OPSYS_UNIX && (attributes >> 16 & 0170000) == 0120000)
    return refuse_zip(Code::corrupt_file, "the zip holds a link", path, "pack the file itself");
  if (about.encryption_method != ZIP_EM_NONE)
    return refuse_zip(Code::unsupported_format, "the zip is encrypted", path, "pack it without a password");
  if (about.comp_method != ZIP_CM_STORE && about.comp_method != ZIP_CM_DEFLATE)
    return refuse_zip(Code::unsupported_format,
                      "the zip is packed by method " + std::to_string(about.comp_method), path,
                      "pack it with deflate, which every program can");
  if (about.size > small_entry && about.size / zip_limits.ratio > about.comp_size)
    return refuse_zip(
        Code::too_large,
        "an entry of the zip unpacks to more than " + std::to_string(zip_limits.ratio) + " times its size",
        path, "pack an ordinary file");
  const std::unique_ptr<zip_file_t, CloseZip> file(::zip_fopen_index(archive, i, 0));
  if (!file) return damaged_zip("an entry of the zip is damaged", path);
  std::uint64_t left = about.size;
  Cursor in([&](std::span<char> into) -> Result<std::size_t> {
    const zip_int64_t read = ::zip_fread(file.get(), into.data(), into.size());
    if (read < 0 || static_cast<std::uint64_t>(read) > left || (read == 0 && left > 0))
      return damaged_zip("an entry has another size or checksum than the zip says", path);
    left -= static_cast<std::uint64_t>(read);
    return static_cast<std::size_t>(read);
  });
  const std::string own = base_name(path);
  if (!own.empty() && !own.starts_with("._") && !path.starts_with("__MACOSX/")) VACUFORM_CHECK(use(path, in));
  VACUFORM_CHECK(in.skip(all_bytes));  // to the checksum
  return {};
}

}  // namespace

tl::unexpected<Error> refuse_zip(Code code, std::string what, const std::string& path, std::string fix) {
  return fail(code, std::move(what), path.empty() ? "the zip" : "the zip, " + path, std::move(fix));
}
tl::unexpected<Error> damaged_zip(std::string what, const std::string& path) {
  return refuse_zip(Code::corrupt_file, std::move(what), path, "pack it again");
}

std::string base_name(std::string_view path) { return lower(path.substr(path.rfind('/') + 1)); }
std::string extension_of(std::string_view path) {
  const std::size_t dot = path.find_last_of("./");
  return dot == std::string_view::npos || path[dot] == '/' ? std::string() : lower(path.substr(dot + 1));
}

struct ZipEntries::Archive {
  Archive(const ByteSource& file, std::uint64_t size) : shown(file, size) {}
  Shown shown;
  std::unique_ptr<zip_t, CloseZip> zip;
};

ZipEntries::ZipEntries(std::unique_ptr<Archive> archive) : archive_(std::move(archive)) {}
ZipEntries::~ZipEntries() = default;
ZipEntries::ZipEntries(ZipEntries&&) noexcept = default;

Result<ZipEntries> ZipEntries::open(const ByteSource& file) {
  VACUFORM_TRY(size, file.size());
  VACUFORM_CHECK(check_count(file, size));
  auto archive = std::make_unique<Archive>(file, size);
  zip_error_t error;
  ::zip_error_init(&error);
  zip_source_t* const source = ::zip_source_function_create(Shown::call, &archive->shown, &error);
  archive->zip.reset(source ? ::zip_open_from_source(source, ZIP_RDONLY | ZIP_CHECKCONS, &error) : nullptr);
  const std::string why = ::zip_error_strerror(&error);
  ::zip_error_fini(&error);
  if (!archive->zip) {
    if (source) ::zip_source_free(source);
    if (archive->shown.problem) return tl::make_unexpected(*std::move(archive->shown.problem));
    return damaged_zip("the zip cannot be opened: " + why);
  }
  if (::zip_get_num_entries(archive->zip.get(), 0) > static_cast<zip_int64_t>(zip_limits.entries))
    return too_many_entries();
  return ZipEntries(std::move(archive));
}

bool ZipEntries::holds(std::span<const std::string_view> extensions) const {
  const auto entries = static_cast<zip_uint64_t>(::zip_get_num_entries(archive_->zip.get(), 0));
  for (zip_uint64_t i = 0; i < entries; ++i)
    if (const char* name = ::zip_get_name(archive_->zip.get(), i, ZIP_FL_ENC_RAW);
        name && one_of(extension_of(name), extensions))
      return true;
  return false;
}

Result<void> ZipEntries::each(const UseEntry& use) {
  const auto entries = static_cast<zip_uint64_t>(::zip_get_num_entries(archive_->zip.get(), 0));
  for (zip_uint64_t i = 0; i < entries; ++i) {
    auto used = use_entry(archive_->zip.get(), i, use);
    if (!used && archive_->shown.problem) return tl::make_unexpected(*std::move(archive_->shown.problem));
    VACUFORM_CHECK(used);
  }
  return {};
}

}  // namespace vacuform::redaction
