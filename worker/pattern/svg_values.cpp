#include "worker/pattern/svg_values.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "api/base/text.hpp"
#include "worker/pattern/colour_names.hpp"

namespace vacuform {

namespace {

using Eigen::Affine2d;
using Eigen::Vector2d;

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

// Takes a number off the front of `text`.
std::optional<double> take_number(std::string_view& text) {
  std::string_view digits = text;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  const std::size_t sign = digits.starts_with('-') && digits.size() == text.size() ? 1 : 0;
  const std::size_t point = digits.size() > sign && digits[sign] == '.' ? 1 : 0;
  // from_chars would take words such as "inf" as well.
  if (digits.size() <= sign + point || !is_digit(digits[sign + point])) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  text = std::string_view(end, static_cast<std::size_t>(digits.data() + digits.size() - end));
  return value;
}

std::optional<Colour> hex_colour(std::string_view digits) {
  std::array<int, 8> v{};
  if (digits.size() > v.size()) return std::nullopt;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    const char c = digits[i];
    if (is_digit(c))
      v[i] = c - '0';
    else if (c >= 'a' && c <= 'f')
      v[i] = c - 'a' + 10;
    else
      return std::nullopt;
  }
  const auto one = [&](std::size_t i) { return v[i] / 15.0; };
  const auto two = [&](std::size_t i) { return (16 * v[2 * i] + v[2 * i + 1]) / 255.0; };
  switch (digits.size()) {
    case 3:
      return Colour{one(0), one(1), one(2), 1};
    case 4:
      return Colour{one(0), one(1), one(2), one(3)};
    case 6:
      return Colour{two(0), two(1), two(2), 1};
    case 8:
      return Colour{two(0), two(1), two(2), two(3)};
    default:
      return std::nullopt;
  }
}

// CSS Color 3, 4.2.4.
Colour from_hsl(double hue, double saturation, double lightness) {
  const auto channel = [&](double n) {
    const double k = std::fmod(n + hue / 30, 12.0), a = saturation * std::min(lightness, 1 - lightness);
    return lightness - a * std::max(-1.0, std::min({k - 3, 9 - k, 1.0}));
  };
  return {channel(0), channel(8), channel(4), 1};
}

std::optional<Colour> function_colour(std::string_view text) {
  const auto open = text.find('(');
  if (open == std::string_view::npos || !text.ends_with(')')) return std::nullopt;
  const std::string_view name = trimmed(text.substr(0, open));
  std::string_view rest = text.substr(open + 1, text.size() - open - 2);
  std::array<double, 4> v{0, 0, 0, 1};
  std::array<bool, 4> percent{};
  std::size_t count = 0;
  while (true) {
    while (!rest.empty() && (is_space(rest.front()) || rest.front() == ',' || rest.front() == '/'))
      rest.remove_prefix(1);
    if (rest.empty()) break;
    if (count == 4) return std::nullopt;
    const auto value = take_number(rest);
    if (!value) return std::nullopt;
    v[count] = *value;
    if ((percent[count] = rest.starts_with('%'))) rest.remove_prefix(1);
    if (rest.starts_with("deg")) rest.remove_prefix(3);
    ++count;
  }
  if (count < 3) return std::nullopt;
  const auto unit = [](double x) { return std::clamp(x, 0.0, 1.0); };
  Colour colour;
  if (name == "rgb" || name == "rgba") {
    const auto channel = [&](std::size_t i) { return unit(percent[i] ? v[i] / 100 : v[i] / 255); };
    colour = {channel(0), channel(1), channel(2), 1};
  } else if (name == "hsl" || name == "hsla") {
    if (!percent[1] || !percent[2]) return std::nullopt;
    const double hue = std::fmod(v[0], 360.0);
    colour = from_hsl(hue < 0 ? hue + 360 : hue, unit(v[1] / 100), unit(v[2] / 100));
  } else {
    return std::nullopt;
  }
  colour.a = unit(percent[3] ? v[3] / 100 : v[3]);
  return colour;
}

std::optional<Affine2d> one_transform(std::string_view name, const std::vector<double>& v) {
  Affine2d out = Affine2d::Identity();
  const std::size_t n = v.size();
  const auto radians = [](double degrees) { return degrees * M_PI / 180; };
  if (name == "matrix" && n == 6) {
    out.matrix() << v[0], v[2], v[4], v[1], v[3], v[5], 0, 0, 1;
  } else if (name == "translate" && (n == 1 || n == 2)) {
    out.translate(Vector2d(v[0], n == 2 ? v[1] : 0));
  } else if (name == "scale" && (n == 1 || n == 2)) {
    out.scale(Vector2d(v[0], n == 2 ? v[1] : v[0]));
  } else if (name == "rotate" && (n == 1 || n == 3)) {
    const Vector2d centre = n == 3 ? Vector2d(v[1], v[2]) : Vector2d(0, 0);
    out.translate(centre).rotate(radians(v[0])).translate(-centre);
  } else if (name == "skewX" && n == 1) {
    out.linear()(0, 1) = std::tan(radians(v[0]));
  } else if (name == "skewY" && n == 1) {
    out.linear()(1, 0) = std::tan(radians(v[0]));
  } else {
    return std::nullopt;
  }
  return out;
}

// Where the smaller side lies in the larger, from the "xMidYMax" of preserveAspectRatio.
std::optional<double> alignment(std::string_view word) {
  if (word == "Min") return 0;
  if (word == "Mid") return 0.5;
  if (word == "Max") return 1;
  return std::nullopt;
}

}  // namespace

