#include "worker/sample/sample.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

namespace vacuform {

namespace {

constexpr double pi = std::numbers::pi;

// The head form in millimetres; heights from the widest level.
constexpr double half_breadth = 76;
constexpr double front = 98, back = 88;  // reach of the plain oval from the widest section
constexpr double brow = 5, occiput = 4;  // bosses at the widest level, part of the head's length
constexpr double vault = 88, neck = 95;  // heights above and below the widest level
constexpr double neck_breadth = 0.72, neck_front = 0.58, neck_back = 0.70;  // taper, against the widest level
constexpr double roundness = 2.5;      // exponent of the oval seen from above; 2 is an ellipse
constexpr double newborn_size = 0.61;  // of the adult's
constexpr double vertex_back = 8;      // the vertex lies this far behind the widest section

constexpr int around = 120, rings_above = 36, rings_below = 28;

// A coordinate of the superellipse, from the cosine or the sine of its parameter.
double super(double cosine_or_sine) {
  return std::copysign(std::pow(std::abs(cosine_or_sine), 2 / roundness), cosine_or_sine);
}

// A boss around the direction `towards`, strongest at the widest level.
double boss(double angle, double towards, double width, double z, double height) {
  const double turn = std::remainder(angle - towards, 2 * pi) / width;
  return std::exp(-turn * turn - (z / height) * (z / height));
}

// One point of the skin: the section at height z, `size` being its share of the widest one.
Eigen::Vector3d skin(double angle, double z, double size_x, double size_front, double size_back) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double rise = std::max(0.0, z / vault);
  const double x = half_breadth * size_x * super(c);
  double y = (s >= 0 ? front * size_front : back * size_back) * super(s);
  y += brow * boss(angle, pi / 2, 0.6, z, 30) - occiput * boss(angle, -pi / 2, 0.7, z, 35);
  // Cubic, so that the shift begins more gently than the vault narrows and makes no undercut.
  y -= vertex_back * rise * rise * rise;
  return {x, y, z + neck};
}

std::string fixed(double value) {
  std::array<char, 32> text;
  // Adding zero turns -0 into 0.
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value + 0.0, std::chars_format::fixed, 4).ptr;
  return {text.data(), end};
}

}  // namespace

TriangleMesh sample_head(HeadForm form) {
  TriangleMesh head;
  const auto add_ring = [&](double z, double size_x, double size_front, double size_back) {
    for (int i = 0; i < around; ++i)
      head.vertices.push_back(skin(2 * pi * i / around, z, size_x, size_front, size_back));
  };

  // Rings from below the vertex to the widest level, even in polar angle; then down the neck.
  for (int ring = 1; ring <= rings_above; ++ring) {
    const double polar = pi / 2 * ring / rings_above;
    const double size = std::sin(polar);
    add_ring(ring == rings_above ? 0 : vault * std::cos(polar), size, size, size);
  }
  for (int ring = 1; ring <= rings_below; ++ring) {
    const double down = static_cast<double>(ring) / rings_below;
    const double taper = (1 - std::cos(pi * down)) / 2;
    add_ring(-neck * down, 1 - (1 - neck_breadth) * taper, 1 - (1 - neck_front) * taper,
             1 - (1 - neck_back) * taper);
  }
  constexpr int rings = rings_above + rings_below;
  const int vertex = static_cast<int>(head.vertices.size());
  head.vertices.emplace_back(0, -vertex_back, vault + neck);
  head.vertices.emplace_back(0, 0, 0);

  const auto at = [](int ring, int i) { return ring * around + i % around; };
  for (int i = 0; i < around; ++i) head.triangles.push_back({vertex, at(0, i), at(0, i + 1)});
  for (int ring = 0; ring + 1 < rings; ++ring)
    for (int i = 0; i < around; ++i) {
      head.triangles.push_back({at(ring, i), at(ring + 1, i), at(ring + 1, i + 1)});
      head.triangles.push_back({at(ring, i), at(ring + 1, i + 1), at(ring, i + 1)});
    }
  for (int i = 0; i < around; ++i)
    head.triangles.push_back({vertex + 1, at(rings - 1, i + 1), at(rings - 1, i)});
  if (form == HeadForm::newborn)
    for (auto& v : head.vertices) v *= newborn_size;
  return head;
}

std::string sample_pattern() {
  constexpr double diameter = 45, stroke = 2.5, apart = 0.75802 * diameter;
  const double row = apart * std::sqrt(3.0) / 2;
  const double width = 4 * apart + diameter + stroke + 2, height = 4 * row + diameter + stroke + 2;
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + fixed(width) + "mm\" height=\"" +
                    fixed(height) + "mm\" viewBox=\"" + fixed(-width / 2) + " " + fixed(-height / 2) + " " +
                    fixed(width) + " " + fixed(height) + "\">\n  <title>19 coils of 45 mm, neighbours " +
                    fixed(apart) + " mm apart</title>\n";
  int coil = 0;
  for (int j = -2; j <= 2; ++j) {
    const int loops = 5 - std::abs(j);
    for (int i = 0; i < loops; ++i)
      svg += "  <g id=\"coil-" + std::to_string(++coil) + "\"><circle cx=\"" +
             fixed((i - (loops - 1) / 2.0) * apart) + "\" cy=\"" + fixed(j * row) + "\" r=\"" +
             fixed(diameter / 2) + "\" fill=\"none\" stroke=\"#000\" stroke-width=\"" + fixed(stroke) +
             "\"/></g>\n";
  }
  return svg + "</svg>\n";
}

}  // namespace vacuform
