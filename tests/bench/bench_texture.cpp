// Seconds and peak memory of what pattern.source=scan adds to forming, for the mask of `vacuform sample --model mask` with
// a large texture, at the default settings: sheet of 400 x 400 mm, print of 300 dpi.
//
//   bench_texture [--side PIXELS] [--format png|jpeg] [--json]
//
// The texture is 8192 x 8192 pixels: colours that change over some hundred pixels, with the noise of a camera. Peak memory
// is the largest resident set within the step, less that at the end of forming.
#include <cmath>
#include <cstdio>
// jpeglib.h needs the types of stdio first.
#include <jpeglib.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tests/bench/step_cost.hpp"
#include "worker/colour/sheet_colours.hpp"
#include "worker/forming/inked_face.hpp"
#include "worker/inspection/colour_errors.hpp"
#include "worker/inspection/inspection.hpp"
#include "worker/png/png_writer.hpp"
#include "worker/printing/colour_raster.hpp"
#include "worker/sample/painted_model.hpp"
#include "worker/sample/textured_glb.hpp"
#include "worker/stage/parallel.hpp"

namespace {

using namespace vacuform;
using FileBytes = std::vector<std::uint8_t>;

// One row of the texture, RGB. The noise is of a hash, so that it is the same everywhere.
void paint_row(int y, int side, std::uint8_t* rgb) {
  const double v = (y + 0.5) / side;
  std::uint32_t hash = 0x9e3779b9u * static_cast<std::uint32_t>(y + 1);
  for (int x = 0; x < side; ++x) {
    const double u = (x + 0.5) / side,
                 waves[] = {std::sin(61 * u + 13 * v), std::sin(17 * u - 71 * v), std::sin(43 * (u + v))};
    hash ^= hash << 13, hash ^= hash >> 17, hash ^= hash << 5;
    for (int k = 0; k < 3; ++k)
      rgb[3 * x + k] =
          static_cast<std::uint8_t>(150 + 80 * waves[k] + static_cast<int>(hash >> (8 * k) & 7) - 3);
  }
}

FileBytes png_texture(int side) {
  PngWriter writer(side, side, 3);
  FileBytes row(3 * static_cast<std::size_t>(side));
  for (int y = 0; y < side; ++y) {
    paint_row(y, side, row.data());
    writer.row(row.data());
  }
  return writer.finish();
}

// Quality 90, with colour at half the resolution, as cameras write.
FileBytes jpeg_texture(int side) {
  jpeg_compress_struct encoder{};
  jpeg_error_mgr errors{};
  encoder.err = jpeg_std_error(&errors);
  jpeg_create_compress(&encoder);
  unsigned char* file = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&encoder, &file, &size);
  encoder.image_width = encoder.image_height = static_cast<JDIMENSION>(side);
  encoder.input_components = 3;
  encoder.in_color_space = JCS_RGB;
  jpeg_set_defaults(&encoder);
  jpeg_set_quality(&encoder, 90, TRUE);
  jpeg_start_compress(&encoder, TRUE);
  FileBytes row(3 * static_cast<std::size_t>(side));
  for (int y = 0; y < side; ++y) {
    paint_row(y, side, row.data());
    JSAMPROW rows[] = {row.data()};
    jpeg_write_scanlines(&encoder, rows, 1);
  }
  jpeg_finish_compress(&encoder);
  FileBytes bytes(file, file + size);
  jpeg_destroy_compress(&encoder);
  std::free(file);
  return bytes;
}

class Bench {
 public:
  explicit Bench(std::string format) : format_(std::move(format)) {}

  template <class Step>
  auto measure(const char* name, const Step& step) {
    StepCost cost;
    auto made = measured(std::string("bench_texture: ") + name, step, cost);
    cost.peak_mib -= formed_mib_;
    rows_.push_back({name, cost});
    return made;
  }
  // The seconds of one step less those of another.
  void add_difference(const char* name, std::string_view step, std::string_view less) {
    const auto cost_of = [&](std::string_view of) {
      return std::find_if(rows_.begin(), rows_.end(), [&](const Row& row) { return row.step == of; })->cost;
    };
    StepCost cost = cost_of(step);
    cost.seconds -= cost_of(less).seconds;
    cost.cpu_seconds -= cost_of(less).cpu_seconds;
    rows_.push_back({name, cost});
  }
  // What follows is on top of what there is now.
  void formed() { formed_mib_ = status_mib("VmRSS:"); }

