// GLB (glTF 2.0): a head, a chunk of JSON, and a chunk of binary data in parts, the buffer views. The copy has the keys that
// belong to glTF, numbers, and the few texts that a reader of the geometry needs; of the binary data the parts that accessors
// and pictures use. Everything else is left out of the JSON and becomes zeros in the data, whose places stay.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "api/base/text.hpp"
#include "api/redaction/formats.hpp"

namespace vacuform::redaction {

namespace {

constexpr std::uint32_t json_mark = 0x4E4F534A, binary_mark = 0x004E4942;
constexpr std::size_t most_json = 16 << 20, most_views = 65'536, deepest = 64;

// The keys of glTF 2.0 and of the extensions that a reader of shape and colour may need.
constexpr std::array<std::string_view, 86> keys{"KHR_draco_mesh_compression",
                                                "KHR_materials_pbrSpecularGlossiness",
                                                "KHR_texture_transform",
                                                "KHR_texture_basisu",
                                                "EXT_texture_webp",
                                                "EXT_meshopt_compression",
                                                "EXT_mesh_gpu_instancing",
                                                "KHR_mesh_quantization",
                                                "KHR_materials_unlit",
                                                "KHR_materials_emissive_strength",
                                                "emissiveStrength",
                                                "accessors",
                                                "alphaCutoff",
                                                "alphaMode",
                                                "asset",
                                                "attributes",
                                                "baseColorFactor",
                                                "baseColorTexture",
                                                "buffer",
                                                "bufferView",
                                                "bufferViews",
                                                "buffers",
                                                "byteLength",
                                                "byteOffset",
                                                "byteStride",
                                                "children",
                                                "componentType",
                                                "count",
                                                "diffuseFactor",
                                                "diffuseTexture",
                                                "doubleSided",
                                                "emissiveFactor",
                                                "emissiveTexture",
                                                "extensions",
                                                "extensionsRequired",
                                                "extensionsUsed",
                                                "images",
                                                "index",
                                                "indices",
                                                "inverseBindMatrices",
                                                "joints",
                                                "magFilter",
                                                "material",
                                                "materials",
                                                "matrix",
                                                "max",
                                                "mesh",
                                                "meshes",
                                                "metallicFactor",
                                                "mimeType",
                                                "min",
                                                "minFilter",
                                                "minVersion",
                                                "mode",
                                                "nodes",
                                                "normalized",
                                                "offset",
                                                "pbrMetallicRoughness",
                                                "primitives",
                                                "rotation",
                                                "roughnessFactor",
                                                "sampler",
                                                "samplers",
                                                "scale",
                                                "scene",
                                                "scenes",
                                                "skeleton",
                                                "skin",
                                                "skins",
                                                "source",
                                                "sparse",
                                                "targets",
                                                "texCoord",
                                                "textures",
                                                "translation",
                                                "type",
                                                "uri",
                                                "values",
                                                "version",
                                                "weights",
                                                "wrapS",
                                                "wrapT",
                                                "target",
                                                "TRANSLATION",
                                                "ROTATION",
                                                "SCALE"};

constexpr std::array<std::string_view, 12> texts{"SCALAR", "VEC2",  "VEC3",      "VEC4",
                                                 "MAT2",   "MAT3",  "MAT4",      "OPAQUE",
                                                 "MASK",   "BLEND", "image/png", "image/jpeg"};
constexpr std::array<std::string_view, 3> makers{"KHR_", "EXT_", "MSFT_"};

bool all_of(std::string_view text, std::string_view letters) {
  return text.find_first_not_of(letters) == std::string_view::npos;
}

// POSITION, TEXCOORD_0 and the like.
bool is_attribute(std::string_view key) {
  constexpr std::array<std::string_view, 7> names{"POSITION", "NORMAL", "TANGENT", "TEXCOORD",
                                                  "COLOR",    "JOINTS", "WEIGHTS"};
  const std::size_t line = std::min(key.find('_'), key.size());
  return one_of(key.substr(0, line), names) && key.size() <= line + 4 &&
         all_of(key.substr(std::min(line + 1, key.size())), "0123456789");
}
bool is_known(std::string_view key) { return one_of(key, keys) || is_attribute(key); }

// What stays of a text.
std::string_view needed(std::string_view key, std::string_view text) {
  if (one_of(text, texts)) return text;
  if (key == "version" || key == "minVersion")
    return text.size() <= 8 && all_of(text, "0123456789.") ? text : "?";
  const auto by = [&](std::string_view maker) { return text.starts_with(maker); };
  if (key.starts_with("extensions") && std::any_of(makers.begin(), makers.end(), by))
    return text.substr(0, 64);
  return {};
}

// The known properties of the parts of the binary chunk.
struct View {
  std::uint64_t offset = 0, bytes = 0;
  bool picture = false, geometry = false;
};

// Writes the JSON again while it is read, and finds the views. Nothing of it is kept in memory.
class JsonCopy : public nlohmann::json_sax<nlohmann::json> {
 public:
  std::string text;
  std::vector<View> views;
  bool too_many_views = false;

