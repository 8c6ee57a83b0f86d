#include "worker/inspection/formed_glb.hpp"

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/unit/fixtures/printed_jobs.hpp"
#include "worker/inspection/mesh_files.hpp"
#include "worker/inspection/sheet_textures.hpp"
#include "worker/inspection/shrunk_png.hpp"

namespace vacuform {
namespace {

using namespace drawing_files;
using namespace printed_jobs;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A GLB read back as the specification says, without the code that wrote it.
struct Glb {
  nlohmann::json json;
  Bytes binary;

  explicit Glb(const Bytes& file) {
    const auto word = [&](std::size_t at) {
      return std::size_t{file.at(at)} | std::size_t{file.at(at + 1)} << 8 |
             std::size_t{file.at(at + 2)} << 16 | std::size_t{file.at(at + 3)} << 24;
    };
    if (std::string(file.begin(), file.begin() + 4) != "glTF" || word(4) != 2 || word(8) != file.size())
      throw std::runtime_error("no header of glTF 2.0");
    const std::size_t size = word(12), at = 20 + size;
    if (word(16) != 0x4e4f534a || size % 4 != 0) throw std::runtime_error("no JSON chunk");
    json = nlohmann::json::parse(file.begin() + 20, file.begin() + static_cast<std::ptrdiff_t>(at));
    if (word(at + 4) != 0x004e4942 || word(at) % 4 != 0 || at + 8 + word(at) != file.size())
      throw std::runtime_error("no binary chunk");
    binary.assign(file.begin() + static_cast<std::ptrdiff_t>(at) + 8, file.end());
  }

