#include "worker/forming/heat/heating.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "api/base/decimal.hpp"
#include "worker/forming/heat/irradiance.hpp"
#include "worker/forming/heat/slab.hpp"
#include "worker/forming/heat/window.hpp"
#include "worker/forming/material.hpp"
#include "worker/stage/parallel.hpp"

namespace vacuform {

namespace {

// The temperature of thick sheet varies much through its thickness, that of thin sheet never does.
std::size_t layers_of(double thickness_mm) {
  return static_cast<std::size_t>(std::clamp(std::lround(thickness_mm / 0.1), 8l, 24l));
}

constexpr double longest_seconds = 3600;
constexpr int steps_of_heating = 40, most_steps = 400, steps_of_transfer = 4;  // at least
constexpr double longest_step = 2;                                             // seconds, up to most_steps
constexpr double aim_within = 0.05;                                            // degrees
constexpr int most_tries = 30;  // a handful suffices unless the transfer cools the sheet almost down

int samples_along(double mm) { return std::clamp(static_cast<int>(std::lround(mm / 5)) + 1, 2, 121); }

int steps_for(double seconds, int at_least) {
  return std::clamp(static_cast<int>(seconds / longest_step), at_least, most_steps);
}

double radiation(double celsius) { return stefan_boltzmann * std::pow(celsius - absolute_zero, 4); }

// All places of the sheet, advanced together.
class SheetOfSlabs {
 public:
  SheetOfSlabs(const SheetSettings& sheet, const MachineSettings& machine, const HeatSettings& heat)
      : sheet_(sheet),
        heat_(heat),
        columns_(samples_along(sheet.width_mm)),
        rows_(samples_along(sheet.height_mm)),
        slab_(
            [&] {
              const MaterialProfile m = material_profile(sheet.material);
              return SlabMaterial{m.density_kg_m3, m.heat_capacity_j_kgk, m.conductivity_w_mk, m.emissivity,
                                  m.absorption_1_mm};
            }(),
            sheet.thickness_mm, static_cast<int>(layers_of(sheet.thickness_mm))),
        layers_(layers_of(sheet.thickness_mm)),
        celsius_(static_cast<std::size_t>(columns_ * rows_) * layers_, heat.ambient_c) {
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column) {
        const Eigen::Vector2d place((static_cast<double>(column) / (columns_ - 1) - 0.5) * sheet.width_mm,
                                    (static_cast<double>(row) / (rows_ - 1) - 0.5) * sheet.height_mm);
        weights_.push_back(share_in_window(place, machine));
        places_.push_back(nearest_in_window(place, machine, 0.5));
      }
  }

  // The radiation from the heaters onto each place.
  Result<void> light(const MachineSettings& machine, const Context& context) {
    const Irradiance above(machine, heat_, Irradiance::Side::above);
    const Irradiance below(machine, heat_, Irradiance::Side::below);
    top_.resize(places_.size());
    bottom_.resize(places_.size());
    constexpr int a_block = 256;
    for (int first = 0; first < size(); first += a_block) {
      VACUFORM_CHECK(context.step(Stage::forming, 0));
      in_parallel(first, std::min(size(), first + a_block), [&](int begin, int end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
          top_[i] = above.above_surroundings(places_[i]), bottom_[i] = below.above_surroundings(places_[i]);
      });
    }
    return {};
  }

  Result<void> advance(double seconds, bool heaters, const Context& context) {
    VACUFORM_CHECK(context.step(Stage::forming, 0));
    const double surroundings = radiation(heat_.ambient_c), h = heat_.convection_w_m2k, air = heat_.ambient_c;
    in_parallel(0, size(), [&](int begin, int end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
        slab_.advance({&celsius_[i * layers_], layers_}, seconds,
                      {surroundings + (heaters ? top_[i] : 0), h, air},
                      {surroundings + (heaters ? bottom_[i] : 0), h, air});
    });
    return {};
  }

  // In equal steps, away from the heaters.
  Result<void> transfer(double seconds, const Context& context) {
    const int steps = seconds > 0 ? steps_for(seconds, steps_of_transfer) : 0;
    for (int i = 0; i < steps; ++i) VACUFORM_CHECK(advance(seconds / steps, false, context));
    return {};
  }

  double mean() const {  // over the window
    double sum = 0, weight = 0;
    for (std::size_t i = 0; i < places_.size(); ++i) sum += weights_[i] * mean_of(i), weight += weights_[i];
    return sum / weight;
  }

  // The rate at which the cold sheet warms at first, degrees a second.
  double first_rate() const {
    const double capacity = slab_.energy(std::vector<double>(layers_, 1.0));
    double sum = 0, weight = 0;
    for (std::size_t i = 0; i < places_.size(); ++i)
      sum += weights_[i] * (top_[i] + bottom_[i]), weight += weights_[i];
    return sum / weight / capacity;
  }