  // Whether the text is one object. Bytes behind it, as of programs that fill the chunk with zeros, are left out.
  bool whole() const { return text.ends_with('}') && levels_.empty(); }

  bool null() override { return bare("null"); }
  bool boolean(bool value) override { return bare(value ? "true" : "false"); }
  bool number_integer(number_integer_t value) override { return bare(std::to_string(value)); }
  bool number_float(number_float_t, const std::string& written) override { return bare(written); }
  bool number_unsigned(number_unsigned_t value) override {
    if (dropped_ == 0) note(value);
    return bare(std::to_string(value)) && !too_many_views;
  }
  bool string(std::string& value) override {
    if (dropped_ > 0 || levels_.empty()) return bare("");
    return bare("\"" + std::string(needed(levels_.back().key, value)) + "\"");
  }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open('{'); }
  bool start_array(std::size_t) override { return open('['); }
  bool end_object() override { return close('}'); }
  bool end_array() override { return close(']'); }
  bool key(std::string& name) override {
    if (dropped_ > 0) return true;
    if (!is_known(name)) return drop_ = true;
    Level& level = levels_.back();
    text += level.items++ == 0 ? "\"" : ",\"";
    text.append(name).append("\":");
    level.key = name;
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) override {
    return false;
  }

 private:
  // One open object or array.
  struct Level {
    bool object = false;
    std::uint64_t items = 0;  // so far
    std::string key = {};     // the last one; of an array the one that it stands under
  };

  // Whether a value goes, because its key does.
  bool goes() { return dropped_ > 0 || std::exchange(drop_, false); }
  void separate() {
    if (!levels_.empty() && !levels_.back().object && levels_.back().items++ > 0) text += ',';
  }
  bool bare(const std::string& value) {
    if (goes()) return true;
    separate();
    text += value;
    return true;
  }
  bool open(char bracket) {
    if (goes()) return ++dropped_ > 0;
    if (levels_.size() == deepest) return false;
    separate();
    text += bracket;
    const std::string under = bracket == '[' && !levels_.empty() ? levels_.back().key : std::string();
    levels_.push_back({bracket == '{', 0, under});
    return true;
  }
  bool close(char bracket) {
    if (dropped_ > 0) return --dropped_ >= 0;
    text += bracket;
    levels_.pop_back();
    return true;
  }

  // Of {"images": [{"bufferView": 3}], "bufferViews": [{"byteOffset": 12, "byteLength": 34}]} and the like.
  void note(std::uint64_t number) {
    if (drop_ || levels_.size() < 3) return;
    const std::string &list = levels_[0].key, &what = levels_.back().key;
    if (list == "bufferViews" && levels_.size() == 3 && (what == "byteOffset" || what == "byteLength")) {
      if (View* view = view_of(levels_[1].items - 1))
        (what == "byteOffset" ? view->offset : view->bytes) = number;
    } else if (what == "bufferView") {
      if (View* view = view_of(number)) (list == "images" ? view->picture : view->geometry) = true;
    }
  }
  View* view_of(std::uint64_t index) {
    too_many_views |= index >= most_views;
    if (too_many_views) return nullptr;
    if (index >= views.size()) views.resize(index + 1);
    return &views[index];
  }

  std::vector<Level> levels_;
  bool drop_ = false;         // the value that comes
  std::int64_t dropped_ = 0;  // levels of a value that goes
};

std::uint64_t little_endian(std::string_view bytes) {
  std::uint64_t number = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) number = number << 8 | static_cast<unsigned char>(bytes[i]);
  return number;
}
std::string little_endian(std::uint64_t number) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(number >> shift & 0xFF);
  return bytes;
}

