#include "worker/printing/layer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/printing/colour_ink.hpp"
#include "worker/printing/colour_raster.hpp"
#include "worker/printing/ink_compensation.hpp"
#include "worker/printing/ink_on_chart.hpp"
#include "worker/printing/sheet_raster.hpp"
#include "worker/printing/vector_raster.hpp"

namespace vacuform {

namespace {

class DrawingLayer : public LayerSource {
 public:
  DrawingLayer(const Pattern& pattern, VectorPrint vectors)
      : pattern_(pattern), vectors_(std::move(vectors)) {}

  std::unique_ptr<RowSource> printed(const PrintGrid& grid) const override {
    return std::make_unique<VectorRaster>(vectors_, grid, pattern_.grayscale());
  }
  std::unique_ptr<RowSource> shown(const PrintGrid& grid, InkState) const override { return laid(grid); }
  std::unique_ptr<RowSource> laid(const PrintGrid& grid) const override {
    return std::make_unique<VectorRaster>(vectors_, grid, false);
  }
  bool black() const override { return pattern_.grayscale(); }
  double ink_printed() const override {
    const double lost = vectors_.painted_mm2 > 0 ? vectors_.lost_mm2 / vectors_.painted_mm2 : 1;
    return lost < 1e-9 ? 1 : std::clamp(1 - lost, 0.0, 1.0);
  }
  std::vector<Warning> warnings() const override { return pattern_.warnings(); }
  std::vector<Eigen::AlignedBox2d> boxes() const override {
    std::vector<Eigen::AlignedBox2d> out;
    for (const PrintedElement& element : vectors_.elements)
      for (const PaintedArea& area : element.areas)
        for (const Curve& curve : area.outlines)
          for (std::size_t i = 0; i + 3 < curve.points.size(); i += 3) {
            Eigen::AlignedBox2d& box = out.emplace_back();
            for (std::size_t k = i; k < i + 4; ++k) box.extend(curve.points[k]);
          }
    return out;
  }
  const VectorPrint* vectors() const override { return &vectors_; }

 private:
  const Pattern& pattern_;
  VectorPrint vectors_;
};

class PictureLayer : public LayerSource {
 public:
  PictureLayer(const Pattern& pattern, const Placement& placement, const InkParts* parts, bool compensate)
      : pattern_(pattern), placement_(placement), parts_(parts), patches_(patches_of(placement)) {
    if (!compensate) return;
    std::vector<const Patch*> shapes;
    for (const RasterPatch& each : patches_) shapes.push_back(each.patch);
    gain_ = ink_gain(shapes, pattern);
  }

  std::unique_ptr<RowSource> printed(const PrintGrid& grid) const override {
    std::vector<RasterPatch> patches = patches_;
    for (std::size_t i = 0; i < gain_.size(); ++i) patches[i].gain = gain_[i];
    return std::make_unique<SheetRaster>(patches, parts_, pattern_, grid, edge_samples(grid));
  }
  std::unique_ptr<RowSource> shown(const PrintGrid& grid, InkState) const override {
    return std::make_unique<SheetRaster>(patches_, parts_, pattern_, grid, edge_samples(grid));
  }
  std::unique_ptr<RowSource> laid(const PrintGrid& grid) const override {
    constexpr int samples = 2;  // enough for the share of ink
    return std::make_unique<SheetRaster>(patches_, parts_, pattern_, grid, samples);
  }
  bool black() const override { return pattern_.grayscale(); }
  double ink_printed() const override { return ink_on_charts(placement_.charts, pattern_); }
  bool compensates_shades() const override { return !gain_.empty(); }
  std::vector<Warning> warnings() const override { return pattern_.warnings(); }
  const Pattern* under_charts() const override { return placement_.elements.empty() ? &pattern_ : nullptr; }

 private:
  const Pattern& pattern_;
  const Placement& placement_;
  const InkParts* const parts_;
  const std::vector<RasterPatch> patches_;
  std::vector<std::vector<double>> gain_;  // of the triangles of each patch; empty: none
};

class ColourLayer : public LayerSource {
 public:
  ColourLayer(PrintedColours colours, std::shared_ptr<const LayerSource> as_picture)
      : colours_(std::move(colours)), as_picture_(std::move(as_picture)) {}

