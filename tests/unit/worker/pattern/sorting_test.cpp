// What is found in drawings as different programs and people write them: the same coils, whatever the ids and groups.
#include "worker/pattern/sorting.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>

#include "tests/unit/fixtures/drawing_files.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/pattern/drawn_loop.hpp"
#include "worker/pattern/ink_parts.hpp"

namespace vacuform {
namespace {

using namespace drawing_files;
using Eigen::Vector2d;

constexpr double page_mm = 200;

// One user unit a millimetre, the origin in the middle, y down.
Drawing drawing_of(const std::string& body) {
  const std::string svg =
      "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink' width='200mm' "
      "height='200mm' viewBox='-100 -100 200 200'>" +
      body + "</svg>";
  std::vector<Warning> warnings;
  auto drawing = read_drawing(svg, Vector2d(page_mm, page_mm), warnings);
  if (!drawing) throw std::runtime_error(warnings.empty() ? "not read" : warnings[0].text);
  return std::move(*drawing);
}

std::vector<const Element*> coils_of(const Drawing& drawing) {
  std::vector<const Element*> out;
  for (const Element& e : drawing.elements)
    if (e.loop) out.push_back(&e);
  return out;
}

std::string number(double x) { return std::to_string(x); }
std::string circle_at(const Vector2d& c, double r, const std::string& more = "") {
  return std::string("<circle cx='") + number(c.x()) + "' cy='" + number(c.y()) + "' r='" + number(r) + "' " +
         more + "/>";
}
const std::string line = "fill='none' stroke='#000' stroke-width='2.5'";

// Seven rings of 22 mm about a point off the middle, turned by an odd angle, 33 mm apart.
std::vector<Vector2d> seven() {
  std::vector<Vector2d> out{{4, -7}};
  for (int k = 0; k < 6; ++k)
    out.push_back(out[0] + 33 * Vector2d(std::cos(0.3 + k * M_PI / 3), std::sin(0.3 + k * M_PI / 3)));
  return out;
}

// An arc about c from `from` to `to`, degrees, as a path.
std::string arc(const Vector2d& c, double r, double from, double to) {
  const auto at = [&](double degrees) -> Vector2d {
    return c + r * Vector2d(std::cos(degrees * M_PI / 180), std::sin(degrees * M_PI / 180));
  };
  const Vector2d a = at(from), b = at(to);
  return std::string("M") + number(a.x()) + " " + number(a.y()) + "A" + number(r) + " " + number(r) + " 0 " +
         (to - from > 180 ? "1" : "0") + " 1 " + number(b.x()) + " " + number(b.y());
}

void expect_seven(const Drawing& drawing, const std::string& what, double within = 1e-6, double width = 2.5) {
  const auto coils = coils_of(drawing);
  ASSERT_EQ(coils.size(), 7u) << what;
  for (const Vector2d& c : seven()) {
    const auto found = std::find_if(coils.begin(), coils.end(), [&](const Element* e) {
      return (e->centre - Vector2d(c.x(), -c.y())).norm() < 0.3;
    });
    ASSERT_NE(found, coils.end()) << what;
    EXPECT_LT(((*found)->centre - Vector2d(c.x(), -c.y())).norm(), within) << what;
    EXPECT_NEAR(std::sqrt((*found)->loop->area_mm2 / M_PI), 22, 0.3) << what;
    EXPECT_NEAR((*found)->loop->width_mm, width, 0.1) << what;
  }
}

TEST(Sorting, TheSameCoilsWhateverTheProgram) {
  std::string bare, own_ids, groups, pads, labels_own, filled, united, tools;
  std::string compound = "<path id='coils' " + line + " d='", rings = "<path fill-rule='evenodd' d='";
  const auto centres = seven();
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const Vector2d& c = centres[i];
    const std::string n = std::to_string(i), one = circle_at(c, 22, line);
    bare += one;
    own_ids += circle_at(c, 22, line + " id='path" + n + "'");
    groups += "<g id='coil-" + n + "'>" + one + "</g>";
    const std::string pad = "<rect id='rect" + n + "' x='" + number(c.x() - 1.5) + "' y='" +
                            number(c.y() - 14) + "' width='3' height='6'/>";
    pads += own_ids.substr(own_ids.rfind("<circle")) + pad;
    labels_own += "<g id='coil-" + n + "'>" + one + "</g><g id='label-" + n + "'>" + pad + "</g>";
    filled += circle_at(c, 23.25, "fill='#000'") + circle_at(c, 20.75, "fill='#fff'");
    // As separate lines from end to end, some backwards.
    tools += "<path " + line + " d='" + arc(c, 22, 10, 130) + "'/><path " + line + " d='" +
             arc(c, 22, 130, 250) + "'/><path " + line + " d='" + arc(c, 22, 250, 370) + "'/>";
    compound += arc(c, 22, 0, 180) + arc(c, 22, 180, 360).substr(arc(c, 22, 180, 360).find('A')) + "Z";
    rings = rings + arc(c, 23.25, 0, 180) +
            arc(c, 23.25, 180, 360).substr(arc(c, 23.25, 180, 360).find('A')) + "Z";
  }
  expect_seven(drawing_of(bare), "no ids");
  expect_seven(drawing_of(std::string("<g id='Layer_1'>") + bare + "</g>"), "one layer");
  expect_seven(drawing_of(std::string("<g><g id='a'><g>") + bare + "</g></g></g>"), "groups of groups");
  expect_seven(drawing_of(own_ids), "ids of shapes");
  expect_seven(drawing_of(groups), "groups");
  expect_seven(drawing_of(pads), "pads");
  expect_seven(drawing_of(labels_own), "labels with ids");
  expect_seven(drawing_of(compound + "'/>"), "one path", 1e-3);
  expect_seven(drawing_of(tools), "separate arcs", 1e-3);
  std::string copies = "<defs>" + circle_at({0, 0}, 22, line + " id='k'") + "</defs>";
  for (const Vector2d& c : centres)
    copies += "<use xlink:href='#k' x='" + number(c.x()) + "' y='" + number(c.y()) + "'/>";
  expect_seven(drawing_of(copies), "copies");
  expect_seven(drawing_of(bare + bare), "everything twice");
}

TEST(Sorting, NamesComeFromTheFile) {
  const auto drawing = drawing_of(
      "<g id='Layer'><g id='left'>" + circle_at({-40, 3}, 20, line) +
      "<rect x='-41' y='0' width='2' height='2'/></g>" + circle_at({30, 5}, 20, line + " id='right'") +
      circle_at({0, 60}, 20, line) + "</g><g id='left'>" + circle_at({0, -60}, 20, line) + "</g>");
  std::vector<std::string> ids;
  for (const Element& e : drawing.elements) ids.push_back(e.id);
  EXPECT_EQ(ids, (std::vector<std::string>{"left", "right", "coil-3", "left-2"}));
  EXPECT_EQ(drawing.elements[0].shapes.size(), 2u);
}

TEST(Sorting, LoopsOfEveryKind) {
  const Vector2d c(13, -9);
  const auto d = [&](const std::string& path) {
    return std::string("<path ") + line + " d='" + path + "'/>";
  };
  std::string eight = "M";
  for (int i = 0; i < 200; ++i) {
    const double t = 2 * M_PI * i / 200;
    eight +=
        number(c.x() + 40 * std::sin(t)) + " " + number(c.y() + 25 * std::sin(2 * t)) + (i < 199 ? "L" : "Z");
  }
  struct Case {
    const char* what;
    std::string body;
    double area;
  };
  const double circle_area = M_PI * 22 * 22;
  for (const auto& [what, body, area] : {
           Case{"one gap", d(arc(c, 22, 5, 355)), circle_area},
           Case{"four wide gaps",
                d(arc(c, 22, 9, 81)) + d(arc(c, 22, 99, 171)) + d(arc(c, 22, 189, 261)) +
                    d(arc(c, 22, 279, 351)),
                circle_area},
           Case{"a rectangle of four lines",
                d("M-30 -20H50") + d("M50 15V-20") + d("M50 15H-30") + d("M-30 15V-20"), 80 * 35.0},
           Case{"leads", d(arc(c, 22, 3, 357)) + d("M34.97 -7.85H48") + d("M34.97 -10.15H48"), circle_area},
           Case{"a figure of eight", std::string("<path ") + line + " d='" + eight + "'/>",
                2 * 40 * 25 * 4 / 3.0},
           Case{"a filled ring",
                "<path fill-rule='evenodd' d='" + arc(c, 23, 0, 180) + "A23 23 0 0 1 36 -9Z" +
                    arc(c, 21, 0, 180) + "A21 21 0 0 1 34 -9Z'/>",
                circle_area},
           Case{"a disc with a white one", circle_at(c, 23) + circle_at(c, 21, "fill='#fff'"), circle_area},
           Case{"white inside", circle_at(c, 22, "fill='#fff' stroke='#000' stroke-width='2'"), circle_area},
           Case{"a filled ring with a gap",
                "<path d='" + arc(c, 23, 10, 350) + "L" + number(c.x() + 21 * std::cos(10 * M_PI / 180)) +
                    " " + number(c.y() - 21 * std::sin(10 * M_PI / 180)) + "A21 21 0 1 0 " +
                    number(c.x() + 21 * std::cos(10 * M_PI / 180)) + " " +
                    number(c.y() + 21 * std::sin(10 * M_PI / 180)) + "Z'/>",
                circle_area},
       }) {
    const Drawing drawing = drawing_of(body);
    const auto coils = coils_of(drawing);
    ASSERT_EQ(coils.size(), 1u) << what;
    EXPECT_NEAR(coils[0]->loop->area_mm2, area, 0.03 * area) << what;
  }
  // Nothing that is closed.
  for (const std::string& body :
       {circle_at(c, 20), d(arc(c, 22, 0, 250)), d("M0 0H40V3H0"), d("M-50 0H50"), d("M0 0L10 20L20 0L30 20"),
        std::string("<circle r='1.2' fill='none' stroke='#000' stroke-width='2.6'/>")})
    EXPECT_TRUE(coils_of(drawing_of(body)).empty()) << body;
}

TEST(Sorting, NestedLoopsAreCoilsAboutOneCentre) {
  const Drawing drawing = drawing_of(circle_at({3, 4}, 30, line) + circle_at({3.4, 4.3}, 12, line) +
                                     circle_at({15, 4}, 5, line) + circle_at({3, 20}, 2, line));
  const auto coils = coils_of(drawing);
  ASSERT_EQ(coils.size(), 3u);  // the loop of 2 mm is a mark
  EXPECT_EQ(coils[0]->centre, coils[1]->centre);
  EXPECT_GT((coils[2]->centre - coils[0]->centre).norm(), 11);
  EXPECT_EQ(coils[0]->shapes.size(), 2u);
}

TEST(Sorting, MarksGoWithTheirCoil) {
  const std::string two = circle_at({-20, 2}, 18, line) + circle_at({22, 5}, 18, line);
  const auto coil_of = [&](const std::string& mark) {
    const Drawing drawing = drawing_of(two + mark);
    for (std::size_t e = 0; e < drawing.elements.size(); ++e)
      for (const Shape& shape : drawing.elements[e].shapes)
        if (&shape == &drawing.elements[e].shapes.back() && drawing.elements[e].shapes.size() > 1)
          return drawing.elements[e].loop ? static_cast<int>(e) : -1;
    return -1;
  };
  EXPECT_EQ(coil_of("<rect x='-22' y='0' width='4' height='3' id='pad'/>"), 0);              // in it
  EXPECT_EQ(coil_of("<rect x='20' y='22' width='4' height='3'/>"), 1);                       // on its trace
  EXPECT_EQ(coil_of("<path d='M40 5H52' stroke='#000' stroke-width='1' id='lead'/>"), 1);    // from it
  EXPECT_EQ(coil_of("<path d='M40 5H95' stroke='#000' stroke-width='1'/>"), -1);             // far from it
  EXPECT_EQ(coil_of("<path d='M-2 2L4 5' stroke='#000' stroke-width='1' id='join'/>"), -1);  // joins the two
  // A word beside them is a figure of its own.
  const Drawing word =
      drawing_of(two +
                 "<rect x='0' y='60' width='5' height='8'/><rect x='7' y='60' width='5' height='8'/>"
                 "<rect x='14' y='60' width='5' height='8'/>");
  ASSERT_EQ(word.elements.size(), 3u);
  EXPECT_FALSE(word.elements[2].loop);
  EXPECT_EQ(word.elements[2].shapes.size(), 3u);
}

// As CAD programs and converters write circles: chopped into lines, arcs that run either way, ends that nearly meet, open
// pieces in one path, every piece twice, a lead in the circle's path.
TEST(Sorting, CirclesAsConvertersWriteThem) {
  std::ostringstream chopped, flipped, nearly, pieces, twice, leads;
  pieces << "<path " << line << " d='";
  const auto path = [&](const std::string& d) {
    return std::string("<path ").append(line).append(" d='").append(d).append("'/>");
  };
  for (const Vector2d& c : seven()) {
    const auto at = [&](double degrees, double r) -> Vector2d {
      return c + r * Vector2d(std::cos(degrees * M_PI / 180), std::sin(degrees * M_PI / 180));
    };
    for (int k = 0; k < 72; ++k) {
      const Vector2d a = at(5 * k, 22), b = at(5 * k + 5, 22);
      chopped << "<line x1='" << a.x() << "' y1='" << a.y() << "' x2='" << b.x() << "' y2='" << b.y() << "' "
              << line << "/>";
    }
    for (int k = 0; k < 4; ++k) {
      const std::string piece = arc(c, 22, 90 * k, 90 * k + 90);
      const Vector2d a = at(90 * k + 90, 22), b = at(90 * k, 22);
      std::ostringstream back;
      back << "M" << a.x() << " " << a.y() << "A22 22 0 0 0 " << b.x() << " " << b.y();
      flipped << path(k % 2 == 0 ? piece : back.str());
      pieces << piece;
      twice << path(piece) << path(back.str());
    }
    nearly << path(arc(c, 22, 0.02, 359.99));
    const Vector2d end = at(140, 26), begin = at(140, 22);
    std::ostringstream lead;
    lead << arc(c, 22, 0, 180) << "A22 22 0 0 1 " << c.x() + 22 << " " << c.y() << "ZM" << begin.x() << " "
         << begin.y() << "L" << end.x() << " " << end.y();
    leads << path(lead.str());
  }
  pieces << "'/>";
  expect_seven(drawing_of(chopped.str()), "chopped into lines", 0.01);
  expect_seven(drawing_of(flipped.str()), "arcs both ways", 1e-3);
  expect_seven(drawing_of(nearly.str()), "ends that nearly meet", 1e-3);
  expect_seven(drawing_of(pieces.str()), "open pieces in one path", 1e-3);
  expect_seven(drawing_of(twice.str()), "every piece twice", 1e-3);
  expect_seven(drawing_of(leads.str()), "a lead in the same path", 0.02);  // its half circles are rounded
}

// Rings, some with gaps, pads and words, in random groups with and without ids: the rings are the coils.
TEST(Sorting, RandomDrawings) {
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int round = 0; round < 200; ++round) {
    std::string body;
    std::vector<Vector2d> wanted;
    const double r = uniform(9, 20), apart = uniform(1.35, 2.4) * r, turn = uniform(0, 6);
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        if (uniform(0, 1) < 0.3) continue;
        const Vector2d c =
            Eigen::Rotation2Dd(turn) * Vector2d(apart * (x + 0.5 * (y & 1)), apart * 0.866 * y);
        wanted.emplace_back(c.x(), -c.y());
        std::string one;
        const double gap = uniform(2, 12), at = uniform(0, 360);
        const int kind = static_cast<int>(uniform(0, 4));
        if (kind == 0) one = circle_at(c, r, line);
        if (kind == 1) one = "<path " + line + " d='" + arc(c, r, at + gap, at + 360 - gap) + "'/>";
        if (kind == 2)
          one = "<path " + line + " d='" + arc(c, r, at + gap, at + 180 - gap) + "'/><path " + line + " d='" +
                arc(c, r, at + 180 + gap, at + 360 - gap) + "'/>";
        if (kind == 3) one = circle_at(c, r + 1) + circle_at(c, r - 1, "fill='#fff'");
        // A filled disc would hide what lies below.
        if (kind == 3 && apart < 2 * r + 3) one = circle_at(c, r, line);
        if (uniform(0, 1) < 0.5)
          one += "<rect x='" + number(c.x() - 1) + "' y='" + number(c.y() + 0.3 * r) +
                 "' width='2' height='1.5'" + (uniform(0, 1) < 0.5 ? " id='pad'" : "") + "/>";
        const double grouped = uniform(0, 1);
        body += grouped < 0.3 ? "<g id='c'>" + one + "</g>" : grouped < 0.6 ? "<g>" + one + "</g>" : one;
      }
    if (uniform(0, 1) < 0.3) body = "<g id='all'>" + body + "</g>";
    const Drawing drawing = drawing_of(body);
    const auto coils = coils_of(drawing);
    ASSERT_EQ(coils.size(), wanted.size()) << round << " " << body;
    for (const Vector2d& c : wanted)
      EXPECT_TRUE(std::any_of(coils.begin(), coils.end(),
                              [&](const Element* e) { return (e->centre - c).norm() < 0.1 * r; }))
          << round << " " << body;
  }
}