  const nlohmann::json& primitive() const { return json["meshes"][0]["primitives"][0]; }
  Bytes view(std::size_t i) const {
    const auto& v = json["bufferViews"].at(i);
    const auto begin = binary.begin() + v["byteOffset"].get<std::ptrdiff_t>();
    return {begin, begin + v["byteLength"].get<std::ptrdiff_t>()};
  }
  // Words of an accessor that fills its view.
  template <class Word>
  std::vector<Word> words(std::size_t accessor) const {
    const Bytes bytes = view(json["accessors"].at(accessor)["bufferView"]);
    std::vector<Word> out(bytes.size() / 4);
    std::memcpy(out.data(), bytes.data(), 4 * out.size());
    return out;
  }
  std::vector<float> attribute(const char* name) const {
    return words<float>(primitive()["attributes"].at(name));
  }
  Decoded texture_of_variant(const std::string& name) const {
    const auto& variants = json["extensions"]["KHR_materials_variants"]["variants"];
    for (std::size_t i = 0; i < variants.size(); ++i)
      if (variants[i]["name"] == name)
        for (const auto& shown : primitive()["extensions"]["KHR_materials_variants"]["mappings"])
          if (shown["variants"] == nlohmann::json{i}) {
            const auto& colour =
                json["materials"].at(shown["material"].get<std::size_t>())["pbrMetallicRoughness"];
            const std::size_t texture = colour["baseColorTexture"]["index"];
            const auto& image = json["images"].at(json["textures"].at(texture)["source"].get<std::size_t>());
            if (image["mimeType"] != "image/png") throw std::runtime_error("not a PNG");
            return decode_png(view(image["bufferView"]));
          }
    throw std::runtime_error("no variant " + name);
  }
};

Result<std::vector<std::uint8_t>> bytes_of_job(const Job& job, const Context& context = Context()) {
  const Finished finished = job.finished();
  return formed_glb(finished, SheetPicture(finished), context);
}

Glb glb_of_job(const Job& job) {
  const auto bytes = bytes_of_job(job);
  if (!bytes) throw std::runtime_error(bytes.error().text());
  return Glb(*bytes);
}

TEST(FormedGlb, EveryAccessorFitsItsViewAndEveryViewTheFile) {
  const Glb glb = glb_of_job(small_dome());
  EXPECT_EQ(glb.json["asset"]["version"], "2.0");
  EXPECT_TRUE(glb.json["asset"]["generator"].get<std::string>().starts_with("Vacuform "));
  EXPECT_EQ(glb.json["buffers"][0]["byteLength"], glb.binary.size());
  std::size_t end = 0;
  for (const auto& view : glb.json["bufferViews"]) {
    const std::size_t start = view["byteOffset"], length = view["byteLength"];
    EXPECT_EQ(start % 4, 0u);
    EXPECT_GE(start, end);
    EXPECT_GT(length, 0u);
    end = start + length;
    EXPECT_LE(end, glb.binary.size());
  }
  const std::map<std::string, std::size_t> numbers{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}};
  for (const auto& a : glb.json["accessors"])
    EXPECT_EQ(4 * numbers.at(a["type"]) * a["count"].get<std::size_t>(),
              glb.json["bufferViews"].at(a["bufferView"].get<std::size_t>())["byteLength"]);
  const auto& attributes = glb.primitive()["attributes"];
  EXPECT_EQ(attributes.size(), 11u);
  const std::size_t count = glb.json["accessors"].at(attributes["POSITION"].get<std::size_t>())["count"];
  for (const auto& [name, accessor] : attributes.items()) {
    const auto& a = glb.json["accessors"].at(accessor.get<std::size_t>());
    EXPECT_EQ(a["componentType"], 5126) << name;
    EXPECT_EQ(a["count"], count) << name;
    // The bounds are those of the numbers, and every number is finite.
    const auto values = glb.attribute(name.c_str());
    const std::size_t size = numbers.at(a["type"]);
    for (std::size_t k = 0; k < size; ++k) {
      float least = INFINITY, most = -INFINITY;
      for (std::size_t i = k; i < values.size(); i += size) {
        ASSERT_TRUE(std::isfinite(values[i])) << name;
        least = std::min(least, values[i]), most = std::max(most, values[i]);
      }
      EXPECT_EQ(a["min"][k].get<float>(), least) << name;
      EXPECT_EQ(a["max"][k].get<float>(), most) << name;
    }
  }
  const auto& indices = glb.json["accessors"].at(glb.primitive()["indices"].get<std::size_t>());
  EXPECT_EQ(indices["componentType"], 5125);
  for (const std::uint32_t v : glb.words<std::uint32_t>(glb.primitive()["indices"])) ASSERT_LT(v, count);
}

// Also in two segments, where vertices of the seam appear twice.
TEST(FormedGlb, HasTheVerticesAndTrianglesOfThePly) {
  for (const bool seam : {false, true}) {
    Job job = small_dome();
    if (seam)
      for (std::size_t i = 0; i < job.print.pattern_uv.size(); i += 2)
        for (Vector2d& uv : job.print.pattern_uv[i]) uv.x() += 100;
    const Glb glb = glb_of_job(job);
    const Bytes ply = formed_ply(job.finished());
    const std::string text(ply.begin(), ply.end());
    const std::size_t body = text.find("end_header\n") + 11;
    const auto position = glb.attribute("POSITION"), sheet = glb.attribute("_SHEET"),
               pattern = glb.attribute("_PATTERN"), thickness = glb.attribute("_THICKNESS"),
               contact = glb.attribute("_CONTACT"), chart = glb.attribute("_CHART");
    const std::size_t count = chart.size();
    EXPECT_EQ(count > job.sample.sheet.formed.size(), seam);
    const auto number = [&](std::size_t vertex, std::size_t property) {
      float value = 0;
      std::memcpy(&value, ply.data() + body + 37 * vertex + 4 * property, 4);
      return value;
    };
    int off_chart = 0;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < 3; ++k) ASSERT_EQ(position[3 * i + k], number(i, k));
      for (std::size_t k = 0; k < 2; ++k) ASSERT_EQ(sheet[2 * i + k], number(i, 3 + k));
      const bool on_chart = !std::isnan(number(i, 5));
      off_chart += !on_chart;
      ASSERT_EQ(chart[i], on_chart ? 1.0f : 0.0f);
      for (std::size_t k = 0; k < 2; ++k) ASSERT_EQ(pattern[2 * i + k], on_chart ? number(i, 5 + k) : 0.0f);
      ASSERT_EQ(thickness[i], number(i, 7));
      ASSERT_EQ(contact[i], ply[body + 37 * i + 36]);
    }
    EXPECT_GT(off_chart, 1000);
    const auto indices = glb.words<std::uint32_t>(glb.primitive()["indices"]);
    ASSERT_EQ(indices.size(), 3 * job.sample.sheet.triangles.size());
    for (std::size_t t = 0; t < job.sample.sheet.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        std::uint32_t v = 0;
        std::memcpy(&v, ply.data() + body + 37 * count + 13 * t + 1 + 4 * k, 4);
        ASSERT_EQ(indices[3 * t + k], v);
      }
  }
}

