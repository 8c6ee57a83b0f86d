// The pieces that report.html is made of: text that is escaped everywhere, tables, and charts as inline SVG. Internal
// to worker/inspection.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/markup.hpp"

namespace vacuform::html {

struct Column {
  std::string title;
  bool number = false;  // set to the right, in figures of one width
};
// The first cell of a row is its heading. Cells are texts, escaped here. A row of one cell spans the whole width.
using Rows = std::vector<std::vector<std::string>>;
std::string table(std::string_view caption, const std::vector<Column>& columns, const Rows& rows);

// A table of two columns, without headings above.
std::string facts(std::string_view caption, const std::vector<std::pair<std::string, std::string>>& rows);

// Shares of the area by a figure, in even bins from `low`; `without` is drawn as a line over the bars of `with`.
// Without `without` there is one set of bars.
struct Histogram {
  std::string title, quantity;  // what the chart shows; what its axis means
  double low = 0, step = 1;
  std::vector<double> with, without;
  bool open_above = true;  // the last bin holds what lies above it too
};
std::string histogram(const Histogram& histogram);

// One row a coil, one bar for each way of printing it.
struct Bars {
  std::string title, quantity;
  bool signed_values = false;  // bars to both sides of 0
  struct Row {
    std::string name;
    std::optional<double> with, without;  // per cent
  };
  std::vector<Row> rows;
};
std::string bars(const Bars& bars);

// A square matrix as a picture: signed values by colour, full at `full`, blue below 0 and orange above. Cells name themselves.
struct Matrix {
  std::string title;
  std::vector<std::string> names;
  std::vector<std::vector<std::optional<double>>> values;  // nothing: no value, as on the diagonal
  double full = 1;
};
std::string matrix(const Matrix& matrix);

// The texts that identify the two ways of printing, with the colours and patterns of the charts.
std::string legend();

// The style of the whole page, light and dark, on screen and on paper.
std::string_view style();

}  // namespace vacuform::html