void NumberCursor::skip() {
  while (!text_.empty() && (is_space(text_.front()) || text_.front() == ',')) text_.remove_prefix(1);
}

std::optional<double> NumberCursor::number() {
  skip();
  return take_number(text_);
}

std::optional<bool> NumberCursor::flag() {
  skip();
  if (text_.empty() || (text_.front() != '0' && text_.front() != '1')) return std::nullopt;
  const bool set = text_.front() == '1';
  text_.remove_prefix(1);
  return set;
}

char NumberCursor::letter() {
  skip();
  if (text_.empty() || !is_letter(text_.front())) return 0;
  const char c = text_.front();
  text_.remove_prefix(1);
  return c;
}

bool NumberCursor::at_end() {
  skip();
  return text_.empty();
}

std::optional<double> svg_length(std::string_view text, LengthOf of, const Vector2d& viewport) {
  text = trimmed(text);
  const auto value = take_number(text);
  if (!value) return std::nullopt;
  if (text.empty() || text == "px") return value;
  if (text == "mm") return *value * 96 / 25.4;
  if (text == "cm") return *value * 96 / 2.54;
  if (text == "in") return *value * 96;
  if (text == "pt") return *value * 96 / 72;
  if (text == "pc") return *value * 16;
  if (text != "%") return std::nullopt;
  switch (of) {
    case LengthOf::width:
      return *value / 100 * viewport.x();
    case LengthOf::height:
      return *value / 100 * viewport.y();
    default:
      return *value / 100 * viewport.norm() / std::sqrt(2.0);
  }
}

std::optional<double> svg_opacity(std::string_view text) {
  text = trimmed(text);
  const auto value = take_number(text);
  if (!value || (!text.empty() && text != "%")) return std::nullopt;
  return std::clamp(text.empty() ? *value : *value / 100, 0.0, 1.0);
}

std::optional<Colour> svg_colour(std::string_view given) {
  const std::string value = lower(trimmed(given));
  const std::string_view text = value;
  if (text.starts_with('#')) return hex_colour(text.substr(1));
  if (text == "transparent") return Colour{0, 0, 0, 0};
  if (const auto rgb = named_colour(text))
    return Colour{(*rgb >> 16) / 255.0, (*rgb >> 8 & 255) / 255.0, (*rgb & 255) / 255.0, 1};
  return function_colour(text);
}

std::optional<std::vector<double>> svg_numbers(std::string_view text) {
  std::vector<double> out;
  NumberCursor cursor(text);
  while (!cursor.at_end()) {
    const auto value = cursor.number();
    if (!value) return std::nullopt;
    out.push_back(*value);
  }
  return out;
}

std::optional<Affine2d> svg_transform(std::string_view text) {
  Affine2d out = Affine2d::Identity();
  for (text = trimmed(text); !text.empty();) {
    const auto open = text.find('('), close = text.find(')');
    if (open == std::string_view::npos || close == std::string_view::npos || close < open)
      return std::nullopt;
    const auto values = svg_numbers(text.substr(open + 1, close - open - 1));
    if (!values) return std::nullopt;
    const auto one = one_transform(trimmed(text.substr(0, open)), *values);
    if (!one) return std::nullopt;
    out = out * *one;
    text.remove_prefix(close + 1);
    while (!text.empty() && (is_space(text.front()) || text.front() == ',')) text.remove_prefix(1);
  }
  if (!out.matrix().allFinite()) return std::nullopt;
  return out;
}

std::optional<Affine2d> svg_view(const std::vector<double>& box, std::string_view aspect_ratio,
                                 const Vector2d& size) {
  if (box.size() != 4 || !(box[2] > 0) || !(box[3] > 0) || !(size.minCoeff() > 0)) return std::nullopt;
  Vector2d scale(size.x() / box[2], size.y() / box[3]), place(0, 0);
  std::string_view words = trimmed(aspect_ratio.empty() ? "xMidYMid" : aspect_ratio);
  const auto space = words.find(' ');
  const std::string_view align = words.substr(0, space);
  const bool slice = space != std::string_view::npos && trimmed(words.substr(space)) == "slice";
  if (align != "none") {
    if (align.size() != 8 || align[0] != 'x' || align[4] != 'Y') return std::nullopt;
    const auto x = alignment(align.substr(1, 3)), y = alignment(align.substr(5, 3));
    if (!x || !y) return std::nullopt;
    scale.setConstant(slice ? scale.maxCoeff() : scale.minCoeff());
    place = Vector2d(*x * (size.x() - scale.x() * box[2]), *y * (size.y() - scale.y() * box[3]));
  }
  Affine2d out = Affine2d::Identity();
  out.translate(place).scale(scale).translate(Vector2d(-box[0], -box[1]));
  if (!out.matrix().allFinite()) return std::nullopt;
  return out;
}

}  // namespace vacuform
