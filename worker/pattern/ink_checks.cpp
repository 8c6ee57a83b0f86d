#include "worker/pattern/ink_checks.hpp"

#include <algorithm>
#include <string>

#include "api/base/decimal.hpp"
#include "worker/pattern/curve.hpp"

namespace vacuform {

namespace {

constexpr double thinnest_mm = 0.05, darkest_share = 0.5;

Eigen::AlignedBox2d extent_of(const Shape& shape) {
  Eigen::AlignedBox2d box;
  for (const Curve& curve : shape.curves) box.extend(box_of(curve));
  return box;
}

bool inked(const Colour& c) { return c.a * (1 - (0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b)) > 0; }

// "a, b and 3 more"
std::string some_of(const std::vector<std::string>& ids) {
  constexpr std::size_t most_named = 20;
  std::string out;
  for (std::size_t i = 0; i < std::min(ids.size(), most_named); ++i) out += (i == 0 ? "" : ", ") + ids[i];
  if (ids.size() > most_named) out += " and " + std::to_string(ids.size() - most_named) + " more";
  return out;
}

void check_thin(const Drawing& lines, double scale, int print_dpi, std::vector<Warning>& warnings) {
  const double limit = std::max(thinnest_mm, 25.4 / print_dpi / 2);
  double least = limit;
  std::size_t count = 0;
  std::vector<std::string> ids;
  for (const Element& element : lines.elements)
    for (const Shape& shape : element.shapes) {
      if (!shape.stroke || !inked(shape.stroke->colour)) continue;
      const double width = shape.stroke->width_mm * scale;
      // The outline of a filled shape may be as thin as it likes.
      if (!(width < limit) || (shape.fill && inked(*shape.fill))) continue;
      ++count;
      least = std::min(least, width);
      const std::string id = element.id.empty() ? "lines of no element" : element.id;
      if (std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
    }
  if (count == 0) return;
  Warning warning{"lines-thin", std::to_string(count) + (count == 1 ? " line is" : " lines are") +
                                    " narrower than " + short_decimal(limit, 2) +
                                    " mm, the least that the print can hold; the narrowest has " +
                                    short_decimal(least, 2) + " mm."};
  warning.figure = Warning::Figure{least, "mm", limit};
  warning.place = some_of(ids);
  warnings.push_back(std::move(warning));
}

void check_page(const Drawing& lines, std::vector<Warning>& warnings) {
  std::vector<std::string> cut;
  for (const Element& element : lines.elements) {
    if (!element.loop) continue;
    Eigen::Vector2d most = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& p : element.loop->line) most = most.cwiseMax(p.cwiseAbs());
    most.array() += element.loop->width_mm / 2;
    constexpr double slack_mm = 0.01;
    if ((most - lines.size_mm / 2).maxCoeff() > slack_mm) cut.push_back(element.id);
  }
  if (cut.empty()) return;
  Warning warning{"coil-cut", std::to_string(cut.size()) + (cut.size() == 1 ? " coil lies" : " coils lie") +
                                  " beyond the edge of the drawing's page, wholly or in part, and what is "
                                  "beyond it is not printed."};
  warning.figure = Warning::Figure{static_cast<double>(cut.size()), "coils", 0.0};
  warning.place = some_of(cut);
  warnings.push_back(std::move(warning));
}

// How many coils lie over a filled shape of none, if it lies under all of them.
std::size_t coils_over_a_ground(const Drawing& lines) {
  Eigen::AlignedBox2d all;
  std::size_t count = 0;
  for (const Element& element : lines.elements) {
    if (!element.loop) continue;
    ++count;
    for (const Shape& shape : element.shapes) all.extend(extent_of(shape));
  }
  if (count < 2) return 0;
  for (const Element& element : lines.elements)
    for (const Shape& shape : element.shapes)
      if (!element.loop && shape.fill && inked(*shape.fill) &&
          shape.layer.value_or(DrawnLayer()).step == PrintStep::conductor && extent_of(shape).contains(all))
        return count;
  return 0;
}

}  // namespace

std::vector<Warning> check_ink(const Pattern& pattern, const std::optional<Drawing>& lines, double scale,
                               int print_dpi) {
  std::vector<Warning> warnings;
  if (lines) {
    check_page(*lines, warnings);
    check_thin(*lines, scale, print_dpi, warnings);
  }
  // The ink of several steps lies over each other, and resist covers what it likes.
  const double share = lines && lines->layered() ? 0 : pattern.ink_mm2() / pattern.size_mm().prod();
  const std::size_t over = lines ? coils_over_a_ground(*lines) : 0;
  if (share > darkest_share || over > 0) {
    std::string text = "The ink covers " + in_percent(pattern.ink_mm2() / pattern.size_mm().prod()) +
                       " of the drawing's page";
    if (over > 0)
      text += ", and a filled shape lies under all " + std::to_string(over) + " coils and joins them";
    Warning warning{"pattern-dark", text + "."};
    warning.figure = Warning::Figure{100 * share, "%", 100 * darkest_share};
    warning.place = "the drawing";
    warnings.push_back(std::move(warning));
  }
  return warnings;
}

}  // namespace vacuform
