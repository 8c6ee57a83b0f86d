#include "worker/pipeline/pipeline.hpp"

#include <nlohmann/json.hpp>

#include "api/base/sha256.hpp"
#include "api/job_inputs.hpp"
#include "api/version.hpp"
#include "worker/conductors/covered_pads.hpp"
#include "worker/forming/inked_face.hpp"
#include "worker/inspection/array_files.hpp"
#include "worker/inspection/circuit_figures.hpp"
#include "worker/inspection/colour_errors.hpp"
#include "worker/inspection/inspection.hpp"
#include "worker/inspection/report_html.hpp"
#include "worker/pipeline/artifact_files.hpp"
#include "worker/pipeline/laid_pattern.hpp"
#include "worker/pipeline/print_progress.hpp"
#include "worker/pipeline/scan_inspection.hpp"
#include "worker/printing/inked_rings.hpp"
#include "worker/stage/parallel.hpp"

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

// The files of a job that say what is printed.
struct PrintFiles {
  std::optional<Pattern> pattern, weights;
  OutputProfile profile;
};
Result<PrintFiles> read_files(const Inputs& inputs) {
  PrintFiles files;
  const Settings& s = inputs.settings;
  if (s.pattern.source != PatternSource::scan) {
    VACUFORM_TRY(pattern, Pattern::read(inputs.pattern->bytes, inputs.pattern->name, s.pattern, s.print.dpi));
    files.pattern = std::move(pattern);
  }
  if (const auto& file = inputs.weights) {
    PatternSettings as_the_pattern = s.pattern;
    as_the_pattern.width_mm = files.pattern->size_mm().x();
    VACUFORM_TRY(weights, Pattern::read(file->bytes, file->name, as_the_pattern, s.print.dpi));
    files.weights = std::move(weights);
  }
  if (const auto& file = inputs.icc) {
    VACUFORM_TRY(profile, OutputProfile::read(file->bytes, file->name));
    files.profile = std::move(profile);
  }
  return files;
}

