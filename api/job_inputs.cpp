#include "api/job_inputs.hpp"

#include <string>

namespace vacuform {

std::optional<bool> asks_for(const Settings& settings, std::string_view input) {
  if (input == "scan") return true;
  if (input == "pattern") return settings.pattern.source != PatternSource::scan;
  if (input == "temperature") return settings.heat.source == HeatSource::measured;
  if (input == "weights") return settings.flattening.weights == FlatteningWeights::painted;
  return {};
}

void use_inputs(const HasInput& has, Settings& settings) {
  if (has("temperature") && settings.heat.source == HeatSource::uniform)
    settings.heat.source = HeatSource::measured;
  if (has("weights") && settings.flattening.weights == FlatteningWeights::uniform)
    settings.flattening.weights = FlatteningWeights::painted;
}

Result<void> check_inputs(JobKind kind, const HasInput& has, const Settings& settings) {
  const bool prints_scan = settings.pattern.source == PatternSource::scan;
  for (const InputKind& input : input_kinds) {
    const std::string name(input.name);
    const bool given = has(name);
    if (needs(kind, input, prints_scan) && !given)
      return fail(
          Code::bad_usage, "there is no " + name + ", or it is empty", name,
          "choose a file: " + std::string(input.extensions) +
              (name == "pattern" ? "; or print the colours of the scan with pattern.source=scan" : ""));
    const auto asked = asks_for(settings, name);
    if (input.always || !asked || given == *asked || (!given && !uses(kind, input))) continue;
    const std::string setting = name == "temperature" ? "heat.source" : "flattening.weights",
                      value = name == "temperature" ? "measured" : "painted";
    return fail(Code::bad_settings,
                given ? "a file is given as " + name + ", but the settings do not use it"
                      : "the settings ask for a file that is not given: " + name,
                setting,
                "give the file as --" + name + " FILE, or as the form field " + name + ", together with " +
                    setting + "=" + value);
  }
  if (kind == JobKind::print && prints_scan && has("pattern"))
    return fail(Code::bad_settings, "a pattern is given, but the colours of the scan are to be printed",
                "pattern.source", "leave the pattern out, or give pattern.source=file or both");
  return {};
}

}  // namespace vacuform
