#include "worker/forming/heat/measured_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "api/base/decimal.hpp"
#include "api/base/text.hpp"
#include "worker/forming/heat/gray_png.hpp"
#include "worker/forming/heat/scattered.hpp"
#include "worker/scan/text_cursor.hpp"

namespace vacuform {

namespace {

constexpr std::uint64_t largest_file = 64u << 20;
constexpr std::size_t most_values = 4'000'000, most_points = 200'000;
constexpr double coldest = -50, hottest = 500;  // the possible range of a plastic sheet

// A text of separated values, line by line.
class Table {
 public:
  Table(std::span<const std::uint8_t> bytes, std::string name)
      : text_(without_mark(bytes)), name_(std::move(name)) {
    const auto has = [&](char c) { return std::find(bytes.begin(), bytes.end(), c) != bytes.end(); };
    separator_ = has(';') ? ';' : has(',') ? ',' : ' ';
  }

  // The next line that is neither empty nor a comment; false at the end.
  bool next() {
    while (text_.next_line(line_)) {
      line_ = trimmed(line_);
      if (!line_.empty() && line_.front() != '#') return true;
    }
    return false;
  }

  // Takes the next cell from the line; false when none is left.
  bool cell(std::string_view& cell) {
    if (line_.empty()) return false;
    if (separator_ == ' ') {
      cell = take_word(line_);
      line_ = trimmed(line_);
      return true;
    }
    const auto end = std::min(line_.find(separator_), line_.size());
    cell = trimmed(line_.substr(0, end));
    line_.remove_prefix(std::min(end + 1, line_.size()));
    return true;
  }

  bool number(std::string_view cell, double& value) const {
    std::array<char, 64> text;
    if (cell.empty() || cell.size() > text.size()) return false;
    const auto end = std::copy(cell.begin(), cell.end(), text.begin());
    if (separator_ == ';') std::replace(text.begin(), end, ',', '.');
    return parse_number({text.data(), cell.size()}, value) && std::isfinite(value);
  }

  std::string_view line() const { return line_; }
  std::string place() const { return name_ + ", line " + std::to_string(text_.line_number()); }
  tl::unexpected<Error> corrupt(const std::string& what, const std::string& fix) const {
    return fail(Code::corrupt_file, what, place(), fix);
  }
  Result<double> celsius(std::string_view cell) const {
    double value = 0;
    if (!number(cell, value))
      return corrupt("not a number: " + printable(cell), "give degrees Celsius, every place its value");
    if (value < coldest || value > hottest)
      return corrupt("a sheet is never at " + decimal(value, 0) + " C", "give degrees Celsius");
    return value;
  }

 private:
  static std::span<const std::uint8_t> without_mark(std::span<const std::uint8_t> bytes) {
    const bool marked = bytes.size() >= 3 && bytes[0] == 0xef && bytes[1] == 0xbb && bytes[2] == 0xbf;
    return bytes.subspan(marked ? 3 : 0);
  }
  static std::string printable(std::string_view cell) {
    std::string text = "\"";
    for (const char c : cell.substr(0, 24)) text += c >= ' ' && c <= '~' ? c : '?';
    return text + "\"";
  }