// Where the flattening weighs the pattern: by its ink, or by that of the weight image. Keeps references.
InkCoverage coverage_of(const PrintFiles& files, const PatternSettings& settings) {
  if (!files.pattern) return {};
  return [&weights = files.weights ? *files.weights : *files.pattern, &settings](const Eigen::Vector2d& chart,
                                                                                 double blur_mm) {
    return weights.sample(plain_alignment(settings).pattern(chart), blur_mm / settings.scale).coverage();
  };
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

// Of a drawing; the colours of a scan are compared with the scan.
LengthErrors lengths_of(const LaidPattern& laid, const VectorPrint* vectors, const PatternSettings& settings,
                        std::vector<Warning>& warnings) {
  if (settings.source == PatternSource::scan) return {};
  const Drawing* const lines = laid.placed();
  LengthErrors lengths = length_errors(lines, laid.pattern, laid.placement,
                                       vectors ? vectors->tied : std::vector<TiedPoints>(), settings.scale);
  if (auto off = length_warning(lengths, lines, settings.length_limit)) warnings.push_back(std::move(*off));
  return lengths;
}

// The conductors of both faces together: of a loop those of its own face.
VectorPrint conductors_of(const Print& print, const ArrayBuild* build) {
  VectorPrint out = *print.main().source->vectors();
  for (const Layer& layer : print.layers) {
    if (layer.step != PrintStep::conductor || &layer == &print.main()) continue;
    const std::vector<PrintedElement>& there = layer.source->vectors()->elements;
    for (std::size_t e = 0; e < there.size(); ++e)
      if (!there[e].areas.empty() && (!build || build->faces[e] == 1)) out.elements[e] = there[e];
  }
  return out;
}

std::vector<PrintedInk> ink_of(const Print& print) {
  std::vector<PrintedInk> out;
  for (const Layer& layer : print.layers)
    if (const VectorPrint* const vectors = layer.source->vectors())
      out.push_back({layer.step.value_or(PrintStep::conductor), layer.face == print.main().face ? 0 : 1,
                     inked_rings(*vectors, 0.01)});
  return out;
}

// Of the loops of a vector drawing.
Result<std::optional<ElectricalCheck>> check_circuits(const LaidPattern& laid, const Print& print,
                                                      const ChartedSurface& charted,
                                                      const ChartedSurface& reverse,
                                                      const CoilSettings& settings, const Context& context) {
  if (!laid.build) return std::optional<ElectricalCheck>();
  VACUFORM_TRY(check,
               check_conductors(*laid.lines, laid.placement, *laid.build, ink_of(print),
                                {&charted.surface(), laid.build->reverse ? &reverse.surface() : nullptr},
                                settings.clearance_mm, context));
  return std::optional(std::move(check));
}

std::vector<Warning> circuit_warnings(const LaidPattern& laid, const Print& print,
                                      const ElectricalCheck& check, const CoilSettings& settings) {
  std::vector<Warning> out = check.warnings(*laid.lines, settings.clearance_mm);
  if (auto covered = covered_pads(*laid.lines, laid.placement, *laid.build, ink_of(print), settings))
    out.push_back(std::move(*covered));
  return out;
}

// What the stages made that a finished job does not show.
struct Made {
  const Identity& identity;
  const std::vector<Variant>& variants;
  const LaidPattern& laid;
};

// All stages up to the print, with the figures of its pattern.
template <class Use>
Result<std::vector<Artifact>> run_stages(const Inputs& inputs, const Use& use, const Context& context) {
  const Settings& s = inputs.settings;
  VACUFORM_CHECK(check_for(JobKind::print, s));
  VACUFORM_CHECK(check_together(inputs));
  VACUFORM_TRY(files, read_files(inputs));
  VACUFORM_TRY(head, flat_head(inputs, coverage_of(files, s.pattern), context));
  const FormedHead& formed = head.formed;
  const ChartedSurface charted(head.surface, head.flattening);
  const InkedSurface beneath = inked_surface(formed.sheet, other_face(s.pattern.inked_face));
  const ChartedSurface reverse(beneath, head.flattening);
  VACUFORM_TRY(colours, colours_on_sheet(head, inputs));
  const auto body = body_below(formed.sheet, head.surface, head.flattening, s);
  VACUFORM_TRY(laid, files.pattern ? lay_pattern(*std::move(files.pattern), inputs, charted, reverse, body,
                                                 head.cuts, context)
                                   : lay_colours(*colours, charted, s.sheet, context));
  VACUFORM_TRY(layers, layers_of(laid, colours, head.surface, s, context));
  const Identity identity = identity_of(inputs);
  const SubProgress printing(context, progress::printing), measuring(context, progress::measuring);
  VACUFORM_TRY(
      print,
      make_print({.charted = charted,
                  .placement = laid.placement,
                  .settings = s,
                  .label = {identity.label, inputs.reference, side_letters(formed.mold.findings.left_side)},
                  .layers = std::move(layers),
                  .profile = std::move(files.profile)},
                 printing.context()));
  print.warnings.insert(print.warnings.begin(), laid.warnings.begin(), laid.warnings.end());
  Finished job{.settings = s,
               .mold = formed.mold,
               .sheet = formed.sheet,
               .surface = head.surface,
               .flattening = head.flattening,
               .pattern = laid.pattern,
               .placement = laid.placement,
               .print = print,
               .placed = laid.placed(),
               .build = laid.build ? &*laid.build : nullptr,
               .reverse = &beneath,
               .lengths = lengths_of(laid, print.main().source->vectors(), s.pattern, print.warnings),
               .heat = formed.heat,
               .alignment = laid.alignment,
               .label = identity.label};
  if (laid.lines) {
    const VectorPrint vectors = conductors_of(print, job.build);
    const bool both = laid.build && laid.build->reverse;
    VACUFORM_TRY(figures, measure(charted,
                                  {*laid.lines, laid.placement, vectors, laid.alignment,
                                   both ? &reverse : nullptr, both ? laid.build->faces : std::vector<int>()},
                                  s.coils, measuring.context()));
    job.figures.measured = std::move(figures);
    VACUFORM_TRY(circuits,
                 check_circuits(laid, print, charted, reverse, s.coils, measuring.context().silent()));
    if (circuits)
      for (Warning& warning : circuit_warnings(laid, print, *circuits, s.coils))
        print.warnings.push_back(std::move(warning));
    job.figures.circuits = std::move(circuits);
    job.figures.electrical = circuit_figures(job, vectors);
    if (auto small = job.figures.electrical ? small_capacitors(job) : std::nullopt)
      print.warnings.push_back(*std::move(small));
  }
  add_chart_figures(job);
  return use(job, Made{identity, formed.variants, laid});
}

// The report with what only the pipeline knows.
nlohmann::ordered_json whole_report(const Inputs& inputs, const Finished& job, const Made& made) {
  nlohmann::ordered_json whole = {
      {"vacuform", version},
      {"label", made.identity.label},
      {"reference",
       inputs.reference.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(inputs.reference)},
      {"sha256", made.identity.sha256}};
  whole.update(report(job));
  if (!inputs.sensitivity || job.settings.pattern.source == PatternSource::scan) return whole;
  std::vector<PrintedCoil> coils =
      printed_coils(coil_centres(job.pattern), job.sheet, job.flattening, job.print.pattern_uv);
  for (const PlacedElement& element : job.placement.elements)  // the chart has them elsewhere
    for (PrintedCoil& coil : coils)
      if (coil.id == made.laid.placed()->elements[element.element].id) coil.rest = element.centre_rest;
  whole["sensitivity"] = sensitivity_json(job.sheet, made.variants, coils);
  return whole;
}

Result<std::vector<Artifact>> print_artifacts(const Inputs& inputs, const Context& context) {
  const auto inspect = [&](Finished& job, const Made& made) -> Result<std::vector<Artifact>> {
    const SubProgress comparing(context, progress::comparing), showing(context, progress::showing);
    if (job.print.coloured()) {
      VACUFORM_TRY(errors, colour_errors(job.print, grid_spacing_mm(job.settings), comparing.context()));
      job.figures.errors = std::move(errors);
    }
    Result<std::vector<Artifact>> files;
    nlohmann::ordered_json whole;
    together([&] { files = artifacts(job, showing.context()); },
             [&] { whole = whole_report(inputs, job, made); });
    if (!files) return files;
    const auto add = [&](const char* name, const std::string& text) {
      files->push_back({name, {text.begin(), text.end()}});
    };
    add("report.html", report_html(whole, *files));
    add("report.json", whole.dump(2) + "\n");
    return files;
  };
  return run_stages(inputs, inspect, context);
}

// What the mold can show: it was made, and then the sheet did not fit it, or did not form or flatten on it.
bool shows_on_mold(const Error& error) {
  return error.code == Code::does_not_fit || error.code == Code::forming_failed ||
         error.code == Code::unusable_surface;
}

}  // namespace

Result<std::vector<Artifact>> with_print(const Inputs& inputs, const UseOfPrint& use,
                                         const Context& context) {
  return run_stages(
      inputs, [&](const Finished& job, const Made&) { return use(job); }, context);
}

Result<void> run_pipeline(const Inputs& inputs, const std::filesystem::path& out, const Context& context) {
  const auto files = print_artifacts(inputs, context);
  if (files) return write_artifacts(out, *files);
  const Error& error = files.error();
  if (shows_on_mold(error)) {
    // The mold is made again, or was cached: that takes a second, and the error counts whatever comes of it.
    const SubProgress at_end(context, {Stage::forming, 1, 1});
    (void)inspect_failure(inputs, error, out, at_end.context());
  }
  return tl::make_unexpected(error);
}

}  // namespace vacuform