// A picture of the same rings, with a pad in each.
TEST(Sorting, PicturesGiveTheSameCoils) {
  const auto centres = seven();
  const auto gray = [&](int i, int j) {
    const Vector2d p((i + 0.5) / 6 - 90, (j + 0.5) / 6 - 90);
    double off = 1;
    for (const Vector2d& c : centres) {
      off = std::min(off, std::abs((p - c).norm() - 22) - 1.25);
      off = std::min(off, (p - c).cwiseAbs().maxCoeff() - 2);
    }
    return static_cast<int>(255 * std::clamp(0.5 + off * 6, 0.0, 1.0));
  };
  const auto read = Pattern::read(gray_png(1080, 1080, 6000, gray), "rings.png", {}, 300);
  ASSERT_TRUE(read);
  const InkParts parts(*read);
  expect_seven(parts.drawing(), "picture", 0.05);
  EXPECT_EQ(parts.drawing().elements.size(), 7u);
  for (const Vector2d& c : centres) {
    const auto& elements = parts.drawing().elements;
    for (std::size_t e = 0; e < elements.size(); ++e)
      EXPECT_EQ(parts.holds(static_cast<int>(e), {c.x(), -c.y()}),
                (elements[e].centre - Vector2d(c.x(), -c.y())).norm() < 1);
  }
}