TEST(FormedGlb, TheGapIsTheDistanceToTheMold) {
  Job job = small_dome();
  for (Contact& contact : job.sample.sheet.contact)  // as if the sheet hung beside the mold
    if (contact == Contact::platform && &contact != &job.sample.sheet.contact.back()) contact = Contact::free;
  const Glb glb = glb_of_job(job);
  const auto gap = glb.attribute("_GAP"), contact = glb.attribute("_CONTACT"),
             position = glb.attribute("POSITION");
  const double radius = job.sample.mold.top.z();
  int touching = 0, beside = 0;
  for (std::size_t i = 0; i < gap.size(); ++i) {
    const double from_axis = std::hypot(position[3 * i], position[3 * i + 1]);
    if (contact[i] == 1) {
      ++touching;
      ASSERT_EQ(gap[i], 0);
    } else if (contact[i] != 0) {
      ASSERT_EQ(gap[i], -1);  // on the platform and in the clamp frame
    } else if (position[3 * i + 2] == 0 && from_axis > radius) {
      ++beside;
      ASSERT_NEAR(gap[i], from_axis - radius, 0.001 * radius);  // the mold has facets
    }
  }
  EXPECT_GT(touching, 100);
  EXPECT_GT(beside, 100);
}

TEST(FormedGlb, NormalsPointOutOfADome) {
  const Glb glb = glb_of_job(small_dome());
  const auto position = glb.attribute("POSITION"), normal = glb.attribute("NORMAL"),
             sheet = glb.attribute("_SHEET");
  int on_dome = 0;
  for (std::size_t i = 0; i < sheet.size() / 2; ++i) {
    const Vector3d n(normal[3 * i], normal[3 * i + 1], normal[3 * i + 2]);
    ASSERT_NEAR(n.norm(), 1, 1e-6);
    if (std::hypot(sheet[2 * i], sheet[2 * i + 1]) > 60) continue;
    const Vector3d p(position[3 * i], position[3 * i + 1], position[3 * i + 2]);
    EXPECT_GT(n.dot(p) / 60, 0.995);
    ++on_dome;
  }
  EXPECT_GT(on_dome, 100);
}

TEST(FormedGlb, TheNodeTakesMillimetresWithZUpToMetresWithYUpAndTheFrontAtPlusZ) {
  const Glb glb = glb_of_job(small_dome());
  const auto& node = glb.json["nodes"].at(glb.json["scenes"][0]["nodes"][0].get<std::size_t>());
  EXPECT_EQ(node["mesh"], 0);
  const std::vector<double> m = node["matrix"];
  const Eigen::Vector4d there = Eigen::Map<const Eigen::Matrix4d>(m.data()) * Eigen::Vector4d(10, 20, 30, 1);
  EXPECT_NEAR((there - Eigen::Vector4d(-0.01, 0.03, 0.02, 1)).norm(), 0, 1e-12);
}

TEST(FormedGlb, ShapeAndAreaAreThoseOfTheStretchAndNoneOffTheChart) {
  Eigen::Matrix2d stretch;
  stretch << 0.5, 0, 0, 0.8;
  Job job(hand_made::stretched(120, 24, stretch, 40), "<circle r='3'/>");
  const Glb glb = glb_of_job(job);
  const auto shape = glb.attribute("_SHAPE"), area = glb.attribute("_AREA"), chart = glb.attribute("_CHART");
  int on_chart = 0;
  for (std::size_t i = 0; i < chart.size(); ++i) {
    on_chart += chart[i] > 0;
    EXPECT_NEAR(shape[i], chart[i] > 0 ? 1.6 : -1, 1e-6);
    EXPECT_NEAR(area[i], chart[i] > 0 ? 2.5 : -1, 1e-6);  // a shrunken area counts like a grown one
  }
  EXPECT_GT(on_chart, 100);
  EXPECT_LT(on_chart, 300);
}