  std::unique_ptr<RowSource> printed(const PrintGrid& grid) const override {
    return std::make_unique<ColourRaster>(colours_.on_sheet, grid, in(InkState::printed));
  }
  std::unique_ptr<RowSource> shown(const PrintGrid& grid, InkState state) const override {
    return std::make_unique<ColourRaster>(colours_.on_sheet, grid, in(state), 1);
  }
  std::unique_ptr<RowSource> laid(const PrintGrid& grid) const override {
    if (as_picture_) return as_picture_->laid(grid);
    return std::make_unique<ColourRaster>(colours_.on_sheet, grid);
  }
  bool black() const override { return false; }
  double ink_printed() const override { return 1; }
  std::vector<Eigen::AlignedBox2d> boxes() const override {
    const FormedSheet& sheet = colours_.on_sheet.sheet();
    std::vector<Eigen::AlignedBox2d> out;
    for (const int t : colours_.on_sheet.triangles()) {
      Eigen::AlignedBox2d& box = out.emplace_back();
      for (const int v : sheet.triangles[t]) box.extend(sheet.rest[v]);
    }
    return out;
  }
  const PrintedColours* colours() const override { return &colours_; }

 private:
  ColourRaster::Compensation in(InkState state) const {
    return {colours_.ink ? &*colours_.ink : nullptr, state};
  }

  const PrintedColours colours_;
  const std::shared_ptr<const LayerSource> as_picture_;
};

}  // namespace

Result<std::shared_ptr<const LayerSource>> drawing_layer(const Pattern& pattern, const Drawing& drawing,
                                                         const Placement& placement, const Settings& settings,
                                                         const Context& context) {
  VACUFORM_TRY(vectors, pull_back(drawing, placement, settings, context));
  return drawing_layer(pattern, std::move(vectors));
}

std::shared_ptr<const LayerSource> drawing_layer(const Pattern& pattern, VectorPrint vectors) {
  return std::make_shared<const DrawingLayer>(pattern, std::move(vectors));
}

std::shared_ptr<const LayerSource> picture_layer(const Pattern& pattern, const Placement& placement,
                                                 const InkParts* parts, bool compensate) {
  return std::make_shared<const PictureLayer>(pattern, placement, parts, compensate);
}

std::shared_ptr<const LayerSource> colour_layer(PrintedColours colours,
                                                std::shared_ptr<const LayerSource> as_picture) {
  return std::make_shared<const ColourLayer>(std::move(colours), std::move(as_picture));
}

Result<Pattern> picture_of(const SheetColours& colours, const SheetSettings& sheet, const Context& context) {
  const double pixel_mm = std::max(0.2, std::max(sheet.width_mm, sheet.height_mm) / 4000);
  const Eigen::Vector2i size(static_cast<int>(std::ceil(sheet.width_mm / pixel_mm - 1e-9)),
                             static_cast<int>(std::ceil(sheet.height_mm / pixel_mm - 1e-9)));
  const ColourRaster raster(colours, {size.x(), size.y(), pixel_mm}, 1);
  std::vector<std::uint8_t> pixels;
  pixels.reserve(4 * static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()));
  for (int top = 0; top < size.y(); top += raster.band_rows()) {
    VACUFORM_CHECK(context.step(Stage::printing, static_cast<double>(top) / size.y()));
    const auto band = raster.rows(top, std::min(top + raster.band_rows(), size.y()));
    pixels.insert(pixels.end(), band.begin(), band.end());
  }
  for (std::size_t i = 0; i < pixels.size(); i += 4)
    for (std::size_t k = i; k < i + 3; ++k)
      pixels[k] = static_cast<std::uint8_t>((pixels[k] * pixels[i + 3] + 127) / 255);
  return Pattern::of_picture(size, std::move(pixels), pixel_mm * size.cast<double>(), "scan");
}

}  // namespace vacuform
