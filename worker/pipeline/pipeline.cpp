#include "worker/pipeline/pipeline.hpp"

#include <nlohmann/json.hpp>

#include "api/base/sha256.hpp"
#include "api/job_inputs.hpp"
#include "api/version.hpp"
#include "worker/coils/coupled_neighbours.hpp"
#include "worker/colour/sheet_colours.hpp"
#include "worker/flattening/flattening.hpp"
#include "worker/forming/inked_face.hpp"
#include "worker/inspection/colour_errors.hpp"
#include "worker/inspection/inspection.hpp"
#include "worker/inspection/report_html.hpp"
#include "worker/pattern/drawing.hpp"
#include "worker/pattern/ink_parts.hpp"
#include "worker/pipeline/artifact_files.hpp"
#include "worker/pipeline/formed_head.hpp"
#include "worker/pipeline/scan_inspection.hpp"
#include "worker/placement/cut_lines.hpp"
#include "worker/stage/parallel.hpp"
#include "worker/stage/portion.hpp"

namespace vacuform {

namespace {

// What only shows when inputs and settings are seen together.
Result<void> check_together(const Inputs& inputs) {
  const Settings& s = inputs.settings;
  if (!s.pattern.seams.empty() && s.pattern.placement != PatternPlacement::segments)
    return fail(Code::bad_settings, "pattern.seams are given, but the drawing is not laid in segments",
                "pattern.seams", "give pattern.placement=segments as well");
  return check_inputs(
      JobKind::print, [&](std::string_view name) { return has_input(inputs, name); }, s);
}

Result<std::optional<Pattern>> weights_of(const Inputs& inputs, const Pattern& pattern) {
  if (!inputs.weights) return std::optional<Pattern>();
  PatternSettings as_the_pattern = inputs.settings.pattern;
  as_the_pattern.width_mm = pattern.size_mm().x();
  VACUFORM_TRY(picture, Pattern::read(inputs.weights->bytes, inputs.weights->name, as_the_pattern,
                                      inputs.settings.print.dpi));
  return std::optional(std::move(picture));
}

Result<OutputProfile> profile_of(const Inputs& inputs) {
  return inputs.icc ? OutputProfile::read(inputs.icc->bytes, inputs.icc->name) : OutputProfile();
}

// The same inputs, settings and version make the same print: the digest of all of them is its name.
struct Identity {
  std::string label;
  nlohmann::ordered_json sha256;
};
Identity identity_of(const Inputs& inputs) {
  nlohmann::ordered_json whole = {
      {"scan", sha256_hex(inputs.scan.bytes)}, {"settings", to_json(inputs.settings)}, {"version", version}};
  if (inputs.pattern) whole["pattern"] = sha256_hex(inputs.pattern->bytes);
  if (inputs.temperature) whole["temperature"] = sha256_hex(inputs.temperature->bytes);
  if (inputs.weights) whole["weights"] = sha256_hex(inputs.weights->bytes);
  if (inputs.icc) whole["icc"] = sha256_hex(inputs.icc->bytes);
  Sha256 digest;
  digest.add(whole.dump());
  nlohmann::ordered_json of_files = {{"scan", whole["scan"]}};
  for (const char* more : {"pattern", "temperature", "weights", "icc"})
    if (whole.contains(more)) of_files[more] = whole[more];
  return {digest.hex().substr(0, 12), std::move(of_files)};
}

// The report with what only the pipeline knows.
nlohmann::ordered_json whole_report(const Inputs& inputs, const Identity& identity, const Finished& job) {
  nlohmann::ordered_json whole = {
      {"vacuform", version},
      {"label", identity.label},
      {"reference",
       inputs.reference.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(inputs.reference)},
      {"sha256", identity.sha256}};
  whole.update(report(job));
  return whole;
}

// The artifacts but the report, and the report as JSON.
struct Inspected {
  std::vector<Artifact> files;
  nlohmann::ordered_json report;
};
Result<Inspected> inspect(const Inputs& inputs, const Identity& identity, const Finished& job,
                          const Context& context) {
  Result<std::vector<Artifact>> files;
  nlohmann::ordered_json whole;
  together([&] { files = artifacts(job, context); }, [&] { whole = whole_report(inputs, identity, job); });
  if (!files) return tl::make_unexpected(files.error());
  return Inspected{*std::move(files), std::move(whole)};
}

std::vector<Artifact> with_report(Inspected inspected) {
  std::vector<Artifact>& files = inspected.files;
  const auto add = [&](const char* name, const std::string& text) {
    files.push_back({name, {text.begin(), text.end()}});
  };
  add("report.html", report_html(inspected.report, files));
  add("report.json", inspected.report.dump(2) + "\n");
  return std::move(files);
}

// The formed head with its chart.
struct FlatHead {
  FormedHead formed;
  InkedSurface surface;
  Flattening flattening;
  std::optional<ColouredScan> colours;  // if they are printed
};
Result<FlatHead> flat_head(const Inputs& inputs, const InkCoverage& coverage, const Context& context) {
  const Settings& s = inputs.settings;
  VACUFORM_TRY(formed, form_head(inputs, context));
  InkedSurface surface = inked_surface(formed.sheet, s.pattern.inked_face);
  VACUFORM_TRY(flattening, flatten(formed.sheet, surface, formed.mold, s.flattening, context, coverage));
  return FlatHead{std::move(formed), std::move(surface), std::move(flattening), {}};
}
// With the colours of the scan, whose textures are unpacked meanwhile.
Result<FlatHead> coloured_head(const Inputs& inputs, const InkCoverage& coverage, const Context& context) {
  std::optional<Result<FlatHead>> head;
  std::optional<Result<ColouredScan>> scan;
  together([&] { head = flat_head(inputs, coverage, context); },
           [&] { scan = read_coloured_scan(inputs.scan.bytes, inputs.scan.name, context.silent()); });
  VACUFORM_TRY(flat, *std::move(head));
  VACUFORM_TRY(colours, *std::move(scan));
  flat.colours = std::move(colours);
  return flat;
}

// The colours of the scan where the sheet comes to lie on it. Keeps a reference to the sheet.
Result<SheetColours> colours_on(const FormedSheet& sheet, const Mold& mold, ColouredScan scan,
                                const Inputs& inputs) {
  const Settings& s = inputs.settings;
  SheetColours colours(ColouredSurface(std::move(scan), mold.placing), sheet,
                       colour_reach(s.scan.clearance_mm, s.pattern.fade_mm));
  if (colours.triangles().empty())
    return fail(Code::unusable_surface, "no part of the formed sheet comes near the scan", inputs.scan.name,
                "give a lower scan.trim_mm or a larger pattern.fade_mm");
  return colours;
}

// The colours of the scan as a print: the sheet's own coordinates are those of the pattern, and nothing is bent.
Result<std::vector<Artifact>> use_colours(const Inputs& inputs, const Identity& identity,
                                          const UseOfPrint& use, const Context& context) {
  const Settings& s = inputs.settings;
  VACUFORM_TRY(profile, profile_of(inputs));
  VACUFORM_TRY(head, coloured_head(inputs, {}, context));
  const FormedHead& formed = head.formed;
  const ChartedSurface charted(head.surface, head.flattening);
  const Portion looking(context, Stage::printing, 0, 0.2), printing(context, Stage::printing, 0.2, 1);
  VACUFORM_CHECK(context.step(Stage::printing, 0));
  VACUFORM_TRY(colours, colours_on(formed.sheet, formed.mold, *std::move(head.colours), inputs));
  VACUFORM_TRY(picture, picture_of(colours, s.sheet, looking.context()));
  const Placement placement = lay_flat(charted);
  const PrintLabel label{identity.label, inputs.reference, side_letters(formed.mold.findings.left_side)};
  VACUFORM_TRY(print, make_print(charted, picture, nullptr, placement, s, label, printing.context(), &colours,
                                 profile));
  Finished job{.settings = s,
               .mold = formed.mold,
               .sheet = formed.sheet,
               .surface = head.surface,
               .flattening = head.flattening,
               .pattern = picture,
               .print = print,
               .heat = formed.heat,
               .alignment = {.shift_mm = -head.flattening.top_rest},
               .placement = &placement,
               .label = identity.label,
               .colours = &colours};
  add_chart_figures(job);
  return use(job);
}

Result<std::vector<Artifact>> colour_artifacts(const Inputs& inputs, const Context& context) {
  const Identity identity = identity_of(inputs);
  const auto use = [&](const Finished& job) -> Result<std::vector<Artifact>> {
    const Portion comparing(context, Stage::inspection, 0, 0.2), showing(context, Stage::inspection, 0.2, 1);
    const auto ink = ink_of(job.print, job.surface, job.settings.print.ink_curve);
    VACUFORM_TRY(errors, colour_errors(*job.colours, job.print, ink ? &*ink : nullptr,
                                       grid_spacing_mm(job.settings), comparing.context()));
    Finished compared = job;
    compared.figures.errors = std::move(errors);
    VACUFORM_TRY(inspected, inspect(inputs, identity, compared, showing.context()));
    return with_report(std::move(inspected));
  };
  return use_colours(inputs, identity, use, context);
}

Result<std::vector<Artifact>> print_artifacts(const Inputs& inputs, const Context& context) {
  const Settings& s = inputs.settings;
  VACUFORM_CHECK(check_for(JobKind::print, s));
  VACUFORM_CHECK(check_together(inputs));
  if (s.pattern.source == PatternSource::scan) return colour_artifacts(inputs, context);
  VACUFORM_TRY(pattern, Pattern::read(inputs.pattern->bytes, inputs.pattern->name, s.pattern, s.print.dpi));
  VACUFORM_TRY(weights, weights_of(inputs, pattern));
  VACUFORM_TRY(profile, profile_of(inputs));
  const InkCoverage coverage = [&](const Eigen::Vector2d& chart, double blur_mm) {
    return (weights ? *weights : pattern)
        .sample(plain_alignment(s.pattern).pattern(chart), blur_mm / s.pattern.scale)
        .coverage();
  };
  VACUFORM_TRY(head, s.pattern.source == PatternSource::both ? coloured_head(inputs, coverage, context)
                                                             : flat_head(inputs, coverage, context));
  FormedHead& formed = head.formed;
  // The steps from the cuts to the print share one stage of the job's progress.
  const Portion cutting(context, Stage::printing, 0, 0.05), placing(context, Stage::printing, 0.05, 0.2),
      decoupling(context, Stage::printing, 0.2, 0.4), printing(context, Stage::printing, 0.4, 1);
  VACUFORM_TRY(cut, with_cut_lines(std::move(formed.sheet), std::move(head.surface),
                                   std::move(head.flattening), s.pattern.seams, cutting.context()));
  const FormedSheet& sheet = cut.sheet;
  const Flattening& flattening = cut.flattening;
  const ChartedSurface charted(cut.surface, flattening);
  const Identity identity = identity_of(inputs);

  std::vector<Warning> of_drawing;
  const std::optional<Drawing> drawing = read_drawing(inputs.pattern->bytes, pattern, of_drawing);
  const Drawing* lines = drawing ? &*drawing : nullptr;
  const auto parts = lines ? std::nullopt : parts_to_place(pattern, s.pattern.placement, of_drawing);
  const Drawing* const laid = parts ? &parts->drawing() : lines;
  VACUFORM_TRY(placement, place(charted, laid, s, placing.context(), cut.edges));
  if (laid) VACUFORM_CHECK(add_couplings(charted, *laid, s, decoupling.context(), placement));
  std::optional<SheetColours> below;  // the drawing
  if (head.colours) {
    VACUFORM_TRY(colours, colours_on(sheet, formed.mold, *std::move(head.colours), inputs));
    below.emplace(std::move(colours));
  }
  const SheetColours* const colours = below ? &*below : nullptr;
  const PrintLabel label{identity.label, inputs.reference, side_letters(formed.mold.findings.left_side)};
  VACUFORM_TRY(
      print, make_print(charted, pattern, lines, placement, s, label, printing.context(), colours, profile));
  for (const auto* warnings : {&placement.warnings, &of_drawing})
    print.warnings.insert(print.warnings.begin(), warnings->begin(), warnings->end());
  VACUFORM_TRY(alignment, align_flat(charted, s.pattern));
  Finished job{.settings = s,
               .mold = formed.mold,
               .sheet = sheet,
               .surface = cut.surface,
               .flattening = flattening,
               .pattern = pattern,
               .print = print,
               .heat = formed.heat,
               .alignment = alignment,
               .placement = &placement,
               .label = identity.label,
               .colours = colours};
  const Portion comparing(context, Stage::inspection, 0, 0.1),
      measuring(context, Stage::inspection, 0.1, 0.3), showing(context, Stage::inspection, 0.3, 1);
  if (colours) {
    const auto ink = ink_of(print, charted.surface(), s.print.ink_curve);
    VACUFORM_TRY(compared, colour_errors(*colours, print, ink ? &*ink : nullptr, grid_spacing_mm(s),
                                         comparing.context()));
    job.figures.errors = std::move(compared);
  }
  if (lines && print.vectors) {
    VACUFORM_TRY(figures, measure(charted, *lines, placement, *print.vectors, alignment, s.coils,
                                  measuring.context()));
    job.figures.measured = std::move(figures);
  } else if (parts && s.coils.decouple) {  // a picture, whose coils are not measured
    if (auto coupled = coupling_warning(coupled_neighbours(placement, *laid), true))
      print.warnings.push_back(std::move(*coupled));
  }
  add_chart_figures(job);
  VACUFORM_TRY(inspected, inspect(inputs, identity, job, showing.context()));
  if (inputs.sensitivity) {
    auto coils =
        printed_coils(coil_centres(inputs.pattern->bytes, pattern), sheet, flattening, print.pattern_uv);
    for (const PlacedElement& element :
         placement.elements)  // what is laid one by one is not where the chart has it
      for (PrintedCoil& coil : coils)
        if (coil.id == laid->elements[static_cast<std::size_t>(element.element)].id)
          coil.rest = element.centre_rest;
    inspected.report["sensitivity"] = sensitivity_json(sheet, formed.variants, coils);
  }
  return with_report(std::move(inspected));
}

// What the mold can show: it was made, and then the sheet did not fit it, or did not form or flatten on it.
bool shows_on_mold(const Error& error) {
  return error.code == Code::does_not_fit || error.code == Code::forming_failed ||
         error.code == Code::unusable_surface;
}

}  // namespace

Result<std::vector<Artifact>> print_colours(const Inputs& inputs, const UseOfPrint& use,
                                            const Context& context) {
  VACUFORM_CHECK(check_together(inputs));
  return use_colours(inputs, identity_of(inputs), use, context);
}

Result<void> run_pipeline(const Inputs& inputs, const std::filesystem::path& out, const Context& context) {
  const auto files = print_artifacts(inputs, context);
  if (files) return write_artifacts(out, *files);
  const Error& error = files.error();
  if (shows_on_mold(error)) {
    // The mold is made again, or was kept: that takes a second, and the error counts whatever comes of it.
    const Portion at_end(context, Stage::forming, 1, 1);
    (void)inspect_failure(inputs, error, out, at_end.context());
  }
  return tl::make_unexpected(error);
}

}  // namespace vacuform