  TextCursor text_;
  std::string name_;
  std::string_view line_;
  char separator_;
};

Result<TemperatureField> read_rows(Table& table, const SheetSettings& sheet) {
  std::vector<double> from_top;
  std::size_t columns = 0, rows = 0;
  do {
    std::size_t count = 0;
    for (std::string_view cell; table.cell(cell); ++count) {
      VACUFORM_TRY(celsius, table.celsius(cell));
      from_top.push_back(celsius);
      if (from_top.size() > most_values)
        return fail(Code::too_large, "the table has more than 4 million temperatures", table.place(),
                    "give a coarser one");
    }
    if (rows == 0) columns = count;
    if (count != columns)
      return table.corrupt(
          "a row of " + std::to_string(count) + " values among rows of " + std::to_string(columns),
          "give every row of the sheet the same number of values");
    ++rows;
  } while (table.next());
  std::vector<double> celsius;  // from the bottom
  celsius.reserve(from_top.size());
  for (std::size_t row = rows; row-- > 0;)
    celsius.insert(celsius.end(), from_top.begin() + static_cast<std::ptrdiff_t>(row * columns),
                   from_top.begin() + static_cast<std::ptrdiff_t>((row + 1) * columns));
  return TemperatureField(sheet.width_mm, sheet.height_mm, static_cast<int>(columns), std::move(celsius),
                          TemperatureField::Samples::in_cells);
}

// The columns of s, t and celsius in a header; nothing when the line is not a header.
Result<std::array<std::size_t, 3>> read_header(Table& table) {
  constexpr std::array<std::string_view, 3> names{"s", "t", "celsius"};
  std::array<std::size_t, 3> columns{};
  std::array<bool, 3> found{};
  std::size_t column = 0;
  for (std::string_view cell; table.cell(cell); ++column) {
    std::string name;
    for (const char c : cell.substr(0, 16))
      if (c != '"') name += static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    if (name.ends_with("_mm")) name.resize(name.size() - 3);
    for (std::size_t k = 0; k < names.size(); ++k)
      if (name == names[k]) columns[k] = column, found[k] = true;
  }
  if (!found[0] || !found[1] || !found[2])
    return table.corrupt("a header without the columns s, t and celsius",
                         "begin with the line s,t,celsius or give rows of degrees Celsius alone");
  return columns;
}

Result<TemperatureField> read_points(Table& table, const SheetSettings& sheet) {
  VACUFORM_TRY(columns, read_header(table));
  std::vector<MeasuredPoint> points;
  while (table.next()) {
    std::array<std::string_view, 3> cells{};
    std::size_t column = 0;
    for (std::string_view cell; table.cell(cell); ++column)
      for (std::size_t k = 0; k < 3; ++k)
        if (columns[k] == column) cells[k] = cell;
    MeasuredPoint point;
    if (!table.number(cells[0], point.sheet.x()) || !table.number(cells[1], point.sheet.y()))
      return table.corrupt("a point without two numbers s and t", "give each line s, t and celsius");
    if (std::abs(point.sheet.x()) > 0.6 * sheet.width_mm || std::abs(point.sheet.y()) > 0.6 * sheet.height_mm)
      return table.corrupt("the point lies off the sheet of " + short_decimal(sheet.width_mm) + " x " +
                               short_decimal(sheet.height_mm) + " mm",
                           "give s and t in millimetres from the sheet's centre");
    VACUFORM_TRY(celsius, table.celsius(cells[2]));
    point.celsius = celsius;
    points.push_back(point);
    if (points.size() > most_points)
      return fail(Code::too_large, "there are more than 200,000 points", table.place(),
                  "give fewer, or rows that tile the sheet");
  }
  if (points.empty())
    return table.corrupt("there is no point after the header", "give each line s, t and celsius");
  return through_points(points, sheet.width_mm, sheet.height_mm);
}

Result<TemperatureField> read_text(const InputFile& file, const SheetSettings& sheet) {
  Table table(file.bytes, file.name);
  if (!table.next())
    return fail(Code::corrupt_file, "there is no temperature in the file", file.name,
                "give rows of degrees Celsius, or points under the header s,t,celsius");
  const bool header = std::any_of(table.line().begin(), table.line().end(),
                                  [](char c) { return c == 's' || c == 'S' || c == 't' || c == 'T'; });
  return header ? read_points(table, sheet) : read_rows(table, sheet);
}

Result<TemperatureField> read_picture(const InputFile& file, const SheetSettings& sheet,
                                      const HeatSettings& heat) {
  if (!heat.black_c || !heat.white_c)
    return fail(Code::bad_settings, "the temperatures of black and white in the picture are not given",
                "heat.black_c", "give heat.black_c and heat.white_c");
  VACUFORM_TRY(picture, read_gray_png(file.bytes, file.name));
  std::vector<double> celsius;
  celsius.reserve(picture.pixels.size());
  const auto width = static_cast<std::size_t>(picture.width);
  for (auto row = static_cast<std::size_t>(picture.height); row-- > 0;)
    for (std::size_t column = 0; column < width; ++column)
      celsius.push_back(*heat.black_c +
                        (*heat.white_c - *heat.black_c) * picture.pixels[row * width + column] / 65535.0);
  return TemperatureField(sheet.width_mm, sheet.height_mm, picture.width, std::move(celsius),
                          TemperatureField::Samples::in_cells);
}

}  // namespace

Result<TemperatureField> read_measured_field(const InputFile& file, const SheetSettings& sheet,
                                             const HeatSettings& heat) {
  if (file.bytes.size() > largest_file)
    return fail(Code::too_large, "the file of temperatures is larger than 64 MiB", file.name,
                "give a coarser one");
  return is_png(file.bytes) ? read_picture(file, sheet, heat) : read_text(file, sheet);
}

}  // namespace vacuform