const std::string ring_on_layer = "<circle r='30' fill='none' stroke='black' stroke-width='3'";
std::string on_layer(const std::string& name, const std::string& body) {
  return "<g id='" + name + "'>" + body + "</g>";
}

// Resist over a coil and a picture in it: neither is a coil, whatever it looks like, and both belong to the coil.
TEST(Sorting, ResistAndPicturesAreNoCoils) {
  const Drawing drawing =
      drawing_of(on_layer("conductor", ring_on_layer + "/>") +
                 on_layer("resist", "<circle r='30' fill='none' stroke='green' stroke-width='5'/>") +
                 on_layer("picture", "<circle r='12' fill='none' stroke='red' stroke-width='2'/>"));
  const auto coils = coils_of(drawing);
  ASSERT_EQ(coils.size(), 1u);
  EXPECT_DOUBLE_EQ(coils[0]->loop->width_mm, 3);
  EXPECT_EQ(coils[0]->shapes.size(), 3u);
  EXPECT_TRUE(drawing.layered());
  EXPECT_FALSE(drawing.parts_loops());
}

// A white disc makes a ring of a black one on its own layer only.
TEST(Sorting, WhiteOfAnotherLayerMakesNoHole) {
  const auto loops = [](const std::string& layer) {
    return coils_of(drawing_of(on_layer("conductor", "<circle r='30'/>") +
                               on_layer(layer, "<circle r='26' fill='white'/>") +
                               on_layer("resist", "<rect x='60' y='60' width='9' height='9'/>")))
        .size();
  };
  EXPECT_EQ(loops("conductor"), 1u);
  EXPECT_EQ(loops("picture"), 0u);
}

