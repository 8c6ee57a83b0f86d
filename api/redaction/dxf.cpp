// DXF in ASCII: pairs of lines, a group code and a value (Autodesk, DXF Reference). Numbers of shapes stay, and the words that
// say what they are. Blocks get numbers for names, and so do layers but those that are named after a step of printing
// (print_step.hpp); every other text becomes empty. Lines keep their places.
#include <charconv>
#include <map>
#include <optional>

#include "api/base/text.hpp"
#include "api/print_step.hpp"
#include "api/redaction/formats.hpp"

namespace vacuform::redaction {

namespace {

constexpr std::size_t most_names = 100'000;

constexpr std::string_view dxf_types[] = {
    "SECTION",  "ENDSEC",     "EOF",        "TABLE",     "ENDTAB", "LAYER",    "LTYPE",    "BLOCK",
    "ENDBLK",   "INSERT",     "LINE",       "ARC",       "CIRCLE", "ELLIPSE",  "POINT",    "SPLINE",
    "POLYLINE", "LWPOLYLINE", "VERTEX",     "SEQEND",    "SOLID",  "TRACE",    "HATCH",    "TEXT",
    "MTEXT",    "ATTRIB",     "ATTDEF",     "DIMENSION", "LEADER", "MLEADER",  "MLINE",    "3DFACE",
    "3DSOLID",  "BODY",       "REGION",     "SURFACE",   "MESH",   "RAY",      "XLINE",    "IMAGE",
    "VIEWPORT", "VPORT",      "WIPEOUT",    "TOLERANCE", "HELIX",  "UNDERLAY", "OLEFRAME", "OLE2FRAME",
    "SHAPE",    "ACAD_TABLE", "MULTILEADER"};
constexpr std::string_view dxf_sections[] = {"HEADER",   "CLASSES", "TABLES",         "BLOCKS",
                                             "ENTITIES", "OBJECTS", "THUMBNAILIMAGE", "ACDSDATA"};
constexpr std::string_view dxf_tables[] = {"LAYER", "LTYPE", "STYLE",    "VIEW",        "VPORT",
                                           "UCS",   "APPID", "DIMSTYLE", "BLOCK_RECORD"};
constexpr std::string_view dxf_variables[] = {"$ACADVER", "$INSUNITS", "$MEASUREMENT", "$LUNITS"};

// Layers and blocks by their numbers, in the order in which the file names them.
class DxfNames {
 public:
  explicit DxfNames(std::string kind) : kind_(std::move(kind)) {}
  Result<std::string> number_of(std::string_view name) {
    if (name.empty() || name == "0") return std::string(name);
    const auto [at, made] = names_.emplace(std::string(name), names_.size() + 1);
    if (names_.size() > most_names)
      return fail(Code::too_large,
                  "the DXF names more than " + std::to_string(most_names) + " layers or blocks", {},
                  "simplify the drawing");
    return kind_ + "-" + std::to_string(at->second);
  }

 private:
  std::string kind_;
  std::map<std::string, std::size_t> names_;
};

class DxfWriter {
 public:
  Result<std::string> kept(int code, std::string_view value) {
    if (code == 0) {
      if (value == "ENDSEC" || value == "EOF") section_ = {};
      type_ = one_of(value, dxf_types) ? std::string(value) : "UNKNOWN";
      variable_.clear();
      return type_;
    }
    if (type_ == "SECTION" && section_.empty()) {
      if (code != 2) return std::string();
      section_ = one_of(value, dxf_sections) ? std::string(value) : "UNKNOWN";
      return section_;
    }
    if (section_ == "HEADER") return variable(code, value);
    if (section_ != "TABLES" && section_ != "BLOCKS" && section_ != "ENTITIES") return std::string();
    if (code == 8) return layer(value);
    if (code == 2) {
      if (type_ == "LAYER") return layer(value);
      if (type_ == "BLOCK" || type_ == "INSERT") return block(value);
      if (type_ == "TABLE" && one_of(value, dxf_tables)) return std::string(value);
      return std::string();
    }
    if (code == 3 && type_ == "BLOCK") return block(value);
    const bool real = (code >= 10 && code <= 59) || (code >= 210 && code <= 239);
    const bool whole = (code >= 60 && code <= 79) || (code >= 90 && code <= 99) || code == 370;
    return number(real || whole ? value : std::string_view());
  }

 private:
  Result<std::string> variable(int code, std::string_view value) {
    if (code == 9) {
      variable_ = one_of(value, dxf_variables) ? std::string(value) : "$OTHER";
      return variable_;
    }
    if (variable_ == "$ACADVER") {
      const bool version = value.size() == 6 && value.starts_with("AC") && is_number(value.substr(2));
      return std::string(version ? value : std::string_view());
    }
    return number(variable_ == "$OTHER" ? std::string_view() : value);
  }
  Result<std::string> layer(std::string_view value) {
    if (drawn_layer(value)) return std::string(value);
    return layers_.number_of(value);
  }
  // The model and the sheets of paper are blocks with names that count.
  Result<std::string> block(std::string_view value) {
    const std::string small = lower(value);
    if (small == "*model_space" || small == "*paper_space") return small;
    return blocks_.number_of(value);
  }
  static Result<std::string> number(std::string_view value) {
    return std::string(is_number(value) ? value : std::string_view());
  }

  std::string section_, type_, variable_;
  DxfNames layers_{"layer"}, blocks_{"block"};
};

std::string_view end_of(std::string_view line) {
  return line.ends_with("\r\n")                         ? line.substr(line.size() - 2)
         : line.ends_with('\n') || line.ends_with('\r') ? line.substr(line.size() - 1)
                                                        : std::string_view();
}

}  // namespace

bool begins_dxf(std::string_view head) {
  const auto line = [&] {
    const std::string_view first = head.substr(0, head.find_first_of("\r\n"));
    head.remove_prefix(first.size());
    head.remove_prefix(std::min<std::size_t>(head.size(), head.starts_with("\r\n") ? 2 : 1));
    return trimmed(first);
  };
  const std::string_view code = line(), value = line();
  return code == "999" || (code == "0" && value == "SECTION");
}

Result<void> dxf(Cursor& in, Copy& out) {
  DxfWriter writer;
  for (;;) {
    VACUFORM_TRY(first, in.line());
    if (first.empty()) return {};
    const std::string code_line(first);
    const std::string_view text = trimmed(code_line);
    int code = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), code);
    const bool good = !text.empty() && error == std::errc() && end == text.data() + text.size();
    VACUFORM_CHECK(out.write(good ? code_line : std::string("?").append(end_of(code_line))));
    if (!good) return {};  // nothing behind it can be read
    VACUFORM_TRY(second, in.line());
    if (second.empty()) return {};
    const std::string value_line(second);
    VACUFORM_TRY(kept,
                 code == 999 ? Result<std::string>(std::string()) : writer.kept(code, trimmed(value_line)));
    VACUFORM_CHECK(out.write(kept.append(end_of(value_line))));
    if (code == 0 && trimmed(value_line) == "EOF") return {};
  }
}

}  // namespace vacuform::redaction
