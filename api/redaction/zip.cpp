#include <zip.h>
#include <zlib.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "api/base/text.hpp"
#include "api/redaction/formats.hpp"
#include "api/redaction/model_names.hpp"
#include "api/redaction/redaction.hpp"

namespace vacuform::redaction {

namespace {

constexpr std::uint32_t local_mark = 0x04034b50, central_mark = 0x02014b50, end_mark = 0x06054b50,
                        descriptor_mark = 0x08074b50;
constexpr std::uint32_t sizes_follow = 8, by_deflate = 8;
constexpr std::size_t longest_path = 1024, image_head = 12, largest_block = 65535;
constexpr std::uint64_t small_entry = 1 << 20;  // below it, any ratio is fine
constexpr std::uint16_t first_day = 0x21;       // 1980-01-01: no clock and no time zone in the bytes

tl::unexpected<Error> refuse(Code code, std::string what, const std::string& path, std::string fix) {
  return fail(code, std::move(what), path.empty() ? "the zip" : "the zip, " + path, std::move(fix));
}
tl::unexpected<Error> damaged(std::string what, const std::string& path = {}) {
  return refuse(Code::corrupt_file, std::move(what), path, "pack it again");
}

tl::unexpected<Error> too_many_entries() {
  return refuse(Code::too_large,
                "the zip has more than " + std::to_string(model_zip_limits.entries) + " entries", {},
                "pack the model alone");
}

std::string base_name(std::string_view path) { return lower(path.substr(path.rfind('/') + 1)); }
std::string extension_of(std::string_view path) {
  const std::size_t dot = path.find_last_of("./");
  return dot == std::string_view::npos || path[dot] == '/' ? std::string() : lower(path.substr(dot + 1));
}

// What an image is that is not read, by its first bytes or by its name.
std::string_view kind_of_image(std::string_view head, std::string_view extension) {
  if ((head.starts_with("RIFF") && head.ends_with("WEBP")) || extension == "webp") return "a WebP image";
  if (head.starts_with("\xabKTX") || extension == "ktx2" || extension == "ktx") return "a KTX image";
  if (extension == "tga") return "a TGA image";
  return "neither PNG nor JPEG";
}

// Writes a zip as a stream, without compression and in the same bytes on every machine.
class NewZip {
 public:
  explicit NewZip(Copy& out) : out_(out) {}

  Result<void> begin(std::string name) {
    std::string head = bytes_of(local_mark, 4) + common();
    for (int i = 0; i < 3; ++i) head += bytes_of(0, 4);  // checksum and sizes follow
    head += bytes_of(name.size(), 2) + bytes_of(0, 2) + name;
    entries_.push_back({std::move(name), out_.bytes() - start_});
    return out_.write(head);
  }
  // Of the entry that begin() named last.
  Result<void> write(std::string_view bytes) {
    Entry& entry = entries_.back();
    entry.crc = static_cast<std::uint32_t>(
        ::crc32_z(entry.crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
    entry.bytes += bytes.size();
    while (!bytes.empty()) {
      const std::size_t n = std::min(largest_block - block_.size(), bytes.size());
      block_ += bytes.substr(0, n);
      bytes.remove_prefix(n);
      if (block_.size() == largest_block) VACUFORM_CHECK(write_block(false));
    }
    if (out_.bytes() - start_ <= model_zip_limits.bytes) return {};
    return refuse(Code::too_large, "the zip unpacks to more than 1 GiB", entry.name,
                  "reduce the scan (quadric decimation) to a few hundred thousand triangles");
  }
  Result<void> end() {
    VACUFORM_CHECK(write_block(true));
    const Entry& entry = entries_.back();
    return out_.write(bytes_of(descriptor_mark, 4) + bytes_of(entry.crc, 4) + bytes_of(entry.packed, 4) +
                      bytes_of(entry.bytes, 4));
  }
  Result<void> directory() {
    const std::uint64_t offset = out_.bytes() - start_;
    std::string list;
    for (const Entry& entry : entries_)
      list += bytes_of(central_mark, 4) + bytes_of(3 << 8 | 20, 2) + common() + bytes_of(entry.crc, 4) +
              bytes_of(entry.packed, 4) + bytes_of(entry.bytes, 4) + bytes_of(entry.name.size(), 2) +
              std::string(8, '\0') + bytes_of(0100644u << 16, 4) + bytes_of(entry.offset, 4) + entry.name;
    const std::size_t size = list.size();
    list += bytes_of(end_mark, 4) + bytes_of(0, 4) + bytes_of(entries_.size(), 2) +
            bytes_of(entries_.size(), 2) + bytes_of(size, 4) + bytes_of(offset, 4) + bytes_of(0, 2);
    return out_.write(list);
  }

 private:
  struct Entry {
    std::string name;
    std::uint64_t offset = 0, bytes = 0, packed = 0;
    std::uint32_t crc = 0;
  };

  static std::string bytes_of(std::uint64_t value, int bytes) {
    std::string out;
    for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i) & 0xff);
    return out;
  }
  static std::string common() {
    std::string out;
    for (const std::uint32_t value : {20u, sizes_follow, by_deflate, 0u, std::uint32_t{first_day}})
      out += bytes_of(value, 2);
    return out;
  }
  // The bytes as they are, in a block of deflate (RFC 1951, 3.2.4): unlike a stored entry, it says where it ends.
  Result<void> write_block(bool last) {
    VACUFORM_CHECK(out_.write((last ? "\1" : std::string(1, '\0')) + bytes_of(block_.size(), 2) +
                              bytes_of(~block_.size(), 2) + block_));
    entries_.back().packed += block_.size() + 5;
    block_.clear();
    return {};
  }

