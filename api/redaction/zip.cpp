#include <zlib.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "api/base/text.hpp"
#include "api/print_step.hpp"
#include "api/redaction/formats.hpp"
#include "api/redaction/gunzip.hpp"
#include "api/redaction/model_names.hpp"
#include "api/redaction/redaction.hpp"
#include "api/redaction/zip_entries.hpp"

namespace vacuform::redaction {

namespace {

constexpr std::uint32_t local_mark = 0x04034b50, central_mark = 0x02014b50, end_mark = 0x06054b50,
                        descriptor_mark = 0x08074b50;
constexpr std::uint32_t sizes_follow = 8, by_deflate = 8;
constexpr std::size_t image_head = 12, largest_block = 65535;
constexpr std::uint16_t first_day = 0x21;  // 1980-01-01: no clock and no time zone in the bytes

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
    if (out_.bytes() - start_ <= zip_limits.bytes) return {};
    return refuse_zip(Code::too_large, "the zip unpacks to more than 1 GiB", entry.name,
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

class ModelZip {
 public:
  explicit ModelZip(Copy& out) : zip_(out) {}

  // Copies a file of the model; others are left out.
  Result<void> take(const std::string& path, Cursor& in) {
    path_ = path;
    const std::string name = base_name(path_), extension = extension_of(name);
    if (extension == "obj" || extension == "ply") {
      if (models_++ > 0)
        return refuse_zip(Code::unusable_scan, "the zip holds more than one model", path_,
                          "pack one OBJ or one PLY");
      return extension == "obj" ? lines(ModelLines::Kind::obj, "model.obj", in) : points(in);
    }
    if (extension == "mtl") {
      if (libraries_++ > 0)
        return refuse_zip(Code::unusable_scan, "the zip holds more than one MTL", path_,
                          "pack the one of the model");
      return lines(ModelLines::Kind::mtl, "model.mtl", in);
    }
    if (extension == "png" || extension == "jpg" || extension == "jpeg" ||
        (extension.empty() && name.starts_with("texture-")))  // the last is that of a written archive
      return image(name, in);
    other_[name] = kind_of_image({}, extension);
    return {};
  }

  // Errors: unusable_scan, unsupported_format (what the model needs is missing).
  Result<void> end() {
    VACUFORM_CHECK(check_whole());
    return zip_.directory();
  }

 private:
  Result<void> lines(ModelLines::Kind kind, const char* name, Cursor& in) {
    ModelLines model(kind, names_);
    VACUFORM_CHECK(zip_.begin(name));
    for (;;) {
      auto line = in.line(zip_limits.line);
      if (!line && line.error().code == Code::too_large)
        return refuse_zip(Code::corrupt_file, "a line of the model is longer than a mebibyte", path_,
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
      return refuse_zip(Code::corrupt_file, "the zip holds two images of the same name", path_,
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
    return refuse_zip(Code::unusable_scan,
                      "the MTL defines none of the materials that the model uses: it defines " + defined +
                          ", and the model uses " + used,
                      {}, "pack the MTL that belongs to the model, or name its materials alike");
  }

  Result<void> check_whole() const {
    if (models_ == 0)
      return refuse_zip(Code::unusable_scan, "the zip holds no model and no drawings", {},
                        "pack one OBJ or one PLY with its images, or an SVG for each layer of a print");
    VACUFORM_CHECK(check_materials());
    for (const auto& [name, texture] : names_.textures()) {
      if (texture.path.empty() || there_.contains(name)) continue;
      const auto other = other_.find(name);
      if (other != other_.end())
        return refuse_zip(Code::unsupported_format,
                          "the texture " + texture.path + " is " + std::string(other->second), {},
                          "export the model with PNG or JPEG textures");
      return refuse_zip(Code::unusable_scan,
                        "the zip lacks the image " + texture.path + ", which the model names", {},
                        "pack it with the model");
    }
    return {};
  }

  NewZip zip_;
  ModelNames names_;
  std::string path_;  // of the entry
  int models_ = 0, libraries_ = 0;
  std::set<std::string> there_;                    // images that are kept
  std::map<std::string, std::string_view> other_;  // what is left out, and what it is as an image
};

// Drawings of one page, each of a layer of the print that its name ends with.
class DrawingsZip {
 public:
  Result<void> take(const std::string& path, Cursor& in) {
    const std::string name = base_name(path), extension = extension_of(name);
    const std::string layer = layer_at_end(name.substr(0, name.size() - extension.size()));
    if (!one_of(extension, drawing_extensions)) {
      if (layer.empty()) return {};
      return refuse_zip(Code::unsupported_format, "a layer of the print is no SVG", path,
                        "save each layer as SVG");
    }
    if (layer.empty())
      return refuse_zip(Code::unusable_pattern, "the name of the drawing says no layer of the print", path,
                        "name each file after what it prints: conductor.svg, dielectric.svg, bridges.svg");
    std::string text;
    for (;;) {
      VACUFORM_TRY(some, in.some());
      if (some.empty()) break;
      text += some;
      in.drop(some.size());
      if (text.size() + bytes_ > most_svg)
        return refuse_zip(Code::too_large,
                          "the drawings have more than " + std::to_string(most_svg >> 20) + " MiB", path,
                          "simplify the drawings");
    }
    if (text.starts_with(gzip_mark)) {
      VACUFORM_TRY(content, gunzip(MemorySource(text), most_svg - bytes_));
      text = std::move(content);
    }
    bytes_ += text.size();
    drawings_.push_back({layer, path, std::move(text)});
    return {};
  }
  Result<void> end(Copy& out) { return svg_of_layers(drawings_, out); }

  static constexpr std::string_view drawing_extensions[] = {"svg", "svgz"};

 private:
  // The longest end of the name, in whole words, that names a layer: programs put the name of the project before it.
  static std::string layer_at_end(std::string_view name) {
    const auto letter = [](char c) { return (lower(c) >= 'a' && lower(c) <= 'z') || (c & 0x80) != 0; };
    for (std::size_t at = 0; at < name.size(); ++at)
      if (letter(name[at]) && (at == 0 || !letter(name[at - 1])))
        if (drawn_layer(name.substr(at))) return std::string(trimmed(name.substr(at), " ."));
    return {};
  }

  std::uint64_t bytes_ = 0;
  std::vector<LayerFile> drawings_;
};

}  // namespace

Result<void> zip(const ByteSource& file, Copy& out) {
  VACUFORM_TRY(entries, ZipEntries::open(file));
  constexpr std::string_view models[] = {"obj", "ply"};
  if (!entries.holds(models) && entries.holds(DrawingsZip::drawing_extensions)) {
    DrawingsZip drawings;
    VACUFORM_CHECK(
        entries.each([&](const std::string& path, Cursor& in) { return drawings.take(path, in); }));
    return drawings.end(out);
  }
  ModelZip model(out);
  VACUFORM_CHECK(entries.each([&](const std::string& path, Cursor& in) { return model.take(path, in); }));
  return model.end();
}

}  // namespace vacuform::redaction
