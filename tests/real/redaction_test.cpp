// Files of strangers without their names: the readers find the same shape, colours and lines in them.
#include "api/redaction/redaction.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/real/real_scans.hpp"
#include "worker/pattern/drawing.hpp"
#include "worker/scan/scan_file.hpp"

namespace vacuform::redaction_test {
namespace {

std::vector<std::filesystem::path> files_of(const char* folder) {
  std::vector<std::filesystem::path> files;
  const std::filesystem::path whole = std::filesystem::path(VACUFORM_SHARED_DATA) / folder;
  if (!std::filesystem::exists(whole)) return files;
  for (const auto& entry : std::filesystem::directory_iterator(whole)) files.push_back(entry.path());
  return files;
}

using Content = std::vector<std::uint8_t>;
Content content_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
Content without_names(Content bytes, const std::string& file_name) {
  EXPECT_TRUE(redact(bytes, file_name)) << file_name;
  return bytes;
}

Result<ScanFile> scan_of(const Content& bytes, const std::string& file_name) {
  const Context context;
  return read_scan(bytes, file_name, ScanProgress(context), ScanParts::with_colours);
}

void expect_same(const ScanFile& before, const ScanFile& after) {
  EXPECT_EQ(after.mesh.vertices, before.mesh.vertices);
  EXPECT_EQ(after.mesh.triangles, before.mesh.triangles);
  ASSERT_EQ(after.colours.has_value(), before.colours.has_value());
  if (!before.colours) return;
  EXPECT_EQ(after.colours->vertex, before.colours->vertex);
  EXPECT_EQ(after.colours->uv, before.colours->uv);
  EXPECT_EQ(after.colours->images.size(), before.colours->images.size());
}

void expect_same(const Drawing& before, const Drawing& after) {
  ASSERT_EQ(after.elements.size(), before.elements.size());
  for (std::size_t i = 0; i < before.elements.size(); ++i) {
    EXPECT_EQ(after.elements[i].id, before.elements[i].id);
    ASSERT_EQ(after.elements[i].shapes.size(), before.elements[i].shapes.size());
    for (std::size_t k = 0; k < before.elements[i].shapes.size(); ++k) {
      const Shape &old = before.elements[i].shapes[k], &now = after.elements[i].shapes[k];
      ASSERT_EQ(now.curves.size(), old.curves.size());
      for (std::size_t c = 0; c < old.curves.size(); ++c)
        EXPECT_EQ(now.curves[c].points, old.curves[c].points);
      EXPECT_EQ(now.fill.has_value(), old.fill.has_value());
      EXPECT_EQ(now.stroke.has_value(), old.stroke.has_value());
    }
  }
}

TEST(RealRedaction, LeavesEveryScanAsItIs) {
  if (files_of("cases").empty() && !real::required()) GTEST_SKIP() << real::missing("");
  int scans = 0;
  for (const char* folder : {"scans", "cases"})
    for (const auto& path : files_of(folder)) {
      const std::string name = path.filename().string();
      const Content bytes = content_of(path);
      const auto before = scan_of(bytes, name);
      if (!before) continue;  // no scan, or one that is refused
      SCOPED_TRACE(name);
      ++scans;
      const auto after = scan_of(without_names(bytes, name), name);
      ASSERT_TRUE(after) << after.error().text();
      expect_same(*before, *after);
    }
  EXPECT_GE(scans, 15);
}

TEST(RealRedaction, LeavesEveryDrawingAsItIs) {
  if (files_of("cases").empty() && !real::required()) GTEST_SKIP() << real::missing("");
  int lines = 0;
  PatternSettings settings;
  settings.width_mm = 120;
  for (const char* folder : {"patterns", "cases"})
    for (const auto& path : files_of(folder)) {
      if (path.extension() != ".svg" && path.extension() != ".jpg") continue;
      const std::string name = path.filename().string();
      SCOPED_TRACE(name);
      const Content bytes = content_of(path), redacted = without_names(bytes, name);
      const auto before = Pattern::read(bytes, name, settings, 100);
      if (!before) continue;
      const auto after = Pattern::read(redacted, name, settings, 100);
      ASSERT_TRUE(after) << after.error().text();
      EXPECT_EQ(after->size_mm(), before->size_mm());
      EXPECT_EQ(after->ink_mm2(), before->ink_mm2());
      std::vector<Warning> warnings;
      const auto drawn = read_drawing(*before, warnings), drawn_now = read_drawing(*after, warnings);
      if (!drawn) continue;
      ++lines;
      ASSERT_TRUE(drawn_now);
      expect_same(*drawn, *drawn_now);
    }
  EXPECT_GE(lines, 15);
}

}  // namespace
}  // namespace vacuform::redaction_test
