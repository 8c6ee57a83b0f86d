#include "worker/scan/obj_colours.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "api/base/decimal.hpp"
#include "api/base/text.hpp"
#include "worker/scan/text_cursor.hpp"

namespace vacuform {

namespace {

constexpr float largest_obj_uv = 1e6f;
constexpr std::size_t most_notes = 4;

// Reads at most three numbers after an option and uses the first two; a missing one keeps its value.
void take_numbers(std::string_view& rest, Eigen::Vector2f& values) {
  for (int k = 0; k < 3; ++k) {
    std::string_view after = rest;
    double number = 0;
    if (!parse_number(take_word(after), number)) return;
    if (k < 2) values[k] = static_cast<float>(number);
    rest = after;
  }
}

bool plausible(const Eigen::Vector2f& uv) { return uv.cwiseAbs().maxCoeff() <= largest_obj_uv; }

}  // namespace

Result<void> ObjColours::read_library(const std::string& where) {
  colours_.materials.emplace_back();
  if (!files_) return {};
  TextCursor text(files_->library);
  std::string_view line;
  Laid* laid = nullptr;
  std::array<double, 3> kd{1, 1, 1};
  std::string keyword;
  while (text.next_line(line)) {
    const std::string at = where + ", MTL, line " + std::to_string(text.line_number());
    const auto word = take_word(line);
    if (equal_ignoring_case(word, "newmtl")) {
      if (laid) settle(*laid, kd, keyword);
      kd = {1, 1, 1};
      keyword.clear();
      laid = &named_[std::string(trimmed(line))];
      *laid = {.material = static_cast<int>(colours_.materials.size())};
      colours_.materials.emplace_back();
    } else if (equal_ignoring_case(word, "Kd") && laid) {
      keyword = word;
      for (double& value : kd)
        if (!parse_number(take_word(line), value) || !std::isfinite(value))
          return corrupt("Kd of the MTL does not have three numbers", at);
    } else if (equal_ignoring_case(word, "map_Kd") && laid) {
      VACUFORM_CHECK(lay_image(line, at, *laid));
    }
  }
  if (laid) settle(*laid, kd, keyword);
  return {};
}

void ObjColours::settle(Laid& laid, const std::array<double, 3>& kd, const std::string& keyword) {
  ScanMaterial& material = colours_.materials[laid.material];
  const auto list = [&] { return decimal(kd[0], 3) + " " + decimal(kd[1], 3) + " " + decimal(kd[2], 3); };
  if (!keyword.empty() && keyword != "Kd") laid.note = "The MTL has " + keyword + ", which is read as Kd";
  const bool black = kd[0] <= 0 && kd[1] <= 0 && kd[2] <= 0;
  if (material.image >= 0 && black) {
    laid.note =
        "Kd 0 0 0 of the MTL is ignored where a material has an image (map_Kd): the image alone is the "
        "colour";
    return;
  }
  for (int k = 0; k < 3; ++k)
    material.factor[k] = linear_from_srgb(static_cast<float>(kd[static_cast<std::size_t>(k)]));
  if (material.image >= 0 && material.factor != Eigen::Vector3f::Ones())
    laid.note = "The image of a material (map_Kd) is multiplied by Kd " + list() + " of the MTL";
}

Result<void> ObjColours::lay_image(std::string_view rest, const std::string& where, Laid& laid) {
  ScanMaterial& material = colours_.materials[laid.material];
  for (;;) {
    std::string_view after = rest;
    const auto option = take_word(after);
    if (option == "-o")
      take_numbers(after, laid.shift);
    else if (option == "-s")
      take_numbers(after, laid.scale);
    else if (option == "-clamp" && take_word(after) == "on")
      material.across = material.down = Wrap::clamp;
    else
      break;
    rest = after;
  }
  if (!plausible(laid.shift) || !plausible(laid.scale))
    return corrupt("an option of map_Kd is not a plausible number", where);
  VACUFORM_TRY(found, image(trimmed(rest), where));
  material.image = found;
  return {};
}

Result<int> ObjColours::image(std::string_view name, const std::string& where) {
  if (const auto known = images_.find(name); known != images_.end()) return known->second;
  const auto found = files_->images.find(name);
  if (found == files_->images.end())
    return fail(Code::unusable_scan, "the zip lacks an image that the model names", where,
                "pack it with the model");
  const int number = static_cast<int>(colours_.images.size());
  colours_.images.push_back({std::string(name), found->second});
  images_.emplace(name, number);
  return number;
}

void ObjColours::add_vertex(std::string_view rest, std::size_t index) {
  double rgb[3];
  for (double& x : rgb)
    if (!parse_number(take_word(rest), x) || !std::isfinite(x)) return;  // no colour, or a curve's weight
  vertex_.resize(index, Eigen::Vector3f(-1, -1, -1));
  vertex_.emplace_back(static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2]));
}

