// The table of measured patches.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "api/base/decimal.hpp"
#include "api/base/text.hpp"
#include "worker/colour/texture.hpp"
#include "worker/studies/csv_table.hpp"
#include "worker/studies/ink_chart.hpp"

namespace vacuform {

namespace {

using Eigen::Vector3d;

constexpr const char* columns_fix =
    "begin the file with the line \"patch,L,a,b\", \"patch,R,G,B\" or \"patch,coverage\"";

enum class Measure { coverage, lab, rgb };
struct PatchColumns {
  Measure measure;
  std::size_t patch;
  std::vector<std::size_t> values;
};

std::optional<PatchColumns> patch_columns(const std::vector<std::string_view>& header) {
  const auto find = [&](std::string_view name) -> std::optional<std::size_t> {
    for (std::size_t i = 0; i < header.size(); ++i)
      if (equal_ignoring_case(header[i], name)) return i;
    return {};
  };
  const auto patch = find("patch");
  if (!patch) return {};
  const auto all = [&](Measure measure,
                       std::initializer_list<std::string_view> names) -> std::optional<PatchColumns> {
    PatchColumns out{measure, *patch, {}};
    for (const std::string_view name : names) {
      const auto column = find(name);
      if (!column) return {};
      out.values.push_back(*column);
    }
    return out;
  };
  if (auto found = all(Measure::coverage, {"coverage"})) return found;
  if (auto found = all(Measure::lab, {"L", "a", "b"})) return found;
  return all(Measure::rgb, {"R", "G", "B"});
}

// Linear light of sRGB, from CIE L*a*b* for D50 (ISO/CIE 11664-4), adapted to D65 by the matrix of Bradford. Colours
// outside of sRGB have components below 0.
Vector3d linear_of_lab(const Vector3d& lab) {
  const double fy = (lab[0] + 16) / 116, fx = fy + lab[1] / 500, fz = fy - lab[2] / 200;
  const auto back = [](double f) {
    constexpr double d = 6.0 / 29;
    return f > d ? f * f * f : 3 * d * d * (f - 4.0 / 29);
  };
  const Vector3d xyz(0.96422 * back(fx), back(fy), 0.82521 * back(fz));
  Eigen::Matrix3d m;
  m << 3.1338561, -1.6168667, -0.4906146, -0.9787684, 1.9161415, 0.0334540, 0.0719453, -0.2289914, 1.4052427;
  return m * xyz;
}

// Why the values cannot be a measured patch; empty if they can.
std::string nonsense(Measure measure, const Vector3d& v) {
  if (measure == Measure::coverage)
    return v[0] < -0.2 || v[0] > 1.2
               ? std::string("the coverage is ") + short_decimal(v[0]) + ", not from 0 to 1"
               : std::string();
  if (measure == Measure::rgb) {
    for (int k = 0; k < 3; ++k)
      if (v[k] < 0 || v[k] > 255)
        return std::string("a value is ") + short_decimal(v[k]) + ", not from 0 to 255";
    return "";
  }
  if (v[0] < 0 || v[0] > 105) return std::string("L is ") + short_decimal(v[0]) + ", not from 0 to 100";
  for (int k = 1; k < 3; ++k)
    if (std::abs(v[k]) > 150)
      return std::string("a or b is ") + short_decimal(v[k]) + ", not from -150 to 150";
  return "";
}

struct MeasuredRow {
  std::size_t patch;
  std::string where;
  Vector3d values;  // linear light, or the coverage alone
};

}  // namespace

Result<std::vector<MeasuredInk>> read_measured_patches(std::span<const std::uint8_t> csv,
                                                       const std::string& file_name,
                                                       const std::vector<InkPatch>& patches) {
  CsvTable table(csv);
  const auto refuse = [&](std::string what, std::string fix) {
    return fail(Code::corrupt_file, std::move(what), table.where(file_name), std::move(fix));
  };
  std::map<std::string, std::size_t, std::less<>> by_id;
  for (std::size_t i = 0; i < patches.size(); ++i) by_id.emplace(patches[i].id, i);
  std::optional<PatchColumns> columns;
  std::vector<MeasuredRow> rows;
  std::vector<bool> seen(patches.size(), false);
  for (std::vector<std::string_view> cells; table.next(cells);) {
    if (!columns) {
      columns = patch_columns(cells);
      if (!columns)
        return refuse("the header lacks the column patch, or the columns of a colour or a coverage",
                      columns_fix);
      continue;
    }
    const auto cell = [&](std::size_t column) {
      return column < cells.size() ? cells[column] : std::string_view();
    };
    if (std::all_of(columns->values.begin(), columns->values.end(),
                    [&](std::size_t c) { return cell(c).empty(); }))
      continue;
    const auto known = by_id.find(cell(columns->patch));
    if (known == by_id.end())
      return refuse(std::string("the chart has no patch ") + quoted_cell(cell(columns->patch)),
                    "give the chart.json of this sheet with --chart");
    if (seen[known->second])
      return refuse(std::string("patch ") + known->first + " is there twice",
                    "give the mean of its measurements");
    seen[known->second] = true;
    Vector3d values = Vector3d::Zero();
    for (std::size_t k = 0; k < columns->values.size(); ++k)
      if (!table.number(cell(columns->values[k]), values[static_cast<Eigen::Index>(k)]))
        return refuse(std::string("not a number for patch ") + known->first + ": " +
                          quoted_cell(cell(columns->values[k])),
                      columns_fix);
    if (const std::string why = nonsense(columns->measure, values); !why.empty())
      return refuse(std::string("patch ") + known->first + ": " + why, "check the units of the measurement");
    if (columns->measure == Measure::lab) values = linear_of_lab(values);
    if (columns->measure == Measure::rgb)
      for (double& v : values) v = static_cast<double>(linear_from_srgb(static_cast<float>(v / 255)));
    rows.push_back({known->second, table.where(file_name), values});
  }
  std::map<int, Vector3d> bare;
  Vector3d mean_bare = Vector3d::Zero();
  for (const MeasuredRow& row : rows)
    if (const InkPatch& patch = patches[row.patch]; patch.ink < 0)
      bare[patch.step] = row.values, mean_bare += row.values;
  if (!bare.empty()) mean_bare /= static_cast<double>(bare.size());
  const bool of_coverage = columns && columns->measure == Measure::coverage;
  std::vector<MeasuredInk> out;
  for (const MeasuredRow& row : rows) {
    const InkPatch& patch = patches[row.patch];
    if (patch.ink < 0) continue;
    if (of_coverage) {
      out.push_back({row.patch, row.values[0]});
      continue;
    }
    if (bare.empty())
      return fail(Code::corrupt_file, "no bare patch is measured", file_name,
                  "measure at least one of the patches W, which show the plastic without ink");
    const Vector3d& white = bare.contains(patch.step) ? bare[patch.step] : mean_bare;
    const double full = white[patch.ink];
    if (full < 0.1)
      return fail(Code::corrupt_file,
                  "the bare plastic is too dark to measure " +
                      std::string(ink_names[static_cast<std::size_t>(patch.ink)]) + " on it",
                  file_name, "measure the formed sheet over a white backing");
    const double shown = 1 - row.values[patch.ink] / full;
    if (shown < -0.2)
      return fail(Code::corrupt_file, std::string("patch ") + patch.id + " is brighter than bare plastic",
                  row.where, "check that the rows are those of this chart");
    out.push_back({row.patch, std::min(shown, 1.2)});
  }
  return out;
}

}  // namespace vacuform