  HeatedSheet finish(double seconds) const {
    std::vector<double> means;
    double through = 0;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      means.push_back(mean_of(i));
      const auto [least, most] =
          std::minmax_element(&celsius_[i * layers_], &celsius_[i * layers_] + layers_);
      through = std::max(through, *most - *least);
    }
    return {TemperatureField(sheet_.width_mm, sheet_.height_mm, columns_, std::move(means)), seconds,
            through};
  }

  const std::vector<double>& state() const { return celsius_; }
  void restore(std::vector<double> state) { celsius_ = std::move(state); }

 private:
  double share_in_window(const Eigen::Vector2d& place, const MachineSettings& machine) const {
    constexpr int parts = 8;
    int inside = 0;
    for (int j = 0; j < parts; ++j)
      for (int i = 0; i < parts; ++i) {
        const Eigen::Vector2d part(((i + 0.5) / parts - 0.5) * sheet_.width_mm / (columns_ - 1),
                                   ((j + 0.5) / parts - 0.5) * sheet_.height_mm / (rows_ - 1));
        inside += in_window(place + part, machine);
      }
    return inside / static_cast<double>(parts * parts);
  }
  int size() const { return static_cast<int>(places_.size()); }
  double mean_of(std::size_t place) const {
    double sum = 0;
    for (std::size_t k = 0; k < layers_; ++k) sum += celsius_[place * layers_ + k];
    return sum / static_cast<double>(layers_);
  }

  SheetSettings sheet_;
  HeatSettings heat_;
  int columns_, rows_;
  Slab slab_;
  std::size_t layers_;
  std::vector<Eigen::Vector2d> places_;
  std::vector<double> weights_;       // the share of the place's cell that is in the window
  std::vector<double> top_, bottom_;  // W/m2 more than from the surroundings
  std::vector<double> celsius_;       // `layers_` a place, from the top
};

// Continues heating from `seconds` until the mean is `aim`; the last step is shortened to end there. Errors:
// bad_settings when that would take too long at the current rate of warming, which only falls.
Result<void> heat_to(SheetOfSlabs& slabs, double aim, double step, double& seconds, const Context& context) {
  double mean = slabs.mean();
  while (std::abs(aim - mean) > aim_within / 10 && mean < aim) {
    const auto before = slabs.state();
    VACUFORM_CHECK(slabs.advance(step, true, context));
    const double warmer = slabs.mean(), rate = (warmer - mean) / step;
    if (warmer < aim && !(rate * longest_seconds > aim - warmer))
      return fail(
          Code::bad_settings,
          "under these heaters the sheet does not become warmer than about " + decimal(warmer, 0) + " C",
          "machine.heaters",
          "give them more power, bring them nearer, shorten heat.transfer_seconds or lower "
          "heat.temperature_c");
    if (warmer > aim) {
      slabs.restore(before);
      step *= (aim - mean) / (warmer - mean);
      VACUFORM_CHECK(slabs.advance(step, true, context));
    }
    mean = slabs.mean();
    seconds += step;
  }
  return {};
}

// Until the mean has the wanted value after the transfer: aims higher by the amount that the last try cooled down.
Result<double> heat_automatically(SheetOfSlabs& slabs, const HeatSettings& heat, double wanted,
                                  const Context& context) {
  if (heat.ambient_c >= wanted)
    return fail(Code::bad_settings,
                "the surroundings are at least as warm as the wanted temperature of the sheet",
                "heat.ambient_c", "lower it, or raise heat.temperature_c");
  const double rate = slabs.first_rate();
  const double step =
      rate > 0 ? std::min((wanted - heat.ambient_c) / rate, longest_seconds) / steps_of_heating : 1;
  double seconds = 0, aim = wanted;
  for (int tries = 0;; ++tries) {
    VACUFORM_CHECK(heat_to(slabs, aim, std::max(step, 1e-3), seconds, context));
    auto heated = slabs.state();
    VACUFORM_CHECK(slabs.transfer(heat.transfer_seconds, context));
    const double mean = slabs.mean();
    if (wanted - mean < aim_within || tries == most_tries) return seconds;
    slabs.restore(std::move(heated));
    aim = heat.ambient_c + (aim - heat.ambient_c) * (wanted - heat.ambient_c) / (mean - heat.ambient_c);
  }
}

}  // namespace

Result<HeatedSheet> heat_sheet(const SheetSettings& sheet, const MachineSettings& machine,
                               const HeatSettings& heat, const Context& context) {
  SheetOfSlabs slabs(sheet, machine, heat);
  VACUFORM_CHECK(slabs.light(machine, context));
  if (!heat.seconds) {
    const double wanted = heat.temperature_c.value_or(material_profile(sheet.material).forming_celsius());
    VACUFORM_TRY(seconds, heat_automatically(slabs, heat, wanted, context));
    return slabs.finish(seconds);
  }
  const int steps = steps_for(*heat.seconds, steps_of_heating);
  for (int i = 0; i < steps; ++i) VACUFORM_CHECK(slabs.advance(*heat.seconds / steps, true, context));
  VACUFORM_CHECK(slabs.transfer(heat.transfer_seconds, context));
  return slabs.finish(*heat.seconds);
}

}  // namespace vacuform
