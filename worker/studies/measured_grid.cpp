#include "worker/studies/measured_grid.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "api/base/decimal.hpp"
#include "worker/studies/csv_table.hpp"

namespace vacuform {

namespace {

constexpr std::size_t least_points = 10, most_points = 100'000;
constexpr double largest_mm = 1e5;  // of a measured coordinate
constexpr std::array<std::string_view, 5> column_names{"s", "t", "x", "y", "z"};
constexpr std::string_view example =
    "begin the file with the line \"s,t,x,y,z\" and give five numbers a line, in mm";

// The column of each of column_names in a header; -1 where it is missing.
std::array<int, 5> columns_of(const std::vector<std::string_view>& header) {
  std::array<int, 5> columns;
  columns.fill(-1);
  for (std::size_t i = 0; i < header.size(); ++i) {
    std::string name(header[i].substr(0, 16));
    for (char& c : name) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    if (name.ends_with("_mm")) name.resize(name.size() - 3);
    for (std::size_t k = 0; k < column_names.size(); ++k)
      if (name == column_names[k]) columns[k] = static_cast<int>(i);
  }
  return columns;
}

bool on_one_line(const std::vector<MeasuredPoint3>& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += p.rest / static_cast<double>(points.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const auto& p : points) spread += (p.rest - mean) * (p.rest - mean).transpose();
  const Eigen::Vector2d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread / static_cast<double>(points.size()))
          .eigenvalues();
  return std::sqrt(std::max(0.0, axes[0])) < 5;  // mm across
}

}  // namespace

Result<std::vector<MeasuredPoint3>> read_measured_grid(std::span<const std::uint8_t> bytes,
                                                       const std::string& file_name,
                                                       const SheetSettings& sheet) {
  CsvTable table(bytes);
  const auto corrupt = [&](std::string what, std::string fix) {
    return fail(Code::corrupt_file, std::move(what), table.where(file_name), std::move(fix));
  };
  std::vector<MeasuredPoint3> points;
  std::array<int, 5> columns;
  bool has_header = false;
  for (std::vector<std::string_view> cells; table.next(cells);) {
    if (!std::exchange(has_header, true)) {
      columns = columns_of(cells);
      for (std::size_t k = 0; k < columns.size(); ++k)
        if (columns[k] < 0)
          return corrupt("the header has no column " + std::string(column_names[k]), std::string(example));
      continue;
    }
    std::array<double, 5> values{};
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const auto column = static_cast<std::size_t>(columns[k]);
      if (column >= cells.size())
        return corrupt(
            "only " + std::to_string(cells.size()) + " values, and none for " + std::string(column_names[k]),
            std::string(example));
      if (!table.number(cells[column], values[k]))
        return corrupt("not a number for " + std::string(column_names[k]) + ": " + quoted_cell(cells[column]),
                       std::string(example));
      if (std::abs(values[k]) > largest_mm)
        return corrupt(std::string(column_names[k]) + " is " + decimal(values[k], 0) + " mm",
                       "give millimetres");
    }
    if (std::abs(values[0]) > sheet.width_mm / 2 || std::abs(values[1]) > sheet.height_mm / 2)
      return corrupt("the point s = " + decimal(values[0], 1) + ", t = " + decimal(values[1], 1) +
                         " lies off the sheet of " + short_decimal(sheet.width_mm) + " x " +
                         short_decimal(sheet.height_mm) + " mm",
                     "give s and t in mm from the sheet's centre, or the sheet's size (sheet.width_mm, "
                     "sheet.height_mm)");
    if (points.size() == most_points)
      return fail(Code::too_large, "more than 100,000 measured points", file_name, "give fewer");
    points.push_back({{values[0], values[1]}, {values[2], values[3], values[4]}});
  }
  if (points.size() < least_points)
    return fail(Code::corrupt_file, "only " + std::to_string(points.size()) + " measured points", file_name,
                points.empty() ? std::string(example) : "give at least ten, spread over the formed part");
  if (on_one_line(points))
    return fail(Code::corrupt_file, "the measured points lie on one line of the sheet", file_name,
                "spread them over the formed part");
  return points;
}

}  // namespace vacuform
