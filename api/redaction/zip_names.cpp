#include "api/redaction/zip_names.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "api/base/text.hpp"
#include "api/redaction/model_names.hpp"

namespace vacuform {

namespace {

using namespace std::string_view_literals;

constexpr std::uint32_t local_mark = 0x04034b50, central_mark = 0x02014b50, end_mark = 0x06054b50,
                        descriptor_mark = 0x08074b50, in_zip64 = 0xffffffff;
constexpr unsigned encrypted = 1, sizes_follow = 8, strongly_encrypted = 0x40, masked = 0x2000;
constexpr unsigned by_storing = 0, by_deflate = 8;
constexpr std::size_t longest_path = 1024, image_head = 12, largest_block = 65535;
constexpr std::uint64_t small_entry = 1 << 20;  // below it, any ratio is fine
constexpr std::uint16_t first_day = 0x21;       // 1980-01-01: no clock and no time zone in the bytes

std::uint32_t number_at(std::string_view bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i)
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  return value;
}

void put(std::string& out, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i) & 0xff);
}

std::uint32_t crc_after(std::uint32_t crc, std::string_view bytes) {
  return static_cast<std::uint32_t>(
      ::crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string extension_of(std::string_view path) {
  const std::size_t dot = path.find_last_of("./");
  return dot == std::string_view::npos || path[dot] == '/' ? std::string() : lower(path.substr(dot + 1));
}

// What an image is that is not read, by its first bytes or by its name.
std::string_view kind_of_image(std::string_view head, std::string_view extension) {
  if ((head.starts_with("RIFF") && head.substr(0, image_head).ends_with("WEBP")) || extension == "webp")
    return "a WebP image";
  if (head.starts_with("\xabKTX") || extension == "ktx2" || extension == "ktx") return "a KTX image";
  if (extension == "tga") return "a TGA image";
  return "neither PNG nor JPEG";
}

// Unpacks deflated bytes.
class Inflater {
 public:
  Inflater() = default;
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() { close(); }

  void open() {
    close();
    stream_ = {};
    open_ = ::inflateInit2(&stream_, -MAX_WBITS) == Z_OK;
    ended_ = false;
  }
  bool ended() const { return ended_; }
  // Takes what it needs of `in`, and gives the next unpacked bytes. False: they are damaged.
  bool next(std::string_view& in, std::string_view& unpacked) {
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(in.data()));  // zlib reads it only
    stream_.avail_in = static_cast<uInt>(std::min<std::size_t>(in.size(), piece_.size()));
    const std::size_t given = stream_.avail_in;
    stream_.next_out = reinterpret_cast<Bytef*>(piece_.data());
    stream_.avail_out = static_cast<uInt>(piece_.size());
    const int state = open_ ? ::inflate(&stream_, Z_NO_FLUSH) : Z_MEM_ERROR;
    ended_ = state == Z_STREAM_END;
    in.remove_prefix(given - stream_.avail_in);
    unpacked = {piece_.data(), piece_.size() - stream_.avail_out};
    return state == Z_OK || state == Z_BUF_ERROR || ended_;
  }

 private:
  void close() {
    if (open_) ::inflateEnd(&stream_);
    open_ = false;
  }
  z_stream stream_{};
  bool open_ = false, ended_ = false;
  std::vector<char> piece_ = std::vector<char>(64 << 10);
};

// An entry of the new archive.
struct Written {
  std::string name;
  std::uint32_t crc = 0, offset = 0;
  std::uint64_t bytes = 0, packed = 0;
};

class ZipNames : public NameFilter::Format {
 public:
  void take(std::string_view in, std::string& out) override {
    while (!in.empty() && !problem_ && part_ != Part::rest) {
      if (part_ == Part::stored) {
        take_stored(in, out);
      } else if (part_ == Part::deflated) {
        take_deflated(in, out);
      } else {
        const std::size_t n = std::min(wanted_ - held_.size(), in.size());
        held_ += in.substr(0, n);
        in.remove_prefix(n);
      }
      while (!problem_ && in_records() && held_.size() == wanted_) record(out);
    }
  }
  void end(std::string& out) override {
    if (!problem_) check_whole();
    if (!problem_) directory(out);
  }
  bool can_go_on() const override { return false; }
  std::optional<Error> problem() const override { return problem_; }

 private:
  enum class Part { mark, local, name, stored, deflated, descriptor, sizes, central, central_texts, rest };
  enum class Use { none, obj, mtl, ply, image };

  bool in_records() const { return part_ != Part::stored && part_ != Part::deflated && part_ != Part::rest; }
  void expect(Part part, std::size_t bytes) {
    part_ = part;
    wanted_ = bytes;
    held_.clear();
  }
  void refuse(Code code, std::string what, std::string fix) {
    problem_ = Error{code, std::move(what), path_.empty() ? "the zip" : "the zip, " + path_, std::move(fix)};
  }
  void refuse_damaged(std::string what) { refuse(Code::corrupt_file, std::move(what), "pack it again"); }

  // A record is complete in held_.
  void record(std::string& out) {
    switch (part_) {
      case Part::mark: {
        const std::uint32_t mark = number_at(held_, 0, 4);
        path_.clear();
        if (mark == local_mark) return expect(Part::local, 26);
        if (mark == central_mark) return expect(Part::central, 42);
        if (mark == end_mark) return expect(Part::rest, 0);
        return refuse_damaged("the zip is damaged between its entries");
      }
      case Part::local:
        return begin_entry();
      case Part::name:
        return name_entry();
      case Part::descriptor:
        // With a mark or without: then these are the checksum.
        if (number_at(held_, 0, 4) == descriptor_mark) return expect(Part::sizes, 12);
        wanted_ = 12;
        part_ = Part::sizes;
        return;
      case Part::sizes:
        crc_ = number_at(held_, 0, 4);
        packed_size_ = number_at(held_, 4, 4);
        size_ = number_at(held_, 8, 4);
        return end_entry(out);
      case Part::central:
        ++listed_;
        if ((number_at(held_, 34, 4) >> 16 & 0170000) == 0120000 && number_at(held_, 0, 2) >> 8 == 3)
          return refuse(Code::corrupt_file, "the zip holds a link", "pack the files themselves");
        return expect(Part::central_texts,
                      number_at(held_, 24, 2) + number_at(held_, 26, 2) + number_at(held_, 28, 2));
      case Part::central_texts:
        return expect(Part::mark, 4);
      case Part::stored:
      case Part::deflated:
      case Part::rest:
        return;
    }
  }

  void begin_entry() {
    const unsigned flags = number_at(held_, 2, 2);
    method_ = number_at(held_, 4, 2);
    follow_ = (flags & sizes_follow) != 0;
    crc_ = number_at(held_, 10, 4);
    packed_size_ = number_at(held_, 14, 4);
    size_ = number_at(held_, 18, 4);
    name_bytes_ = number_at(held_, 22, 2);
    if (++entries_ > model_zip_limits.entries)
      return refuse(Code::too_large,
                    "the zip has more than " + std::to_string(model_zip_limits.entries) + " entries",
                    "pack the model alone");
    if (flags & (encrypted | strongly_encrypted | masked))
      return refuse(Code::unsupported_format, "the zip is encrypted", "pack it without a password");
    if (method_ != by_storing && method_ != by_deflate)
      return refuse(Code::unsupported_format, "the zip is packed by method " + std::to_string(method_),
                    "pack it with deflate, which every program can");
    if (packed_size_ == in_zip64 || size_ == in_zip64)
      return refuse(Code::unsupported_format, "the zip is one of 64 bits", "pack fewer or smaller files");
    if (name_bytes_ == 0 || name_bytes_ > longest_path)
      return refuse_damaged("an entry has no name, or one of more than 1024 bytes");
    expect(Part::name, name_bytes_ + number_at(held_, 24, 2));
  }

  void name_entry() {
    auto path = plain_path(std::string_view(held_).substr(0, name_bytes_), "the zip");
    if (!path) {
      problem_ = std::move(path.error());
      return;
    }
    path_ = *std::move(path);
    packed_ = unpacked_ = 0;
    unpacked_crc_ = 0;
    writing_ = false;
    image_.clear();
    line_.clear();
    last_ = '\0';
    use_ = use_of(path_);
    if (problem_) return;
    if (method_ == by_storing && follow_ && packed_size_ == 0 && !path_.ends_with('/'))
      return refuse_damaged("an entry is stored without its size");
    if (method_ == by_deflate) {
      inflater_.open();
      part_ = Part::deflated;
    } else {
      part_ = Part::stored;
    }
    held_.clear();
    if (method_ == by_storing && packed_size_ == 0) after_data();
  }

  Use use_of(const std::string& path) {
    const std::size_t slash = path.rfind('/');
    const std::string name = path.substr(slash == std::string::npos ? 0 : slash + 1);
    // Folders, and what macOS adds to an archive.
    if (name.empty() || name.starts_with("._") || path.starts_with("__MACOSX/")) return Use::none;
    const std::string extension = extension_of(name);
    if (extension == "obj" || extension == "ply") {
      if (models_++ > 0) {
        refuse(Code::unusable_scan, "the zip holds more than one model", "pack one OBJ or one PLY");
        return Use::none;
      }
      model_ = extension;
      lines_.emplace(extension == "obj" ? ModelLines::Kind::obj : ModelLines::Kind::ply_header, names_);
      return extension == "obj" ? Use::obj : Use::ply;
    }
    if (extension == "mtl") {
      if (libraries_++ > 0) {
        refuse(Code::unusable_scan, "the zip holds more than one MTL", "pack the one of the model");
        return Use::none;
      }
      lines_.emplace(ModelLines::Kind::mtl, names_);
      return Use::mtl;
    }
    if (extension == "png" || extension == "jpg" || extension == "jpeg" ||
        (extension.empty() && name.starts_with("texture-")))  // the last is that of a written archive
      return Use::image;
    other_[lower(name)] = kind_of_image({}, extension);
    return Use::none;
  }

  void take_stored(std::string_view& in, std::string& out) {
    const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(packed_size_ - packed_, in.size()));
    packed_ += n;
    unpacked(in.substr(0, n), out);
    in.remove_prefix(n);
    if (!problem_ && packed_ == packed_size_) finish_data(out);
  }

  void take_deflated(std::string_view& in, std::string& out) {
    const std::size_t before = in.size();
    std::string_view bytes;
    if (!inflater_.next(in, bytes)) return refuse_damaged("an entry of the zip is damaged");
    packed_ += before - in.size();
    if (!follow_ && packed_ > packed_size_) return refuse_damaged("an entry is longer than the zip says");
    unpacked(bytes, out);
    if (!problem_ && inflater_.ended()) finish_data(out);
  }

  // The next bytes of the file in the entry.
  void unpacked(std::string_view bytes, std::string& out) {
    unpacked_ += bytes.size();
    unpacked_crc_ = crc_after(unpacked_crc_, bytes);
    if (unpacked_ > small_entry && unpacked_ / model_zip_limits.ratio > packed_)
      return refuse(Code::too_large,
                    "an entry of the zip unpacks to more than " + std::to_string(model_zip_limits.ratio) +
                        " times its size",
                    "pack an ordinary file");
    switch (use_) {
      case Use::none:
        return;
      case Use::image:
        return image(bytes, out);
      case Use::ply:
        if (!lines_->ended()) lines(bytes, out);
        if (lines_->ended()) write(bytes, out);
        return;
      case Use::obj:
      case Use::mtl:
        return lines(bytes, out);
    }
  }

  // Takes whole lines; of a PLY up to the end of its header.
  void lines(std::string_view& bytes, std::string& out) {
    std::string text;
    while (!bytes.empty() && !problem_ && !(use_ == Use::ply && lines_->ended())) {
      if (last_ == '\r' && bytes[0] == '\n') {
        last_ = '\0';
        bytes.remove_prefix(1);
        continue;
      }
      const auto end = static_cast<std::size_t>(
          std::find_if(bytes.begin(), bytes.end(), [](char c) { return c == '\n' || c == '\r'; }) -
          bytes.begin());
      line_ += bytes.substr(0, end);
      if (line_.size() > model_zip_limits.line)
        return refuse(Code::corrupt_file, "a line of the model is longer than a mebibyte",
                      "export the model again");
      if (end == bytes.size()) {
        bytes = {};
        last_ = '\0';
        break;
      }
      last_ = bytes[end];
      bytes.remove_prefix(end + 1);
      line(text);
    }
    if (use_ == Use::ply && lines_->ended() && last_ == '\r' && bytes.starts_with('\n'))
      bytes.remove_prefix(1);
    write(text, out);
  }
  void line(std::string& text) {
    if (auto done = lines_->take(line_, text); !done && !problem_) problem_ = std::move(done.error());
    line_.clear();
  }

  void image(std::string_view bytes, std::string& out) {
    if (writing_) return write(pixels_->pass(bytes), out);
    image_ += bytes;
    if (image_.size() >= image_head) begin_image(out);
  }
  void begin_image(std::string& out) {
    const bool read = image_.starts_with("\x89PNG\r\n\x1a\n"sv) || image_.starts_with("\xff\xd8\xff"sv);
    const std::size_t slash = path_.rfind('/');
    const std::string name = lower(path_.substr(slash == std::string::npos ? 0 : slash + 1));
    if (!read) {
      other_[name] = kind_of_image(image_, {});
      use_ = Use::none;
      return;
    }
    if (!there_.emplace(name, true).second)
      return refuse(Code::corrupt_file, "the zip holds two images of the same name", "give them other names");
    pixels_.emplace("");
    begin_writing("texture-" + std::to_string(names_.texture_there(name)), out);
    write(pixels_->pass(image_), out);
  }

  void finish_data(std::string& out) {
    if (use_ == Use::image && !writing_) begin_image(out);
    if (problem_) return;
    if (use_ == Use::obj || use_ == Use::mtl || use_ == Use::ply) {
      std::string text;
      if (!line_.empty()) line(text);
      write(text, out);
    }
    if (use_ == Use::image) write(pixels_->finish(), out);
    if (problem_) return;
    after_data();
    if (part_ == Part::mark) end_entry(out);
  }
  void after_data() {
    if (follow_)
      expect(Part::descriptor, 4);
    else
      expect(Part::mark, 4);
  }

  // The sizes of the entry are known.
  void end_entry(std::string& out) {
    if (packed_ != packed_size_ || unpacked_ != size_ || unpacked_crc_ != crc_)
      return refuse_damaged("an entry has another size or checksum than the zip says");
    if (writing_) {
      write_block(true, out);
      put(out, descriptor_mark, 4);
      put(out, written_.back().crc, 4);
      put(out, static_cast<std::uint32_t>(written_.back().packed), 4);
      put(out, static_cast<std::uint32_t>(written_.back().bytes), 4);
      offset_ += 16;
    }
    writing_ = false;
    expect(Part::mark, 4);
  }

  // The new archive.

  static void common(std::string& out) {
    for (const std::uint32_t value : {20u, sizes_follow, by_deflate, 0u, std::uint32_t{first_day}})
      put(out, value, 2);
  }
  void begin_writing(std::string name, std::string& out) {
    std::string head;
    put(head, local_mark, 4);
    common(head);
    for (int i = 0; i < 3; ++i) put(head, 0, 4);  // checksum and sizes follow
    put(head, static_cast<std::uint32_t>(name.size()), 2);
    put(head, 0, 2);
    head += name;
    written_.push_back({std::move(name), 0, static_cast<std::uint32_t>(offset_), 0});
    offset_ += head.size();
    out += head;
    writing_ = true;
  }
  void write(std::string_view bytes, std::string& out) {
    if (bytes.empty()) return;
    if (!writing_) begin_writing(use_ == Use::mtl ? "model.mtl" : "model." + model_, out);
    if (problem_) return;
    written_.back().crc = crc_after(written_.back().crc, bytes);
    written_.back().bytes += bytes.size();
    while (!bytes.empty()) {
      const std::size_t n = std::min(largest_block - block_.size(), bytes.size());
      block_ += bytes.substr(0, n);
      bytes.remove_prefix(n);
      if (block_.size() == largest_block) write_block(false, out);
    }
    if (offset_ > model_zip_limits.bytes)
      return refuse(Code::too_large, "the zip unpacks to more than 1 GiB",
                    "reduce the scan (quadric decimation) to a few hundred thousand triangles");
  }
  // The bytes as they are, in a block of deflate (RFC 1951, 3.2.4): unlike a stored entry, it says where it ends.
  void write_block(bool last, std::string& out) {
    const auto size = static_cast<std::uint32_t>(block_.size());
    out += last ? '\1' : '\0';
    put(out, size, 2);
    put(out, ~size, 2);
    out += block_;
    written_.back().packed += block_.size() + 5;
    offset_ += block_.size() + 5;
    block_.clear();
  }

  void check_whole() {
    path_.clear();
    if (part_ != Part::rest) return refuse_damaged("the zip ends within its data");
    if (listed_ != entries_) return refuse_damaged("the zip lists other entries than it holds");
    if (models_ == 0)
      return refuse(Code::unusable_scan, "the zip holds no model", "pack one OBJ or one PLY with its images");
    for (const auto& [name, texture] : names_.textures()) {
      if (texture.path.empty() || there_.contains(name)) continue;
      const auto other = other_.find(name);
      if (other != other_.end())
        return refuse(Code::unsupported_format,
                      "the texture " + texture.path + " is " + std::string(other->second),
                      "export the model with PNG or JPEG textures");
      return refuse(Code::unusable_scan,
                    "the zip lacks the image " + texture.path + ", which the model names",
                    "pack it with the model");
    }
  }

  void directory(std::string& out) const {
    std::string list;
    for (const Written& entry : written_) {
      put(list, central_mark, 4);
      put(list, 3 << 8 | 20, 2);
      common(list);
      put(list, entry.crc, 4);
      put(list, static_cast<std::uint32_t>(entry.packed), 4);
      put(list, static_cast<std::uint32_t>(entry.bytes), 4);
      put(list, static_cast<std::uint32_t>(entry.name.size()), 2);
      for (int i = 0; i < 4; ++i) put(list, 0, 2);
      put(list, 0100644u << 16, 4);
      put(list, entry.offset, 4);
      list += entry.name;
    }
    const auto bytes = static_cast<std::uint32_t>(list.size());
    put(list, end_mark, 4);
    put(list, 0, 4);
    put(list, static_cast<std::uint32_t>(written_.size()), 2);
    put(list, static_cast<std::uint32_t>(written_.size()), 2);
    put(list, bytes, 4);
    put(list, static_cast<std::uint32_t>(offset_), 4);
    put(list, 0, 2);
    out += list;
  }

  Part part_ = Part::mark;
  std::size_t wanted_ = 4;
  std::string held_;
  std::optional<Error> problem_;
  // Of the entry.
  std::string path_;
  Use use_ = Use::none;
  unsigned method_ = 0;
  bool follow_ = false;
  std::size_t name_bytes_ = 0;
  std::uint32_t crc_ = 0, packed_size_ = 0, size_ = 0, unpacked_crc_ = 0;
  std::uint64_t packed_ = 0, unpacked_ = 0;
  Inflater inflater_;
  std::string line_, image_;  // unfinished; the first bytes of an image
  char last_ = '\0';          // the end of the last line, while no other byte followed
  std::optional<ModelLines> lines_;
  std::optional<NameFilter> pixels_;
  // Of the archive.
  ModelNames names_;
  std::uint64_t entries_ = 0, listed_ = 0;
  int models_ = 0, libraries_ = 0;
  std::string model_;                              // extension
  std::map<std::string, bool> there_;              // images that are kept
  std::map<std::string, std::string_view> other_;  // what is left out, and what it is as an image
  // Of the new archive.
  bool writing_ = false;
  std::vector<Written> written_;
  std::string block_;
  std::uint64_t offset_ = 0;
};

}  // namespace

std::unique_ptr<NameFilter::Format> zip_names() { return std::make_unique<ZipNames>(); }

}  // namespace vacuform