  Copy& out_;
  const std::uint64_t start_ = out_.bytes();
  std::vector<Entry> entries_;
  std::string block_;
};

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
    if (n == 0) return damaged("the zip ends within its data");
    had += n;
  }
  for (std::size_t at = 0; (at = tail.find("PK\5\6", at)) != std::string::npos; ++at) {
    if (at >= locator && tail.compare(at - locator, 4, "PK\6\7") == 0)
      return refuse(Code::unsupported_format, "the zip is one of 64 bits", {}, "pack fewer or smaller files");
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(tail[at + i]); };
    if (at + record <= tail.size() && (byte(10) | byte(11) << 8) > static_cast<int>(model_zip_limits.entries))
      return too_many_entries();
  }
  return {};
}

class ModelZip {
 public:
  ModelZip(zip_t* archive, Copy& out) : archive_(archive), zip_(out) {}

  Result<void> copy() {
    const auto entries = static_cast<zip_uint64_t>(::zip_get_num_entries(archive_, 0));
    if (entries > model_zip_limits.entries) return too_many_entries();
    for (zip_uint64_t i = 0; i < entries; ++i) VACUFORM_CHECK(entry(i));
    VACUFORM_CHECK(check_whole());
    return zip_.directory();
  }

 private:
  Result<void> entry(zip_uint64_t i) {
    zip_stat_t about;
    constexpr zip_uint64_t wanted = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE |
                                    ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
    if (::zip_stat_index(archive_, i, ZIP_FL_ENC_RAW, &about) != 0 || (about.valid & wanted) != wanted)
      return damaged("the zip does not list the names and sizes of its entries");
    const std::string_view name = about.name;
    if (name.empty() || name.size() > longest_path)
      return damaged("an entry has no name, or one of more than 1024 bytes");
    VACUFORM_TRY(path, plain_path(name, "the zip"));
    path_ = std::move(path);
    zip_uint8_t system = 0;
    zip_uint32_t attributes = 0;
    ::zip_file_get_external_attributes(archive_, i, 0, &system, &attributes);
    if (system == ZIP_OPSYS_UNIX && (attributes >> 16 & 0170000) == 0120000)
      return refuse(Code::corrupt_file, "the zip holds a link", path_, "pack the file itself");
    if (about.encryption_method != ZIP_EM_NONE)
      return refuse(Code::unsupported_format, "the zip is encrypted", path_, "pack it without a password");
    if (about.comp_method != ZIP_CM_STORE && about.comp_method != ZIP_CM_DEFLATE)
      return refuse(Code::unsupported_format,
                    "the zip is packed by method " + std::to_string(about.comp_method), path_,
                    "pack it with deflate, which every program can");
    if (about.size > small_entry && about.size / model_zip_limits.ratio > about.comp_size)
      return refuse(Code::too_large,
                    "an entry of the zip unpacks to more than " + std::to_string(model_zip_limits.ratio) +
                        " times its size",
                    path_, "pack an ordinary file");
    const std::unique_ptr<zip_file_t, CloseZip> file(::zip_fopen_index(archive_, i, 0));
    if (!file) return damaged("an entry of the zip is damaged", path_);
    std::uint64_t left = about.size;
    Cursor in([&](std::span<char> into) -> Result<std::size_t> {
      const zip_int64_t read = ::zip_fread(file.get(), into.data(), into.size());
      if (read < 0 || static_cast<std::uint64_t>(read) > left || (read == 0 && left > 0))
        return damaged("an entry has another size or checksum than the zip says", path_);
      left -= static_cast<std::uint64_t>(read);
      return static_cast<std::size_t>(read);
    });
    VACUFORM_CHECK(file_of(in));
    VACUFORM_CHECK(in.skip(all_bytes));  // to the checksum
    return {};
  }

  // Copies a file of the model; others are left out.
  Result<void> file_of(Cursor& in) {
    const std::string name = base_name(path_);
    // Folders, and what macOS adds to an archive.
    if (name.empty() || name.starts_with("._") || path_.starts_with("__MACOSX/")) return {};
    const std::string extension = extension_of(name);
    if (extension == "obj" || extension == "ply") {
      if (models_++ > 0)
        return refuse(Code::unusable_scan, "the zip holds more than one model", path_,
                      "pack one OBJ or one PLY");
      return extension == "obj" ? lines(ModelLines::Kind::obj, "model.obj", in) : points(in);
    }
    if (extension == "mtl") {
      if (libraries_++ > 0)
        return refuse(Code::unusable_scan, "the zip holds more than one MTL", path_,
                      "pack the one of the model");
      return lines(ModelLines::Kind::mtl, "model.mtl", in);
    }
    if (extension == "png" || extension == "jpg" || extension == "jpeg" ||
        (extension.empty() && name.starts_with("texture-")))  // the last is that of a written archive
      return image(name, in);
    other_[name] = kind_of_image({}, extension);
    return {};
  }

