// Tables of numbers that people measured, as CSV: a header that names the columns, then a row a line.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "worker/scan/text_cursor.hpp"

namespace vacuform {

// Walks over the rows of an untrusted text. Blank lines and lines that begin with # are skipped. The separator is a
// semicolon, a tab or a comma, whichever the header has first in this order; with a semicolon a comma is a decimal
// point. Quotes around a cell and a byte order mark count as blanks.
class CsvTable {
 public:
  explicit CsvTable(std::span<const std::uint8_t> bytes);

  // The next line as cells, the header first; false at the end. The cells point into the bytes.
  bool next(std::vector<std::string_view>& cells);
  // A finite number of at most 64 characters.
  bool number(std::string_view cell, double& value) const;
  std::string where(const std::string& file_name) const;  // "grid.csv, line 3"

 private:
  TextCursor text_;
  char separator_ = 0;
};

// For messages: at most 24 characters, with ? for what is not printable ASCII.
std::string quoted_cell(std::string_view cell);

}  // namespace vacuform