// Programs call groups "image": alone it is no layer.
TEST(Sorting, APictureAloneIsADrawingWithoutLayers) {
  const Drawing alone = drawing_of(on_layer("image", ring_on_layer + "/>"));
  EXPECT_EQ(coils_of(alone).size(), 1u);
  EXPECT_FALSE(alone.layered());
  const Drawing white_beside = drawing_of("<rect x='-99' y='-99' width='9' height='9' fill='white'/>" +
                                          on_layer("image", ring_on_layer + "/>"));
  EXPECT_FALSE(white_beside.layered());
}

// A mask of a board: resist on the whole page first, and its openings in white, with the coil that they lie on.
TEST(Sorting, OpeningsOfAResistTurnWhiteOnThePage) {
  const Drawing drawing =
      drawing_of(on_layer("F.Cu", ring_on_layer + "/>") +
                 on_layer("F.Mask", "<rect x='-3' y='-33' width='6' height='6' fill='#a0f'/>"));
  const Shape& ground = drawing.elements.front().shapes.front();
  EXPECT_EQ(*ground.layer, (DrawnLayer{PrintStep::resist}));
  EXPECT_DOUBLE_EQ(box_of(ground.curves[0]).sizes().x(), page_mm);
  EXPECT_GT(ground.fill->ink(), 0);
  const auto coils = coils_of(drawing);
  ASSERT_EQ(coils.size(), 1u);
  ASSERT_EQ(coils[0]->shapes.size(), 2u);
  EXPECT_EQ(coils[0]->shapes[1].layer, ground.layer);
  EXPECT_EQ(coils[0]->shapes[1].fill->ink(), 0);
  EXPECT_DOUBLE_EQ(coils[0]->shapes[1].fill->a, 1);
}

}  // namespace
}  // namespace vacuform