  void print(bool json) const {
    auto list = nlohmann::ordered_json::array();
    if (!json) std::printf("%-6s %-40s %7s %7s %6s\n", "format", "step", "s", "CPU s", "MiB");
    for (const Row& row : rows_)
      if (json)
        list.push_back({{"format", format_},
                        {"step", row.step},
                        {"seconds", row.cost.seconds},
                        {"cpu_seconds", row.cost.cpu_seconds},
                        {"peak_mib", row.cost.peak_mib}});
      else
        std::printf("%-6s %-40s %7.2f %7.2f %6.0f\n", format_.c_str(), row.step.c_str(), row.cost.seconds,
                    row.cost.cpu_seconds, row.cost.peak_mib);
    if (json) std::printf("%s\n", list.dump(2).c_str());
  }

 private:
  struct Row {
    std::string step;
    StepCost cost;
  };
  std::string format_;
  std::vector<Row> rows_;
  double formed_mib_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  int side = 8192;
  std::string format = "png";
  bool json = false;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word == "--json") {
      json = true;
    } else if (i + 1 < argc && word == "--side") {
      side = std::atoi(argv[++i]);
    } else if (i + 1 < argc && word == "--format") {
      format = argv[++i];
    } else {
      std::fprintf(stderr, "usage: bench_texture [--side PIXELS] [--format png|jpeg] [--json]\n");
      return 2;
    }
  }
  if (side < 1 || side > largest_texture_side || (format != "png" && format != "jpeg")) {
    std::fprintf(stderr, "bench_texture: sides are 1 to 16384 pixels, formats png and jpeg\n");
    return 2;
  }
  const ScanImage image{"image 0", format == "png" ? png_texture(side) : jpeg_texture(side)};
  const PaintedModel model = painted_model(Model::mask);
  const FileBytes scan = textured_glb(model.mesh, model.uv, image.bytes, "mask");
  Settings settings;
  settings.pattern.source = PatternSource::scan;
  const Context context;
  Bench bench(format);
  const auto mold =
      bench.measure("scan", [&] { return make_mold(scan, "mask.glb", settings.scan, context); });
  const auto form_sheet = [&] {
    return form(mold, settings.sheet, settings.machine, settings.forming, TemperatureField(140), context);
  };
  const auto sheet = bench.measure("forming", form_sheet);
  const InkedSurface surface = inked_surface(sheet, settings.pattern.inked_face);
  const auto flattening = bench.measure(
      "flattening", [&] { return flatten(sheet, surface, mold, settings.flattening, context); });
  const ChartedSurface charted(surface, flattening);
  const Placement placement = lay_flat(charted);
  bench.formed();

  bench.measure("the texture alone: decoding",
                [&] { return Texture::read(image, "mask.glb", most_texture_pixels); });
  bench.measure("reading scan and texture, pyramid",
                [&] { return read_coloured_scan(scan, "mask.glb", context); });
  // As a job does.
  ColouredScan coloured = bench.measure("forming, and reading meanwhile", [&] {
    Result<ColouredScan> read;
    together([&] { form_sheet(); }, [&] { read = read_coloured_scan(scan, "mask.glb", context); });
    return read;
  });
  bench.add_difference("1 reading: forming is later by", "forming, and reading meanwhile", "forming");
  const SheetColours colours = bench.measure("2 distances, hidden surface", [&]() -> Result<SheetColours> {
    return SheetColours(ColouredSurface(std::move(coloured), mold.placing), sheet,
                        colour_reach(settings.scan.clearance_mm, settings.pattern.fade_mm));
  });
  const Pattern picture =
      bench.measure("3 picture of previews", [&] { return picture_of(colours, settings.sheet, context); });
  const Print print = bench.measure("4 print: sampling and files", [&] {
    const auto source = colour_layer(printed_colours(colours, surface, settings.print),
                                     picture_layer(picture, placement, nullptr, false));
    return make_print({.charted = charted,
                       .placement = placement,
                       .settings = settings,
                       .label = {"benchmark"},
                       .layers = {{.name = "print", .source = source}}},
                      context);
  });
  bench.measure("the print alone: sampling", [&]() -> Result<std::size_t> {
    const ColourRaster raster(colours, print.grid);
    std::size_t bytes = 0;
    for (int top = 0; top < print.grid.height; top += raster.band_rows())
      bytes += raster.rows(top, std::min(top + raster.band_rows(), print.grid.height)).size();
    return bytes;
  });
  ColourErrors errors = bench.measure("5 comparison with the scan", [&] {
    return colour_errors(print, settings.sheet.resolution_mm, context);
  });
  Finished finished{.settings = settings,
                    .mold = mold,
                    .sheet = sheet,
                    .surface = surface,
                    .flattening = flattening,
                    .pattern = picture,
                    .placement = placement,
                    .print = print,
                    .alignment = {.shift_mm = -flattening.top_rest},
                    .label = "benchmark"};
  finished.figures.errors = std::move(errors);
  bench.measure("6 report, previews and other files", [&] {
    add_chart_figures(finished);
    report(finished);
    return artifacts(finished, context);
  });
  bench.print(json);
}
