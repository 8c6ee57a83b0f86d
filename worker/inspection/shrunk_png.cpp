#include "worker/inspection/shrunk_png.hpp"

#include <algorithm>
#include <cmath>

#include "worker/png/png_reader.hpp"

namespace vacuform {

namespace {

// The part of [from, to) that lies in the cell [i, i + 1).
double share(double from, double to, int i) { return std::min(to, i + 1.0) - std::max<double>(from, i); }

// Where cell i of `count` cells over a length begins; the last one ends exactly at the length.
double start_of(int i, int count, int length) {
  return i == count ? length : i * (static_cast<double>(length) / count);
}

// Makes rows of `from` pixels narrower.
class Squeeze {
 public:
  Squeeze(int from, int to) {
    for (int x = 0; x < to; ++x) {
      const double left = start_of(x, to, from), right = start_of(x + 1, to, from);
      const int first = static_cast<int>(left), last = static_cast<int>(std::ceil(right)) - 1;
      cells_.push_back({first, last, share(left, right, first), share(left, right, last)});
    }
  }

  // A row of straight RGBA as the sums of its cells, RGB on white.
  void operator()(const std::uint8_t* rgba, std::vector<double>& rgb) const {
    double* out = rgb.data();
    for (const Cell& cell : cells_) {
      double sum[3] = {0, 0, 0};
      const auto add = [&](int i, double weight) {
        const std::uint8_t* p = rgba + 4 * static_cast<std::ptrdiff_t>(i);
        const double white = 255 - p[3], alpha = p[3] == 255 ? 1 : p[3] / 255.0;
        for (int k = 0; k < 3; ++k) sum[k] += weight * (white + alpha * p[k]);
      };
      add(cell.first, cell.of_first);
      for (int i = cell.first + 1; i < cell.last; ++i) add(i, 1);
      if (cell.last > cell.first) add(cell.last, cell.of_last);
      for (const double value : sum) *out++ = value;
    }
  }

 private:
  struct Cell {
    int first, last;           // pixels
    double of_first, of_last;  // the parts of them that lie in the cell
  };
  std::vector<Cell> cells_;
};

}  // namespace

std::vector<std::uint8_t> shrunk_png(const std::vector<std::uint8_t>& png, int width, int skipped,
                                     bool mirrored) {
  PngReader reader(png);
  if (png.size() < 24 || !reader.begin(PngReader::Rows::rgba8) || reader.passes() != 1) return {};
  // Width and height are at fixed places of the first chunk.
  const auto number = [&](std::size_t at) {
    return static_cast<int>(png[at] << 24 | png[at + 1] << 16 | png[at + 2] << 8 | png[at + 3]);
  };
  const int columns = number(16), shown = number(20) - skipped;
  if (shown <= 0) return {};
  width = std::min(width, columns);
  const int height = std::max(1, static_cast<int>(static_cast<std::int64_t>(shown) * width / columns));
  PngWriter writer(width, height, 3);
  const Squeeze squeeze(columns, width);
  std::vector<std::uint8_t> read(reader.row_bytes()), before, row(3 * static_cast<std::size_t>(width));
  std::vector<double> line(row.size()), sum(row.size(), 0);
  const double across = static_cast<double>(columns) / width;
  int y = 0;  // the row of the result that the next row of the file belongs to
  for (int j = -skipped; j < shown; ++j) {
    if (!reader.row(read.data())) return {};
    if (j < 0) continue;
    if (read != before) squeeze(read.data(), line), before = read;  // many rows of a print are bare
    while (y < height) {
      const double top = start_of(y, height, shown), bottom = start_of(y + 1, height, shown);
      const double weight = std::max(0.0, share(top, bottom, j));
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * line[i];
      if (bottom > j + 1) break;
      const double area = across * (bottom - top);
      for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x)
        for (std::size_t k = 0; k < 3; ++k) {
          const std::size_t to = mirrored ? static_cast<std::size_t>(width) - 1 - x : x;
          row[3 * to + k] = static_cast<std::uint8_t>(std::min(255.0, sum[3 * x + k] / area + 0.5));
        }
      writer.row(row.data());
      std::fill(sum.begin(), sum.end(), 0);
      ++y;
    }
  }
  return writer.finish();
}

}  // namespace vacuform
