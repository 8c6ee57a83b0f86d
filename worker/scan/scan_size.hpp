// How large a scan is. Most files do not state their unit; it is guessed from the longest side, and only sizes that a
// head can have are proposed.
//
// Longest sides in mm, of a scan with or without face and neck:
//   newborn, preterm or at term   60 to 150
//   child                        120 to 260
//   adult                        165 to 320
//   head with shoulders          280 to 700
// docs/how-to/scan.md names the sources. A smaller scan is a figurine.
#pragma once

#include <string>
#include <vector>

#include "api/settings.hpp"
#include "worker/stage/warning.hpp"

namespace vacuform {

double millimetres(Unit unit);  // in one unit

// Whether a scan may be that large: 10 to 4000 mm.
bool usable_side(double mm);

// What a scan of that longest side can be: "a newborn's or a child's head", "a figurine".
std::string kinds_of_size(double mm);

// The unit in which the longest side measures 80 to 400 mm. Feet are never guessed, because a scan in metres is far more
// common. Error: ambiguous_units if no unit or more than one fits. It proposes each unit in which the size is that of a
// head or, in mm, cm, m or inches, of a figurine above 30 mm. If no unit fits, or if the longest side is 1 or 2, as
// of a model that was scaled to a unit cube, it asks for the measured size and proposes none.
Result<Unit> guess_unit(double longest_side, const std::string& where);

struct ScanSize {
  double mm_per_unit = 1;
  Unit unit = Unit::mm;  // as used; says nothing if the size is given
  bool unit_guessed = false, size_given = false;
  // "units-guessed": another unit would also make the scan a head or a figurine, or the unit is um, which is rare;
  // proposes the other units. "size-unusual": the longest side is outside of 60 to 700 mm, although unit or size are
  // given; proposes units that make it a head.
  std::vector<Warning> warnings = {};
};

// By scan.size_mm, otherwise scan.units, otherwise guess_unit(). Both lengths are in the unit of the file: `longest` is
// the longest side along its axes, `own_longest` that of the scan itself, however it is turned about the vertical axis.
// Errors: those of guess_unit(); unusable_scan if the given unit makes it larger or smaller than usable_side() allows.
Result<ScanSize> choose_size(const ScanSettings& settings, const std::string& where, double longest,
                             double own_longest);

}  // namespace vacuform
