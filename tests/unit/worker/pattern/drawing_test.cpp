#include "worker/pattern/drawing.hpp"

#include <cairo.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/unit/fixtures/drawing_files.hpp"
#include "tests/unit/fixtures/ring_files.hpp"
#include "worker/pattern/area.hpp"
#include "worker/pattern/curve.hpp"

namespace vacuform {
namespace {

using namespace drawing_files;
using Eigen::Vector2d;

struct Read {
  Pattern pattern;
  std::optional<Drawing> drawing;
  std::vector<Warning> warnings;
};
Read read(const Bytes& bytes, std::optional<double> width_mm = {}, std::optional<double> dpi = {}) {
  PatternSettings settings;
  settings.width_mm = width_mm;
  settings.dpi = dpi;
  auto pattern = Pattern::read(bytes, "drawing.svg", settings, 300);
  if (!pattern) throw std::runtime_error(pattern.error().text());
  std::vector<Warning> warnings;
  auto drawing = read_drawing(*pattern, warnings);
  return {std::move(*pattern), std::move(drawing), std::move(warnings)};
}
// 40 mm square, one user unit a millimetre, the origin in the middle.
std::string page(const std::string& body, const std::string& more = "") {
  return "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink' "
         "xmlns:inkscape='http://www.inkscape.org/namespaces/inkscape' width='40mm' height='40mm' "
         "viewBox='-20 -20 40 40' " +
         more + ">" + body + "</svg>";
}
Read read_page(const std::string& body, const std::string& more = "") {
  return read(bytes_of(page(body, more)));
}

struct Release {
  void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
  void operator()(cairo_t* c) const { cairo_destroy(c); }
};

// The drawing's ink drawn by cairo, one float a pixel of `pixel_mm`, rows from the top.
struct Picture {
  int width = 0, height = 0;
  std::vector<double> ink;
};
Picture draw(const Drawing& drawing, double pixel_mm) {
  Picture out;
  out.width = static_cast<int>(std::lround(drawing.size_mm.x() / pixel_mm));
  out.height = static_cast<int>(std::lround(drawing.size_mm.y() / pixel_mm));
  const std::unique_ptr<cairo_surface_t, Release> surface(
      cairo_image_surface_create(CAIRO_FORMAT_ARGB32, out.width, out.height));
  const std::unique_ptr<cairo_t, Release> held(cairo_create(surface.get()));
  cairo_t* cairo = held.get();
  cairo_translate(cairo, 0.5 * out.width, 0.5 * out.height);
  cairo_scale(cairo, 1 / pixel_mm, -1 / pixel_mm);
  cairo_set_tolerance(cairo, 0.02);
  for (const Element& element : drawing.elements)
    for (const Shape& shape : element.shapes) {
      for (const Curve& curve : shape.curves) {
        const auto& p = curve.points;
        cairo_move_to(cairo, p[0].x(), p[0].y());
        for (std::size_t i = 1; i + 2 < p.size(); i += 3)
          cairo_curve_to(cairo, p[i].x(), p[i].y(), p[i + 1].x(), p[i + 1].y(), p[i + 2].x(), p[i + 2].y());
        if (curve.closed) cairo_close_path(cairo);
      }
      if (shape.fill) {
        cairo_set_source_rgba(cairo, shape.fill->r, shape.fill->g, shape.fill->b, shape.fill->a);
        cairo_set_fill_rule(cairo, shape.even_odd ? CAIRO_FILL_RULE_EVEN_ODD : CAIRO_FILL_RULE_WINDING);
        cairo_fill_preserve(cairo);
      }
      if (shape.stroke) {
        const Stroke& s = *shape.stroke;
        cairo_set_source_rgba(cairo, s.colour.r, s.colour.g, s.colour.b, s.colour.a);
        cairo_set_line_width(cairo, s.width_mm);
        cairo_set_line_cap(cairo, static_cast<cairo_line_cap_t>(s.cap));
        cairo_set_line_join(cairo, static_cast<cairo_line_join_t>(s.join));
        cairo_set_miter_limit(cairo, s.miter_limit);
        cairo_set_dash(cairo, s.dashes_mm.data(), static_cast<int>(s.dashes_mm.size()), s.dash_offset_mm);
        cairo_save(cairo);
        const cairo_matrix_t pen{s.pen(0, 0), s.pen(1, 0), s.pen(0, 1), s.pen(1, 1), 0, 0};
        cairo_transform(cairo, &pen);
        cairo_stroke_preserve(cairo);
        cairo_restore(cairo);
      }
      cairo_new_path(cairo);
    }
  cairo_surface_flush(surface.get());
  const unsigned char* data = cairo_image_surface_get_data(surface.get());
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const unsigned char* p = data + y * cairo_image_surface_get_stride(surface.get()) + 4 * x;
      out.ink.push_back((p[3] - (0.2126 * p[2] + 0.7152 * p[1] + 0.0722 * p[0])) / 255);
    }
  return out;
}

// How much the drawing's ink and librsvg's picture of the same file differ, against the picture's ink.
double difference(const Read& x, double pixel = 0.1) {
  const Picture drawn = draw(*x.drawing, pixel);
  double differing = 0, inked = 0;
  for (int j = 0; j < drawn.height; ++j)
    for (int i = 0; i < drawn.width; ++i) {
      const Vector2d uv((i + 0.5 - 0.5 * drawn.width) * pixel, (0.5 * drawn.height - j - 0.5) * pixel);
      const double wanted = x.pattern.sample(uv, pixel).coverage();
      inked += wanted;
      differing += std::abs(wanted - drawn.ink[static_cast<std::size_t>(j * drawn.width + i)]);
    }
  return differing / inked;
}
// Edges alone differ by about this: two ways of smoothing them.
constexpr double smoothing = 0.04;

void expect_as_drawn(const std::string& body, const std::string& more = "") {
  const Read x = read_page(body, more);
  ASSERT_TRUE(x.drawing) << body << "\n" << (x.warnings.empty() ? "" : x.warnings[0].text);
  EXPECT_LT(difference(x), smoothing) << body;
}

TEST(Drawing, RingsAreWhatLibrsvgDraws) {
  for (const auto& [name, coils, width] :
       {std::tuple{"rings-7x40mm", 7, 3}, {"rings-19x40mm", 19, 3}, {"rings-19x60mm", 19, 5}}) {
    const Read x = read(ring_file(std::string(name) + ".svg"));
    ASSERT_TRUE(x.drawing) << name;
    EXPECT_LT(difference(x, 0.2), smoothing) << name;
    ASSERT_EQ(x.drawing->elements.size(), static_cast<std::size_t>(coils));
    EXPECT_EQ(x.drawing->elements[1].id, "coil-2");
    EXPECT_NEAR(x.drawing->elements.back().shapes[0].stroke->width_mm, width, 1e-6);
    EXPECT_TRUE(x.drawing->elements.back().shapes[0].curves[0].closed);
    if (coils == 7) {
      EXPECT_LT((x.drawing->elements[1].centre - Vector2d(-15.16, 26.2579)).norm(), 1e-6);
    }
  }
}

TEST(Drawing, EveryShapeIsWhatLibrsvgDraws) {
  for (const char* body :
       {"<circle cx='3' cy='-4' r='9'/>", "<ellipse cx='3' cy='4' rx='12' ry='5' transform='rotate(30)'/>",
        "<rect x='-15' y='-10' width='25' height='12'/>",
        "<rect x='-15' y='-10' width='25' height='12' rx='4' fill='none' stroke='#000' stroke-width='1'/>",
        "<rect x='-15' y='-10' width='25' height='12' rx='40' ry='2'/>",
        "<line x1='-12' y1='3' x2='14' y2='-8' stroke='#000' stroke-width='2'/>",
        "<polyline points='-15,-5 0,10 4-8,12.5.5' fill='none' stroke='#000' stroke-width='1.5'/>",
        "<polygon points='-15,-5 0,10 4,-8' stroke='#000' stroke-width='1.5' fill='#888'/>",
        "<path d='M-15-15h10v8l5,5c2-6 8 0 9-4s4,10-6,9q-4 8-8 2t-9 3zm22 3 5 1v6z'/>",
        "<path d='M-12,0a12 8 30 1 0 24,0A6,6 0 01 5,-9a3 3 0 0020 5' fill='none' stroke='#000'/>",
        "<path d='M-10 0 A 1 1 0 0 1 10 0' fill='none' stroke='#000' stroke-width='2'/>",
        "<path d='M-10-10 L10-10 10 10 L nonsense 3 3' fill='none' stroke='#000' stroke-width='2'/>"})
    expect_as_drawn(body);
}

TEST(Drawing, EveryStrokeIsWhatLibrsvgDraws) {
  const std::string zigzag = "<path d='M-15,8 L-9,-9 L-6,9 L5,-9 L12,6 L14,-2' fill='none' stroke='#000' ";
  for (const char* more :
       {"stroke-width='3' stroke-linejoin='round' stroke-linecap='round'",
        "stroke-width='3' stroke-linejoin='bevel' stroke-linecap='square'",
        "stroke-width='3' stroke-miterlimit='1.5'", "stroke-width='2' stroke-miterlimit='20'",
        "stroke-width='2' stroke-dasharray='5 2 1' stroke-dashoffset='3'",
        "stroke-width='10%' stroke-opacity='0.5'", "stroke-width='2' stroke-dasharray='5 -2'",
        "style='stroke-width:2px;stroke-dasharray:4,2,1,1' transform='scale(-0.8 0.8) rotate(10)'"})
    expect_as_drawn(zigzag + more + "/>");
}

// A transform that stretches more one way than the other stretches the pen too: caps become oval, joins askew, dashes
// longer where the line runs along.
TEST(Drawing, StrokesUnderAStretchAreWhatLibrsvgDraws) {
  const std::string zigzag = "<path d='M-15,8 L-9,-9 L-6,9 C5,-9 2,2 12,6 L14,-2' fill='none' stroke='#000' ";
  for (const char* more :
       {"stroke-width='3' stroke-linejoin='round' stroke-linecap='round' transform='scale(1.2 0.4)'",
        "stroke-width='3' stroke-linecap='square' transform='skewX(30)'",
        "stroke-width='3' stroke-linejoin='bevel' transform='matrix(-0.3 0.5 1 0.4 2 3)'",
        "stroke-width='2' stroke-dasharray='5 2 1' transform='rotate(20) scale(0.5 1.3)'"}) {
    expect_as_drawn(zigzag + more + "/>");
    // And so are the areas that are printed.
    const Read x = read_page(zigzag + more + "/>");
    ASSERT_TRUE(x.drawing);
    Drawing areas{x.drawing->size_mm, {{.id = "", .centre = {0, 0}, .shapes = {}}}};
    for (const Shape& shape : x.drawing->elements[0].shapes) {
      Shape filled;
      filled.fill = shape.stroke->colour;
      for (const Ring& ring : stroke_area(shape.curves, *shape.stroke, 0.002)) {
        Curve curve{{ring[0]}, true};
        for (std::size_t k = 0; k < ring.size(); ++k) {
          const Vector2d &a = ring[k], &b = ring[(k + 1) % ring.size()];
          curve.points.insert(curve.points.end(), {a + (b - a) / 3, b - (b - a) / 3, b});
        }
        filled.curves.push_back(std::move(curve));
      }
      areas.elements[0].shapes.push_back(std::move(filled));
    }
    Read printed = read_page(zigzag + more + "/>");
    printed.drawing = std::move(areas);
    EXPECT_LT(difference(printed), smoothing) << more;
  }
}

TEST(Drawing, FillsFollowTheirRule) {
  const std::string star = "<path d='M0,-16 L9.4,13 L-15.2,-5 L15.2,-5 L-9.4,13 Z' ";
  expect_as_drawn(star + "fill-rule='evenodd'/>");
  expect_as_drawn(star + "fill='#06c' stroke='red'/>");
  expect_as_drawn(
      star + "fill='rgb(10%,20%,30%)' stroke='hsl(120,100%,25%)' paint-order='stroke' stroke-width='4'/>");
  EXPECT_TRUE(read_page(star + "fill-rule='evenodd'/>").drawing->elements[0].shapes[0].even_odd);
}

TEST(Drawing, StylesFollowTheCascade) {
  const std::string shape = "<g class='a'><path id='p' class='b a' d='M-12-9H12V9Z'/></g>";
  for (const char* sheet :
       {"path{fill:#888} .a{fill:none;stroke:#000;stroke-width:2}",
        ".b{stroke:#000} .a{fill:none;stroke:#777}", "#p{fill:#444} path.b{fill:#aaa} *{stroke:#000}",
        "path,g{stroke:black}.a{fill:none !important}",
        "/* .a{fill:none} */ .b.a{stroke:#333;stroke-width:3} .b{stroke-width:1}"})
    expect_as_drawn(std::string("<style>") + std::string(sheet) + "</style>" + shape);
  expect_as_drawn(
      "<g color='#555' fill='none' stroke='currentColor'><g stroke-width='3'>"
      "<path d='M-12-9H12V9Z' fill='inherit'/></g></g>");
  expect_as_drawn("<g fill='#999'><path d='M-12-9H12V9Z' fill='garbage'/></g>");
  expect_as_drawn(
      "<path d='M-12-9H12V9Z'/><g display='none'><rect width='9' height='9'/></g>"
      "<g visibility='hidden'><rect width='9' height='9'/><rect y='9' x='-9' width='4' height='4' "
      "visibility='visible'/></g>");
}

TEST(Drawing, UsesSymbolsAndInnerPagesAreFollowed) {
  expect_as_drawn(
      "<defs><g id='k'><circle r='3'/></g></defs><use href='#k' x='5'/>"
      "<use xlink:href='#k' x='-6' y='3' transform='scale(1.5)'/>");
  expect_as_drawn(
      "<symbol id='s' viewBox='0 0 10 10' preserveAspectRatio='xMinYMax meet'>"
      "<path d='M1 1H9V9Z'/></symbol><use href='#s' x='-15' y='-9' width='24' height='12'/>");
  expect_as_drawn(
      "<svg x='-10' y='-15' width='20' height='10' viewBox='0 0 8 8'><circle cx='4' cy='4' r='3.5'/></svg>");
  expect_as_drawn("<switch><foreignObject requiredExtensions='x'/><g><circle r='5'/></g></switch>");
}

TEST(Drawing, ThePageIsWhatLibrsvgDraws) {
  const std::string body = "<path d='M2 2H30V25Z' stroke='#000' fill='none' stroke-width='2'/>";
  for (const char* head :
       {"width='40mm' height='30mm' viewBox='0 0 40 40'", "width='151' height='113' viewBox='-4 0 40 30'",
        "width='151' height='113'", "width='4cm' viewBox='0 0 40 30'",
        "width='40mm' height='30mm' viewBox='0 0 40 40' preserveAspectRatio='xMaxYMin slice'",
        "width='40mm' height='30mm' viewBox='0 0 40 40' preserveAspectRatio='none'"}) {
    const std::string svg =
        std::string("<svg xmlns='http://www.w3.org/2000/svg' ") + head + ">" + body + "</svg>";
    for (const std::optional<double> width : {std::optional<double>(), std::optional<double>(60)}) {
      const Read x = read(bytes_of(svg), width, 96);
      ASSERT_TRUE(x.drawing) << head;
      EXPECT_LT(difference(x), smoothing) << head;
    }
  }
}

TEST(Drawing, SortsWhatIsDrawnIntoElements) {
  const Read x = read_page(
      "<g inkscape:groupmode='layer' id='layer1'>"
      "<g id='array'><g id='a'><circle r='4' cx='-8'/><circle r='2' cx='-8' fill='#fff'/></g>"
      "<path d='M-4 0H4' stroke='#000'/><g id='b'><rect x='5' y='-4' width='8' height='4'/></g></g>"
      "<circle id='c' r='3' cy='12'/><circle r='1'/></g>"
      "<rect id='paper' x='-20' y='-20' width='1' height='1' fill='#fff'/>"
      "<use href='#c' x='9'/>");
  ASSERT_TRUE(x.drawing);
  std::vector<std::string> ids;
  for (const Element& e : x.drawing->elements) ids.push_back(e.id);
  // The layer is small and has no coil; the copy is near it; the paper has no ink and no place in it.
  EXPECT_EQ(ids, (std::vector<std::string>{"a", ""}));
  EXPECT_EQ(x.drawing->elements[0].shapes.size(), 7u);
  EXPECT_LT((x.drawing->elements[0].centre - Vector2d(0.5, -5.5)).norm(), 1e-3);
  EXPECT_EQ(x.drawing->elements[1].shapes.size(), 1u);
}

TEST(Drawing, OpacityOfOneShapeIsItsColoursAndOfMoreIsRefused) {
  const std::string two = "<circle r='8'/><circle cx='6' r='8'/>";
  expect_as_drawn("<g opacity='0.5'><circle r='8' opacity='0.5'/></g>");
  expect_as_drawn(std::string("<g fill-opacity='0.5'>") + two + "</g>");
  EXPECT_FALSE(read_page(std::string("<g opacity='0.5'>") + two + "</g>").drawing);
  EXPECT_FALSE(read_page("<circle r='8' stroke='#000' opacity='0.5'/>").drawing);
}

TEST(Drawing, BecomesAPictureWithAReasonWhenItIsNotLines) {
  const std::string dot = "<circle r='8'/>";
  for (const auto& [body, what] : {std::pair<std::string, std::string>{"<text x='0' y='0'>A</text>", "text"},
                                   {"<rect width='9' height='9' fill='url(#g)'/>", "gradients"},
                                   {"<clipPath id='k'><rect width='3' height='3'/></clipPath><g "
                                    "clip-path='url(#k)'><rect width='9' height='9'/></g>",
                                    "clipping paths"},
                                   {"<g mask='url(#k)'><rect width='9' height='9'/></g>", "masks"},
                                   {"<g filter='url(#k)'><rect width='9' height='9'/></g>", "filters"},
                                   {"<path d='M0 0H9' stroke='#000' marker-end='url(#m)'/>", "markers"},
                                   {"<style>g > path {fill:red}</style>", "style sheet"},
                                   {"<svg width='4' height='4'><circle r='3'/></svg>", "cut off"}}) {
    const Read x = read_page(dot + body);
    EXPECT_FALSE(x.drawing) << body;
    ASSERT_EQ(x.warnings.size(), 1u) << body;
    EXPECT_EQ(x.warnings[0].code, "pattern-as-picture");
    EXPECT_NE(x.warnings[0].text.find(what), std::string::npos) << x.warnings[0].text;
  }
  EXPECT_FALSE(read(gray_png(10, 10, 1000, [](int, int) { return 0; })).drawing);
}

TEST(Drawing, AHostileOneIsRefusedSoon) {
  // Thirty doublings of one circle.
  std::string bomb = "<defs><circle id='u0' r='1'/>";
  for (int i = 1; i <= 30; ++i) {
    const std::string below = std::string("<use href='#u") + std::to_string(i - 1) + "'/>";
    bomb += std::string("<g id='u") + std::to_string(i) + "'>" + below + below + "</g>";
  }
  std::string classes;
  for (int i = 0; i < 20'000; ++i) classes += " a";
  std::string path = "M0 0";
  for (int i = 0; i < 250'000; ++i) path += "h1";
  std::string rules;
  for (int i = 0; i < 20'000; ++i) rules += "*{fill:red}";
  std::string dots;
  for (int i = 0; i < 20'000; ++i) dots += "<path d='M0 0h1v1'/>";
  std::string scribble = "M0 0";
  for (int i = 0; i < 5000; ++i)
    scribble +=
        std::string("L") + std::to_string(i * 7919 % 40 - 20) + " " + std::to_string(i * 104729 % 41 - 20);
  // librsvg itself is not asked about these.
  const Pattern page_of = read_page("<circle r='3'/>").pattern;
  for (const auto& [body, kept] :
       {std::pair<std::string, bool>{bomb + "</defs><use href='#u30'/>", false},
        {"<use id='x' href='#x'/>", false},
        {std::string("<style>") + rules + "</style>" + dots, false},
        {std::string("<g class='") + classes + "'>" + dots + "</g>", true},
        {std::string("<path d='") + path + "'/>", false},
        {"<path d='M0 0L1e300 1e300 -1e308 5'/>", false},
        {"<circle r='1e200' stroke='red' stroke-width='1e99'/>", false},
        {"<path d='M0 0Lnan inf'/><circle r='-3'/><path d='M0 0L1e999 5'/>", true},
        {"<rect width='nan' height='1'/>", false},
        {"<path d='M0 0h4' stroke='red' stroke-dasharray='1e-30'/>", false},
        {std::string("<path d='") + scribble + "' fill='none' stroke='red'/>", false}}) {
    std::vector<Warning> warnings;
    const auto drawing = read_drawing(page(body), page_of.size_mm(), warnings);
    EXPECT_EQ(drawing.has_value(), kept) << body.substr(0, 100);
    EXPECT_EQ(warnings.empty(), kept);
  }
}

TEST(Drawing, TheBoxIsAroundTheCurveItself) {
  const Curve arch{.points = {{0, 0}, {0, 4}, {6, 4}, {6, 0}}, .closed = false};
  const auto box = box_of(arch);
  EXPECT_LT((box.max() - Vector2d(6, 3)).norm(), 1e-12);
  EXPECT_LT((box.min() - Vector2d(0, 0)).norm(), 1e-12);
}

}  // namespace
}  // namespace vacuform