Result<void> ObjColours::add_uv(std::string_view rest, const std::string& where) {
  double u = 0, v = 0;
  if (!parse_number(take_word(rest), u)) return corrupt("a vt does not have a number", where);
  (void)parse_number(take_word(rest), v);  // optional: an image of one row needs no v
  if (uv_.size() >= 3 * scan_limits.triangles)
    return fail(Code::too_large, "the scan has too many texture coordinates", where,
                "reduce it (quadric decimation) to a few hundred thousand triangles");
  uv_.emplace_back(static_cast<float>(u), static_cast<float>(v));
  return {};
}

void ObjColours::use(std::string_view material) {
  using_ = -1;
  unknown_used_ = false;
  const auto found = named_.find(material);
  if (found == named_.end()) {
    unknown_used_ = files_ && !files_->library.empty();
    return;
  }
  using_ = static_cast<int>(laid_.size());
  laid_.push_back(found->second);
}

std::int64_t ObjColours::uv_of(std::string_view corner) const {
  const std::size_t slash = corner.find('/');
  if (slash == std::string_view::npos) return -1;
  const std::string_view after = corner.substr(slash + 1);
  std::int64_t index = 0;
  if (!parse_integer(after.substr(0, after.find('/')), index) || index == 0) return -1;
  return index < 0 ? static_cast<std::int64_t>(uv_.size()) + index : index - 1;
}

void ObjColours::add_triangle(const std::array<std::int64_t, 3>& uv) {
  triangles_.push_back({uv, using_});
  if (unknown_used_) ++unknown_triangles_;
}

// What is said of many materials alike is said once.
void ObjColours::note_use() {
  std::vector<char> used(laid_.size(), 0);
  for (const Corners& corners : triangles_)
    if (corners.laid >= 0) used[static_cast<std::size_t>(corners.laid)] = 1;
  for (std::size_t i = 0; i < laid_.size(); ++i)
    if (const std::string& note = laid_[i].note; used[i] && !note.empty() &&
                                                 std::ranges::find(notes_, note) == notes_.end() &&
                                                 notes_.size() < most_notes)
      notes_.push_back(note);
  if (unknown_triangles_ > 0)
    missing_.push_back(std::to_string(unknown_triangles_) + " of " + std::to_string(triangles_.size()) +
                       " triangles use materials that the MTL does not define, and are white");
}

int ObjColours::without_image(int material) {
  const auto [plain, is_new] = plain_.try_emplace(material, static_cast<int>(colours_.materials.size()));
  if (is_new) {
    ScanMaterial copy = colours_.materials[material];
    copy.image = -1;
    colours_.materials.push_back(copy);
  }
  return plain->second;
}

void ObjColours::take_vertex_colours(std::size_t vertices) {
  if (vertex_.empty()) return;
  vertex_.resize(vertices, Eigen::Vector3f(-1, -1, -1));
  float largest = 0;
  for (const auto& rgb : vertex_) largest = std::max(largest, rgb.maxCoeff());
  const float scale = largest > 1 ? 255.0f : 1.0f;
  for (auto& rgb : vertex_)
    rgb = rgb.minCoeff() < 0 ? Eigen::Vector3f(1, 1, 1)
                             : Eigen::Vector3f((rgb / scale).unaryExpr(&linear_from_srgb));
  colours_.vertex = std::move(vertex_);
}

Result<std::optional<ScanColours>> ObjColours::take(const TriangleMesh& mesh, const std::string& where) {
  take_vertex_colours(mesh.vertices.size());
  note_use();
  bool coloured = !colours_.vertex.empty();
  if (!colours_.images.empty()) colours_.uv.resize(triangles_.size());
  colours_.material.reserve(triangles_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const Corners& corners = triangles_[t];
    const Laid laid = corners.laid < 0 ? Laid{} : laid_[corners.laid];
    int material = laid.material;
    if (colours_.materials[material].image >= 0) {
      const bool whole = std::all_of(corners.uv.begin(), corners.uv.end(), [](auto uv) { return uv >= 0; });
      if (!whole) material = without_image(material);
      for (std::size_t k = 0; whole && k < 3; ++k) {
        if (corners.uv[k] >= static_cast<std::int64_t>(uv_.size()))
          return corrupt("a face names vt " + std::to_string(corners.uv[k] + 1) + ", but the file has " +
                             std::to_string(uv_.size()),
                         where);
        const Eigen::Vector2f uv = laid.scale.cwiseProduct(uv_[corners.uv[k]]) + laid.shift;
        colours_.uv[t][k] = {uv.x(), 1 - uv.y()};  // v counts from below
        if (!plausible(colours_.uv[t][k]))
          return corrupt("a texture coordinate is not a plausible number", where);
      }
    }
    const ScanMaterial& shown = colours_.materials[material];
    coloured = coloured || shown.image >= 0 || shown.factor != Eigen::Vector3f::Ones();
    colours_.material.push_back(material);
  }
  return coloured ? std::optional(std::move(colours_)) : std::nullopt;
}

}  // namespace vacuform
