#include "worker/pattern/dxf_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "api/base/text.hpp"

namespace vacuform {

namespace {

constexpr std::size_t most_groups = 2'000'000;

// Takes lines off a text and counts them.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  bool at_end() const { return rest_.empty(); }
  std::size_t count() const { return count_; }
  std::string_view next() {
    const std::size_t end = rest_.find_first_of("\r\n");
    const std::string_view line = rest_.substr(0, end);
    ++count_;
    rest_.remove_prefix(std::min(line.size(), rest_.size()));
    if (rest_.starts_with("\r\n"))
      rest_.remove_prefix(2);
    else if (!rest_.empty())
      rest_.remove_prefix(1);
    return trimmed(line);
  }

 private:
  std::string_view rest_;
  std::size_t count_ = 0;
};

std::optional<int> group_code(std::string_view line) {
  int code = 0;
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), code);
  if (error != std::errc() || end != line.data() + line.size()) return std::nullopt;
  return code;
}

std::optional<double> line_weight(const DxfEntity& e) {
  const auto weight = e.number(370);  // 1/100 mm; negative: by layer, by block, default
  if (!weight || !(*weight > 0)) return std::nullopt;
  return *weight / 100;
}

// Sorts groups into entities and these into sections.
class Sections {
 public:
  void take(const DxfGroup& group) {
    if (group.code == 999) return;
    if (group.code == 0) {
      finish();
      open_ = DxfEntity{.type = group.value, .groups = {}, .vertices = {}};
      return;
    }
    if (section_ == "HEADER" && open_ && open_->type == "SECTION") {
      if (group.code == 9)
        variable_ = group.value;
      else if (variable_ == "$INSUNITS" && group.code == 70)
        file_.units = static_cast<int>(std::clamp(dxf_number(group.value).value_or(0), 0.0, 1000.0));
    }
    if (!open_) return;
    if (open_->type == "SECTION" && group.code == 2 && section_.empty()) section_ = group.value;
    open_->groups.push_back(group);
  }
  DxfFile end() {
    finish();
    return std::move(file_);
  }

 private:
  void finish() {
    if (!open_) return;
    DxfEntity e = std::move(*open_);
    open_.reset();
    if (e.type == "ENDSEC") return leave();
    if (e.type == "SECTION") return;
    if (section_ == "TABLES" && e.type == "LAYER") {
      const int flags = static_cast<int>(std::clamp(e.number_or(70, 0), 0.0, 1e6));
      file_.layers[e.text(2)] = {.drawn = e.number_or(62, 7) >= 0 && (flags & 1) == 0,
                                 .line = line_weight(e)};
    }
    if (section_ == "BLOCKS" && e.type == "BLOCK") {
      block_ = &file_.blocks[e.text(2)];
      *block_ = {.x = e.number_or(10, 0), .y = e.number_or(20, 0), .entities = {}};
      return;
    }
    if (e.type == "ENDBLK") {
      block_ = nullptr;
      polyline_ = false;
      return;
    }
    std::vector<DxfEntity>* const into = section_ == "ENTITIES"           ? &file_.entities
                                         : section_ == "BLOCKS" && block_ ? &block_->entities
                                                                          : nullptr;
    if (!into) return;
    if (e.type == "SEQEND") {
      polyline_ = false;
    } else if (e.type == "VERTEX" && polyline_ && !into->empty()) {
      into->back().vertices.push_back(std::move(e));
    } else if (e.number_or(67, 0) == 1) {
      ++file_.on_paper;
      polyline_ = false;
    } else {
      polyline_ = e.type == "POLYLINE";
      into->push_back(std::move(e));
    }
  }
  void leave() {
    section_ = {};
    variable_ = {};
    block_ = nullptr;
    polyline_ = false;
  }

  DxfFile file_;
  std::string_view section_, variable_;
  std::optional<DxfEntity> open_;
  DxfBlock* block_ = nullptr;
  bool polyline_ = false;
};

}  // namespace

std::optional<double> dxf_number(std::string_view value) {
  value = trimmed(value);
  if (value.starts_with('+')) value.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size() || !std::isfinite(number))
    return std::nullopt;
  return number;
}

std::string_view DxfEntity::text(int code) const {
  for (const DxfGroup& group : groups)
    if (group.code == code) return group.value;
  return {};
}
std::optional<double> DxfEntity::number(int code) const { return dxf_number(text(code)); }
std::vector<double> DxfEntity::numbers(int code) const {
  std::vector<double> out;
  for (const DxfGroup& group : groups)
    if (group.code == code)
      if (const auto value = dxf_number(group.value)) out.push_back(*value);
  return out;
}

bool begins_dxf(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  Lines lines(text.substr(0, 1 << 16));
  for (int comments = 0; comments < 100 && !lines.at_end(); ++comments) {
    const std::string_view code = lines.next(), value = lines.next();
    if (code == "0") return value == "SECTION";
    if (code != "999") return false;
  }
  return false;
}

Result<DxfFile> read_dxf_file(std::string_view text, const std::string& file_name) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  Lines lines(text);
  Sections sections;
  for (std::size_t groups = 0; !lines.at_end(); ++groups) {
    if (groups == most_groups)
      return fail(Code::too_large, "the DXF has more than 2 million groups", file_name,
                  "simplify the drawing");
    const std::string_view line = lines.next();
    if (line.empty() && lines.at_end()) break;
    const auto code = group_code(line);
    if (!code || lines.at_end())
      return fail(Code::corrupt_file,
                  (code ? "the DXF ends early, on line " : "the DXF has no group code on line ") +
                      std::to_string(lines.count()),
                  file_name, "export the drawing again as ASCII DXF, or as SVG");
    const std::string_view value = lines.next();
    if (*code == 0 && value == "EOF") return sections.end();
    sections.take({*code, value});
  }
  return fail(Code::corrupt_file, "the DXF ends early, without EOF", file_name, "export the drawing again");
}

}  // namespace vacuform