// A picture of so many bytes: its pixels, then zeros in place of what is left out. Other kinds become zeros.
Result<void> picture(Cursor& in, std::uint64_t bytes, Copy& out) {
  VACUFORM_TRY(head, in.peek(8));
  const bool is_png = begins_png(head), is_jpeg = begins_jpeg(head);
  std::uint64_t left = bytes;
  Cursor inside([&](std::span<char> into) -> Result<std::size_t> {
    VACUFORM_TRY(some, in.take(static_cast<std::size_t>(std::min<std::uint64_t>(left, into.size()))));
    left -= some.size();
    return some.copy(into.data(), some.size());
  });
  const std::uint64_t before = out.bytes();
  if (is_png) VACUFORM_CHECK(png(inside, out));
  if (is_jpeg) VACUFORM_CHECK(jpeg(inside, out));
  VACUFORM_CHECK(in.skip(left));
  return out.zeros(bytes - std::min(bytes, out.bytes() - before));
}

// The binary chunk, of which `bytes` are there.
Result<void> binary(Cursor& in, std::uint64_t bytes, std::vector<View> views, Copy& out) {
  std::stable_sort(views.begin(), views.end(), [](const View& a, const View& b) {
    return a.offset != b.offset ? a.offset < b.offset : a.geometry > b.geometry;
  });
  std::uint64_t at = 0;
  for (const View& view : views) {
    if (!view.geometry && !view.picture) continue;
    const std::uint64_t begin = std::max(at, view.offset);
    if (begin >= bytes || view.bytes <= begin - view.offset) continue;
    const std::uint64_t end =
        std::min(bytes, view.bytes < bytes - view.offset ? view.offset + view.bytes : bytes);
    VACUFORM_CHECK(in.skip(begin - at));
    VACUFORM_CHECK(out.zeros(begin - at));
    if (view.geometry) {
      VACUFORM_CHECK(out.from(in, end - begin));
    } else if (begin == view.offset) {
      VACUFORM_CHECK(picture(in, end - begin, out));
    } else {  // its beginning is a part of another view
      VACUFORM_CHECK(in.skip(end - begin));
      VACUFORM_CHECK(out.zeros(end - begin));
    }
    at = end;
  }
  return out.zeros(bytes - at);
}

}  // namespace

// What is no whole GLB file of version 2 is copied as it is: its reader refuses it, and says what happened to its bytes.
Result<void> glb(Cursor& in, std::uint64_t size, Copy& out) {
  VACUFORM_TRY(begin, in.peek(20));
  const std::string head(begin);
  const std::uint64_t said = head.size() < 20 ? 0 : little_endian(head.substr(8, 4)),
                      length = head.size() < 20 ? 0 : little_endian(head.substr(12, 4));
  if (length == 0 || length + 20 > size || said > size || little_endian(head.substr(4, 4)) != 2 ||
      little_endian(head.substr(16)) != json_mark)
    return out.from(in, all_bytes);
  if (length > most_json)
    return fail(Code::too_large,
                "the JSON chunk of the GLB file has " + std::to_string(length) +
                    " bytes, above the limit of " + std::to_string(most_json >> 20) + " MiB",
                {}, "export the mesh alone, without scenery, or as STL");
  in.drop(head.size());
  VACUFORM_TRY(given, in.take(static_cast<std::size_t>(length)));
  JsonCopy json;
  (void)nlohmann::json::sax_parse(given, &json);
  if (json.too_many_views)
    return fail(Code::too_large, "the GLB file has more than " + std::to_string(most_views) + " buffer views",
                {}, "export the scan as STL");
  const bool whole_json = json.whole();
  json.text.append((4 - json.text.size() % 4) % 4, ' ');
  VACUFORM_CHECK(in.skip((4 - length % 4) % 4));
  VACUFORM_TRY(next, in.take(8));
  const std::string chunk(next);
  const bool has_binary = whole_json && chunk.size() == 8 && little_endian(chunk.substr(4)) == binary_mark;
  const std::uint64_t declared = has_binary ? little_endian(chunk.substr(0, 4)) : 0,
                      before = 28 + length + (4 - length % 4) % 4,
                      there = std::min(declared, size - std::min(size, before));
  const std::uint64_t whole = 20 + json.text.size() + (has_binary ? 8 + there : 0);
  VACUFORM_CHECK(out.write(head.substr(0, 8) + little_endian(whole) + little_endian(json.text.size()) +
                           head.substr(16)));
  VACUFORM_CHECK(out.write(json.text));
  if (!has_binary) return {};
  VACUFORM_CHECK(out.write(chunk));
  return binary(in, there, std::move(json.views), out);
}

}  // namespace vacuform::redaction
