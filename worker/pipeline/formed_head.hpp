// The scan and forming stages of a job, made or cached: the sheet on the head, which prints and layouts share.
#pragma once

#include <vector>

#include "worker/forming/heat/sheet_temperature.hpp"
#include "worker/pipeline/inputs.hpp"
#include "worker/studies/sensitivity.hpp"

namespace vacuform {

struct FormedHead {
  Mold mold;
  FormedSheet sheet;  // with the warnings of everything up to it
  HeatSummary heat;
  std::vector<Variant> variants;  // if the sensitivity is asked for
};

// Uses the scan, the temperature and the settings. Errors: those of the stages.
Result<FormedHead> form_head(const Inputs& inputs, const Context& context);

}  // namespace vacuform
