#include "worker/inspection/heat_maps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"
#include "api/job.hpp"
#include "worker/forming/material.hpp"

namespace vacuform {

namespace {

// cividis in ten steps (Nunez, Anderton, Renslow 2018, doi 10.1371/journal.pone.0199239): even steps look even, also
// without colour vision and in gray.
constexpr std::array<std::uint32_t, 10> cividis{0x00204d, 0x00336f, 0x39486b, 0x575c6d, 0x707173,
                                                0x8a8779, 0xa69d75, 0xc4b56c, 0xe4cf5b, 0xffea46};
// Bright where the sheet touches, so that its ink is seen.
constexpr std::array<std::uint32_t, 10> cividis_reversed = [] {
  auto reversed = cividis;
  std::reverse(reversed.begin(), reversed.end());
  return reversed;
}();
// The upper half of a diverging scale (PuOr of ColorBrewer): distortion is always given above 1.
constexpr std::array<std::uint32_t, 6> distortion_colours{0xf7f7f7, 0xfee0b6, 0xfdb863,
                                                          0xe08214, 0xb35806, 0x7f3b08};

// The whole scale: shorter than drawn, as drawn, longer.
constexpr std::array<std::uint32_t, 11> error_colours{0x2d004b, 0x542788, 0x8073ac, 0xb2abd2,
                                                      0xd8daeb, 0xf7f7f7, 0xfee0b6, 0xfdb863,
                                                      0xe08214, 0xb35806, 0x7f3b08};

std::string preview_of(std::string_view id) { return "preview-" + std::string(id) + ".png"; }

std::string spread(const Statistics& s) {
  return "mean " + decimal(s.mean, 3) + ", 95 % below " + decimal(s.p95, 3);
}
// Over everything that is coloured, and where the sheet touches.
std::string placed(const PlacedStatistics& whole, const PlacedStatistics& touching) {
  const auto words = [](const Statistics& s) {
    return "mean " + decimal(s.mean, 2) + ", 99 % below " + decimal(s.p99, 2);
  };
  return "where the sheet touches: " + words(touching.values) + "     everywhere: " + words(whole.values);
}

HeatMap distortion_map(std::string_view id, const Finished& job, const std::vector<double>& values,
                       const Statistics& statistics) {
  return {id,
          "",
          1,
          2,
          0.1,
          job.settings.pattern.distortion_limit,
          distortion_colours,
          true,
          values,
          spread(statistics)};
}

HeatMap thickness_map(const Finished& job) {
  const double whole = job.settings.sheet.thickness_mm,
               low = whole * std::min(job.settings.forming.thin_limit, 0.9);
  return {
      "thickness",
      "mm",
      low,
      whole,
      round_step((whole - low) / 10),
      {},
      cividis,
      true,
      job.sheet.thickness,
      "from " + decimal(whole, 2) + " mm; thinnest place " + decimal(job.figures.least_thickness, 3) + " mm"};
}

HeatMap temperature_map(const Finished& job) {
  const MaterialProfile plastic = material_profile(job.settings.sheet.material);
  const HeatSummary& heat = job.heat;
  return {"temperature",
          "°C",
          plastic.coldest_celsius,
          plastic.hottest_celsius,
          5,
          {},
          cividis,
          true,
          job.sheet.temperature,
          "in the window of the frame: " + decimal(heat.least, 1) + " to " + decimal(heat.most, 1) +
              " °C, mean " + decimal(heat.mean, 1) + " °C" +
              (heat.seconds ? " after " + decimal(*heat.seconds, 0) + " s under the heaters" : "")};
}

HeatMap gap_map(const Finished& job) {
  std::vector<double> values(job.sheet.contact.size(), NAN);
  double most = 0;
  for (std::size_t v = 0; v < values.size(); ++v) {
    if (job.sheet.contact[v] == Contact::mold) values[v] = 0;
    if (job.sheet.contact[v] == Contact::free) values[v] = job.figures.mold_distance[v];
    if (values[v] > most) most = values[v];
  }
  return {"gap",
          "mm",
          0,
          5,
          1,
          {},
          cividis_reversed,
          true,
          std::move(values),
          "0 where the sheet touches; largest " + decimal(most, 1) + " mm"};
}

}  // namespace

std::string_view HeatMap::title() const { return artifact_kind(preview_of(id))->title; }

Rgb HeatMap::colour(double value) const {
  const double x =
      std::clamp((value - low) / (high - low), 0.0, 1.0) * static_cast<double>(colours.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(x), colours.size() - 2);
  const float f = static_cast<float>(x - static_cast<double>(i));
  Rgb out;
  for (int k = 0; k < 3; ++k) {
    const auto part = [&](std::size_t at) { return static_cast<float>(colours[at] >> (16 - 8 * k) & 0xff); };
    out[k] = ((1 - f) * part(i) + f * part(i + 1)) / 255;
  }
  return out;
}

std::vector<HeatMap> heat_maps(const Finished& job) {
  const Figures& f = job.figures;
  std::vector<HeatMap> maps{distortion_map("shape", job, f.shape, f.without.chart.shape),
                            distortion_map("area", job, f.area, f.without.chart.area), thickness_map(job)};
  if (job.heat.source != HeatSource::uniform) maps.push_back(temperature_map(job));
  maps.push_back(gap_map(job));
  if (const auto& e = f.errors) {
    maps.push_back({"position",
                    "mm",
                    0,
                    1,
                    0.1,
                    {},
                    cividis,
                    false,
                    e->position_of_vertices,
                    placed(e->whole.position, e->touching.position)});
    maps.push_back({"colour",
                    "CIEDE2000",
                    0,
                    5,
                    1,
                    {},
                    cividis,
                    false,
                    e->colour_of_vertices,
                    placed(e->whole.colour, e->touching.colour)});
  }
  return maps;
}

HeatMap lengths_scale(const Finished& job) {
  const LengthErrors& lengths = job.lengths;
  std::vector<double> values;
  for (const LengthErrors::Piece& piece : lengths.pieces) values.push_back(100 * piece.error);
  return {"lengths",
          "% longer or shorter",
          -10,
          10,
          2,
          100 * job.settings.pattern.length_limit,
          error_colours,
          false,
          std::move(values),
          "longer or shorter than drawn by " + in_percent(lengths.mean, 1) +
              " on average, 95 % of all below " + in_percent(lengths.p95, 1) + ", at worst " +
              in_percent(lengths.worst, 1)};
}

nlohmann::ordered_json heat_maps_json(const std::vector<HeatMap>& maps) {
  auto out = nlohmann::ordered_json::array();
  for (const HeatMap& map : maps) {
    auto colours = nlohmann::ordered_json::array();
    for (const std::uint32_t colour : map.colours) {
      char text[8];
      std::snprintf(text, sizeof text, "#%06x", colour);
      colours.push_back(text);
    }
    out.push_back({{"id", map.id},
                   {"title", map.title()},
                   {"unit", map.unit},
                   {"low", map.low},
                   {"high", map.high},
                   {"step", map.step},
                   {"limit", map.limit ? nlohmann::ordered_json(*map.limit) : nlohmann::ordered_json()},
                   {"over_ink", map.over_ink},
                   {"colours", std::move(colours)}});
  }
  return out;
}

}  // namespace vacuform