  Result<void> lines(ModelLines::Kind kind, const char* name, Cursor& in) {
    ModelLines model(kind, names_);
    VACUFORM_CHECK(zip_.begin(name));
    for (;;) {
      auto line = in.line(model_zip_limits.line);
      if (!line && line.error().code == Code::too_large)
        return refuse(Code::corrupt_file, "a line of the model is longer than a mebibyte", path_,
                      "export the model again");
      if (!line) return tl::make_unexpected(std::move(line.error()));
      if (line->empty()) return zip_.end();
      std::string text;
      VACUFORM_CHECK(model.take(line->substr(0, line->find_first_of("\r\n")), text));
      VACUFORM_CHECK(zip_.write(text));
    }
  }

  Result<void> points(Cursor& in) {
    VACUFORM_CHECK(zip_.begin("model.ply"));
    Copy out([&](std::string_view bytes) { return zip_.write(bytes); });
    const auto texture = [&](std::string_view path) -> Result<std::string> {
      VACUFORM_TRY(number, names_.texture(path, "the PLY"));
      return "texture-" + std::to_string(number);
    };
    VACUFORM_CHECK(ply(in, out, texture));
    VACUFORM_CHECK(out.end());
    return zip_.end();
  }

  Result<void> image(const std::string& name, Cursor& in) {
    VACUFORM_TRY(head, in.peek(image_head));
    if (!begins_png(head) && !begins_jpeg(head)) {
      other_[name] = kind_of_image(head, {});
      return {};
    }
    if (!there_.emplace(name).second)
      return refuse(Code::corrupt_file, "the zip holds two images of the same name", path_,
                    "give them other names");
    const bool is_png = begins_png(head);
    VACUFORM_CHECK(zip_.begin("texture-" + std::to_string(names_.texture_there(name))));
    Copy out([&](std::string_view bytes) { return zip_.write(bytes); });
    VACUFORM_CHECK(is_png ? png(in, out) : jpeg(in, out));
    VACUFORM_CHECK(out.end());
    return zip_.end();
  }

  // A library that defines no material of the model is that of another one.
  Result<void> check_materials() const {
    std::string used, defined;
    for (const auto& [name, material] : names_.materials()) {
      if (material.used && material.defined) return {};
      std::string& list = material.used ? used : defined;
      if (list.size() < 100) list.append(list.empty() ? "" : ", ").append(name.substr(0, 100));
    }
    if (used.empty() || defined.empty()) return {};
    return refuse(Code::unusable_scan,
                  "the MTL defines none of the materials that the model uses: it defines " + defined +
                      ", and the model uses " + used,
                  {}, "pack the MTL that belongs to the model, or name its materials alike");
  }

  Result<void> check_whole() const {
    if (models_ == 0)
      return refuse(Code::unusable_scan, "the zip holds no model", {},
                    "pack one OBJ or one PLY with its images");
    VACUFORM_CHECK(check_materials());
    for (const auto& [name, texture] : names_.textures()) {
      if (texture.path.empty() || there_.contains(name)) continue;
      const auto other = other_.find(name);
      if (other != other_.end())
        return refuse(Code::unsupported_format,
                      "the texture " + texture.path + " is " + std::string(other->second), {},
                      "export the model with PNG or JPEG textures");
      return refuse(Code::unusable_scan,
                    "the zip lacks the image " + texture.path + ", which the model names", {},
                    "pack it with the model");
    }
    return {};
  }

  zip_t* const archive_;
  NewZip zip_;
  ModelNames names_;
  std::string path_;  // of the entry
  int models_ = 0, libraries_ = 0;
  std::set<std::string> there_;                    // images that are kept
  std::map<std::string, std::string_view> other_;  // what is left out, and what it is as an image
};

}  // namespace

Result<void> zip(const ByteSource& file, Copy& out) {
  VACUFORM_TRY(size, file.size());
  VACUFORM_CHECK(check_count(file, size));
  Shown shown(file, size);
  zip_error_t error;
  ::zip_error_init(&error);
  zip_source_t* const source = ::zip_source_function_create(Shown::call, &shown, &error);
  const std::unique_ptr<zip_t, CloseZip> archive(
      source ? ::zip_open_from_source(source, ZIP_RDONLY | ZIP_CHECKCONS, &error) : nullptr);
  const std::string why = ::zip_error_strerror(&error);
  ::zip_error_fini(&error);
  if (!archive) {
    if (source) ::zip_source_free(source);
    if (shown.problem) return tl::make_unexpected(*std::move(shown.problem));
    return damaged("the zip cannot be opened: " + why);
  }
  auto copied = ModelZip(archive.get(), out).copy();
  if (!copied && shown.problem) return tl::make_unexpected(*std::move(shown.problem));
  return copied;
}

}  // namespace vacuform::redaction
