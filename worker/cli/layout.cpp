// vacuform layout: an array of coils made for a scan, as a pattern that a person can edit.
#include <charconv>
#include <cstdio>
#include <fstream>
#include <memory>

#include "api/base/decimal.hpp"
#include "worker/cli/commands.hpp"
#include "worker/cli/interruptible.hpp"
#include "worker/cli/study_options.hpp"
#include "worker/coils/array_layout.hpp"
#include "worker/forming/inked_face.hpp"

namespace vacuform::cli {

namespace {

struct LayoutOptions {
  StudyOptions study;
  std::string out, region = "dome", diameter = "fitted";
  int count = 16;
};

Result<ArrayWish> wish_of(const LayoutOptions& o) {
  ArrayWish wish;
  wish.count = o.count;
  wish.region = o.region == "front"  ? ArrayRegion::front
                : o.region == "back" ? ArrayRegion::back
                                     : ArrayRegion::dome;
  if (o.diameter == "fitted") return wish;
  double mm = 0;
  const char* end = o.diameter.data() + o.diameter.size();
  const auto read = std::from_chars(o.diameter.data(), end, mm);
  if (read.ec != std::errc() || read.ptr != end || !(mm >= 10 && mm <= 300))
    return fail(Code::bad_usage, "the diameter is not a number from 10 to 300", "--diameter_mm",
                "give 10 to 300, or fitted");
  wish.diameter_mm = mm;
  return wish;
}

void print_coupling(const char* of_what, const std::optional<StrongestPair>& pair, const Array& array) {
  if (!pair) return;
  const auto id = [&](int i) { return array.drawing.elements[static_cast<std::size_t>(i)].id; };
  std::printf("strongest coupling of %s: %s and %s, k = %.4f\n", of_what, id(pair->a).c_str(),
              id(pair->b).c_str(), pair->k);
}

Result<void> lay_out(const LayoutOptions& o, const Context& context, ProgressBar& bar) {
  VACUFORM_TRY(wish, wish_of(o));
  VACUFORM_TRY(study, o.study.read());
  const Settings& s = study.settings;
  VACUFORM_TRY(prepared, o.study.prepare(study, context));
  VACUFORM_TRY(sheet, form(prepared.mold, s.sheet, s.machine, s.forming, prepared.temperature, context));
  const InkedSurface surface = inked_surface(sheet, s.pattern.inked_face);
  VACUFORM_TRY(flattening, flatten(sheet, surface, prepared.mold, s.flattening, context));
  VACUFORM_TRY(array, lay_out_array(ChartedSurface(surface, flattening), wish, s.coils, context));
  const std::string what = std::to_string(o.count) + " coils, " + decimal(array.diameter_mm, 1) +
                           " mm, centres " + decimal(array.spacing_mm, 2) + " mm apart";
  std::ofstream out(o.out, std::ios::binary | std::ios::trunc);
  out << svg_of_rings(array.drawing, what);
  out.close();
  if (!out)
    return fail(Code::unreadable, "the file cannot be written", o.out,
                "check the folder's permissions and the free space");
  bar.clear();
  std::printf("%s on the head, spacing %.2f mm rms over %d pairs\n", what.c_str(), array.spacing_rms_mm,
              array.pairs);
  print_coupling("neighbours", array.strongest_neighbours, array);
  print_coupling("any two coils", array.strongest, array);
  if (array.off_head > 0) std::printf("%d of them do not lie wholly on the formed part\n", array.off_head);
  return {};
}

}  // namespace

void add_layout(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<LayoutOptions>();
  CLI::App* command = app.add_subcommand(
      "layout", "Make a pattern of decoupled coils for a scan: use it with --set coils.decouple=true");
  options->study.add_to(*command);
  command->add_option("--count", options->count, "Number of coils")->required()->check(CLI::Range(4, 64));
  command
      ->add_option("--diameter_mm", options->diameter,
                   "Of the coils, or fitted: as large as covers the region")
      ->type_name("D|fitted");
  command
      ->add_option(
          "--region", options->region,
          "The whole dome, or its front (towards +y of the mold; scan.yaw_deg turns the head) or back half")
      ->check(CLI::IsMember({"dome", "front", "back"}));
  command->add_option("--out", options->out, "SVG file for the pattern")->required()->type_name("FILE");
  command->callback([options, &exit_code] {
    exit_code = run_interruptible(
        [&](const Context& context, ProgressBar& bar) { return lay_out(*options, context, bar); });
  });
}

}  // namespace vacuform::cli
