#include "worker/studies/csv_table.hpp"

#include <algorithm>
#include <cmath>

#include "api/base/text.hpp"

namespace vacuform {

namespace {

constexpr std::string_view csv_blanks = " \t\n\v\f\r\"";

std::span<const std::uint8_t> without_mark(std::span<const std::uint8_t> bytes) {
  const bool marked = bytes.size() >= 3 && bytes[0] == 0xef && bytes[1] == 0xbb && bytes[2] == 0xbf;
  return marked ? bytes.subspan(3) : bytes;
}

}  // namespace

CsvTable::CsvTable(std::span<const std::uint8_t> bytes) : text_(without_mark(bytes)) {}

bool CsvTable::next(std::vector<std::string_view>& cells) {
  cells.clear();
  for (std::string_view line; text_.next_line(line);) {
    const std::string_view content = trimmed(line, csv_blanks);
    if (content.empty() || content.front() == '#') continue;
    line.remove_prefix(static_cast<std::size_t>(content.data() - line.data()));
    if (separator_ == 0) {
      const auto has = [&](char c) { return content.find(c) != std::string_view::npos; };
      separator_ = has(';') ? ';' : has('\t') ? '\t' : ',';
    }
    for (;;) {
      const auto end = std::min(line.find(separator_), line.size());
      cells.push_back(trimmed(line.substr(0, end), csv_blanks));
      if (end == line.size()) return true;
      line.remove_prefix(end + 1);
    }
  }
  return false;
}

bool CsvTable::number(std::string_view cell, double& value) const {
  std::string text(cell.substr(0, 64));
  if (separator_ == ';') std::replace(text.begin(), text.end(), ',', '.');
  return cell.size() <= 64 && parse_number(text, value) && std::isfinite(value);
}

std::string CsvTable::where(const std::string& file_name) const {
  return file_name + ", line " + std::to_string(text_.line_number());
}

std::string quoted_cell(std::string_view cell) {
  std::string text = "\"";
  for (const char c : cell.substr(0, 24)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + "\"";
}

}  // namespace vacuform