// A ring off the centre of the drawing, on a dome that stretches it: the vertices under ink are those where the drawing
// has it (pre-distorted), or where the flat sheet has it at 1:1 (as drawn). Whichever face is inked.
TEST(FormedGlb, TexturesPutARingWhereItLiesOnThePart) {
  for (const InkedFace face : {InkedFace::outer, InkedFace::inner}) {
    Sample x = hand_made::dome(150);
    x.settings.print.dpi = 100;
    x.settings.print.marks = false;
    x.settings.pattern.inked_face = face;
    const Job job(std::move(x), "<circle cx='8' cy='-5' r='14' fill='none' stroke='#000' stroke-width='6'/>");
    const Glb glb = glb_of_job(job);
    const auto place = glb.attribute("TEXCOORD_0"), sheet = glb.attribute("_SHEET"),
               pattern = glb.attribute("_PATTERN"), chart = glb.attribute("_CHART");
    const auto check = [&](const char* variant, const std::vector<float>& at) {
      const Decoded image = glb.texture_of_variant(variant);
      EXPECT_EQ(image.width, job.print.grid.width);
      EXPECT_EQ(image.height, job.print.grid.height);
      int inked = 0, bare = 0;
      for (std::size_t i = 0; i < chart.size(); ++i) {
        const int column = std::clamp(static_cast<int>(place[2 * i] * image.width), 0, image.width - 1);
        const int row = std::clamp(static_cast<int>(place[2 * i + 1] * image.height), 0, image.height - 1);
        const double off = std::abs(std::hypot(at[2 * i] - 8, at[2 * i + 1] - 5) - 14);
        if (chart[i] > 0 && off < 2.7) {
          EXPECT_LT(image.at(column, row), 128) << variant;
          ++inked;
        } else if (chart[i] == 0 || off > 3.3) {
          EXPECT_GT(image.at(column, row), 127) << variant;
          ++bare;
        }
      }
      EXPECT_GT(inked, 50);
      EXPECT_GT(bare, 10'000);
    };
    check("pre-distorted", pattern);
    check("printed as drawn", sheet);
    EXPECT_EQ(glb.primitive()["material"], 0);
    EXPECT_EQ(glb.json["materials"][0]["name"], "pre-distorted");
    EXPECT_EQ(glb.json["extensionsUsed"], nlohmann::json{"KHR_materials_variants"});
  }
}

TEST(FormedGlb, TexturesHaveAtMost2048PixelsASide) {
  Sample x = hand_made::dome(20);
  x.settings.print.dpi = 300;
  const Job job(std::move(x));
  ASSERT_EQ(job.print.grid.width, 3544);
  const Glb glb = glb_of_job(job);
  for (const char* variant : {"pre-distorted", "printed as drawn"}) {
    const Decoded image = glb.texture_of_variant(variant);
    EXPECT_EQ(image.width, 2048) << variant;
    EXPECT_EQ(image.height, 2048) << variant;
  }
}

TEST(FormedGlb, HasTheSameBytesWithOneProcessor) {
  const Job job = small_dome();
  const auto with_all = bytes_of_job(job);
  cpu_set_t before, one;
  ASSERT_EQ(::sched_getaffinity(0, sizeof before, &before), 0);
  CPU_ZERO(&one);
  for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++cpu)
    if (CPU_ISSET(cpu, &before)) CPU_SET(cpu, &one);
  ASSERT_EQ(::sched_setaffinity(0, sizeof one, &one), 0);
  const auto with_one = bytes_of_job(job);
  ASSERT_EQ(::sched_setaffinity(0, sizeof before, &before), 0);
  ASSERT_TRUE(with_all && with_one);
  EXPECT_TRUE(*with_all == *with_one);
}

TEST(FormedGlb, CanBeCancelled) {
  const Job job = small_dome();
  Context context;
  context.cancel();
  const auto bytes = bytes_of_job(job, context);
  ASSERT_FALSE(bytes);
  EXPECT_EQ(bytes.error().code, Code::cancelled);
}

TEST(ShrunkPng, AveragesWhatEachPixelCovers) {
  // Five columns to two: the middle one counts half on either side.
  const Bytes wide = gray_png(5, 4, 4000, [](int x, int y) { return y == 0 ? 77 : 50 * x; });
  const Decoded small = decode_png(shrunk_png(wide, 2, 1, false));
  ASSERT_EQ(small.width, 2);
  ASSERT_EQ(small.height, 1);
  EXPECT_EQ(small.at(0, 0), 40);  // (0 + 50 + 100 / 2) / 2.5
  EXPECT_EQ(small.at(1, 0), 160);
  EXPECT_EQ(decode_png(shrunk_png(wide, 2, 1, true)).at(0, 0), 160);
  // No wider than it is.
  const Decoded same = decode_png(shrunk_png(wide, 50, 0, true));
  ASSERT_EQ(same.width, 5);
  ASSERT_EQ(same.height, 4);
  for (int x = 0; x < 5; ++x) EXPECT_EQ(same.at(x, 2), 200 - 50 * x);
}

TEST(ShrunkPng, LaysWhatIsTransparentOnWhite) {
  const Bytes rgba = png(2, 1, 8, 6, {{200, 0, 0, 255, 0, 0, 0, 0}});
  const Decoded one = decode_png(shrunk_png(rgba, 1, 0, false));
  EXPECT_EQ(one.at(0, 0, 0), 228);  // (200 + 255) / 2, rounded
  EXPECT_EQ(one.at(0, 0, 1), 128);
  EXPECT_EQ(one.at(0, 0, 3), 255);
  EXPECT_TRUE(shrunk_png({1, 2, 3}, 5, 0, false).empty());
}

}  // namespace
}  // namespace vacuform
