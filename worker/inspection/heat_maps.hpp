// The heat maps of a finished job. Previews, formed.glb, report.json, report.html and the web page show them from this one
// table, so that a quantity has one name, one range and one set of colours.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "worker/inspection/inspection.hpp"
#include "worker/inspection/view.hpp"

namespace vacuform {

struct HeatMap {
  std::string_view
      id;  // preview-ID.png, whose title in api/job.hpp is that of the map; attribute _ID of formed.glb
  std::string_view unit;                   // may be empty
  double low, high, step;                  // the range of the colours, and the distance of isolines and marks
  std::optional<double> limit;             // a tolerance of the settings
  std::span<const std::uint32_t> colours;  // 0xRRGGBB, evenly over the range; between them linear in sRGB
  bool over_ink;                           // whether the ink may be shown through
  std::vector<double> values;              // of the vertices of the sheet; NaN: none
  std::string figures;                     // a line for people

  std::string_view title() const;
  // The colour of a value, that of the nearer end outside of the range.
  Rgb colour(double value) const;
};

// Those that the job has, in the order of their previews. Ranges depend on settings and the plastic alone: jobs with the
// same settings can be compared by eye.
std::vector<HeatMap> heat_maps(const Finished& job);

// The scale of preview-lengths.png: errors of lengths, %. Its values are those of the lines, not of vertices.
HeatMap lengths_scale(const Finished& job);

// An array of {"id", "title", "unit", "low", "high", "step", "limit" or null, "over_ink", "colours": ["#rrggbb"]}.
nlohmann::ordered_json heat_maps_json(const std::vector<HeatMap>& maps);

}  // namespace vacuform
