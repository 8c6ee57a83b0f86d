#include "worker/scan/scan_size.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "api/base/decimal.hpp"

namespace vacuform {
namespace {

struct SizeKind {
  double least_mm, most_mm;
  const char* name;
};
constexpr std::array kinds{SizeKind{60, 150, "a newborn's"}, SizeKind{120, 260, "a child's"},
                           SizeKind{165, 320, "an adult's"}};
constexpr SizeKind bust{280, 700, "a head with shoulders"};
constexpr double least_head_mm = 60, most_head_mm = 700;
constexpr double least_figurine_mm = 30;  // a smaller one is not proposed
constexpr double least_guess_mm = 80, most_guess_mm = 400;
// A unit that is rare in scans counts if it makes at least a head of a newborn at term.
constexpr double least_in_feet_mm = 90;

// The common ones first.
constexpr std::array units{Unit::mm, Unit::cm, Unit::m, Unit::in, Unit::um, Unit::ft};

bool is_head(double mm) { return mm >= least_head_mm && mm <= most_head_mm; }

bool guessable(Unit unit, double mm) {
  return unit != Unit::ft && mm >= least_guess_mm && mm <= most_guess_mm;
}

bool is_scaled_to_a_cube(double side) { return std::abs(side - 1) < 1e-3 || std::abs(side - 2) < 1e-3; }

std::string rounded(double mm) {
  if (mm >= 1e6) return "over a kilometre";
  return decimal(mm, mm < 10 ? 1 : 0) + " mm";
}

// The units that make the scan a head, most likely ones first, then those that make it a figurine.
std::vector<Unit> possible_units(double side) {
  if (is_scaled_to_a_cube(side)) return {};
  std::vector<Unit> likely, heads, figurines;
  for (const Unit unit : units) {
    const double mm = side * millimetres(unit);
    const bool rare = unit == Unit::um || unit == Unit::ft;
    if (guessable(unit, mm))
      likely.push_back(unit);
    else if (is_head(mm) && (unit != Unit::ft || mm >= least_in_feet_mm))
      heads.push_back(unit);
    else if (!rare && mm >= least_figurine_mm && mm < least_head_mm)
      figurines.push_back(unit);
  }
  likely.insert(likely.end(), heads.begin(), heads.end());
  likely.insert(likely.end(), figurines.begin(), figurines.end());
  return likely;
}

Proposal in_unit(double side, Unit unit) {
  const double mm = side * millimetres(unit);
  return {{{"scan.units", name(unit)}}, rounded(mm) + ", " + kinds_of_size(mm)};
}

std::vector<Proposal> in_units(double side, const std::vector<Unit>& wanted) {
  std::vector<Proposal> proposals;
  for (const Unit unit : wanted)
    if (usable_side(side * millimetres(unit))) proposals.push_back(in_unit(side, unit));
  return proposals;
}

const char* const measure_it = "measure the longest side of the head and give it in mm as scan.size_mm";
// A unit that is given would contradict the size.
const char* const measure_it_instead =
    "measure the longest side of the head and give it in mm as scan.size_mm, with scan.units=auto";

tl::unexpected<Error> ask_for_size(Code code, const std::string& what, const std::string& where, double side,
                                   Unit given = Unit::automatic) {
  auto proposals = in_units(side, possible_units(side));
  const char* const measure = given == Unit::automatic ? measure_it : measure_it_instead;
  if (proposals.empty()) return fail(code, what, where, measure);
  return fail(code, what, where, "set the unit of the file", std::move(proposals), measure);
}

std::string sizes_in_all_units(double side) {
  std::string all;
  for (const Unit unit : units)
    all +=
        (all.empty() ? "" : ", ") + std::string(name(unit)) + " (" + rounded(side * millimetres(unit)) + ")";
  return all;
}

}  // namespace

double millimetres(Unit unit) {
  switch (unit) {
    case Unit::um:
      return 0.001;
    case Unit::cm:
      return 10;
    case Unit::m:
      return 1000;
    case Unit::in:
      return 25.4;
    case Unit::ft:
      return 304.8;
    case Unit::mm:
    case Unit::automatic:
      return 1;
  }
  return 1;
}

bool usable_side(double mm) { return mm >= 10 && mm <= 4000; }

std::string kinds_of_size(double mm) {
  if (mm < least_head_mm) return mm < 10 ? "smaller than a figurine" : "a figurine";
  std::string text;
  for (const SizeKind& kind : kinds)
    if (mm >= kind.least_mm && mm <= kind.most_mm)
      text += (text.empty() ? "" : " or ") + std::string(kind.name);
  if (!text.empty()) text += " head";
  if (mm >= bust.least_mm && mm <= bust.most_mm)
    text += (text.empty() ? "" : ", or ") + std::string(bust.name);
  return text.empty() ? "larger than head and shoulders" : text;
}

Result<Unit> guess_unit(double longest_side, const std::string& where) {
  std::vector<Unit> fitting;
  std::string fits;
  for (const Unit unit : units) {
    const double mm = longest_side * millimetres(unit);
    if (!guessable(unit, mm)) continue;
    fitting.push_back(unit);
    fits += (fits.empty() ? "" : ", ") + std::string(name(unit)) + " (" + rounded(mm) + ")";
  }
  if (fitting.size() == 1) return fitting.front();
  return ask_for_size(Code::ambiguous_units,
                      fitting.empty()
                          ? "the scan's unit is not clear: in none is its longest side 80 to 400 mm: " +
                                sizes_in_all_units(longest_side)
                          : "the scan's unit is not clear: its longest side is plausible in " + fits,
                      where, longest_side);
}

namespace {

std::optional<Warning> guess_warning(double side, Unit guessed) {
  auto others = possible_units(side);
  std::erase(others, guessed);
  const bool rare = guessed == Unit::um;
  if (others.empty() && !rare) return std::nullopt;
  std::string text;
  for (const Unit unit : others)
    text += (text.empty() ? "; it could be " : " or ") + std::string(name(unit)) + " (" +
            rounded(side * millimetres(unit)) + ")";
  if (rare) text += "; few scans are in it, and a file in another scale looks the same";
  Warning warning{"units-guessed", "The unit was taken to be " + std::string(name(guessed)) +
                                       ", in which the longest side is " +
                                       rounded(side * millimetres(guessed)) + text};
  warning.proposals = in_units(side, others);
  return warning;
}

Warning unusual_size(double mm, double side, std::optional<Unit> given) {
  const double limit = mm < least_head_mm ? least_head_mm : most_head_mm;
  Warning warning{"size-unusual",
                  (given ? "In " + std::string(name(*given)) + " the" : std::string("The")) +
                      " longest side is " + rounded(mm) + ": " + kinds_of_size(mm) +
                      ", not a head, which measures " + rounded(least_head_mm) + " to " +
                      rounded(most_head_mm),
                  {},
                  Warning::Figure{mm, "mm", limit}};
  if (!given) return warning;
  auto others = possible_units(side);
  std::erase_if(others, [&](Unit unit) { return !is_head(side * millimetres(unit)); });
  warning.proposals = in_units(side, others);
  return warning;
}

}  // namespace

Result<ScanSize> choose_size(const ScanSettings& settings, const std::string& where, double longest,
                             double own_longest) {
  ScanSize size;
  if (settings.size_mm) {
    size.size_given = true;
    size.mm_per_unit = *settings.size_mm / own_longest;
    if (!is_head(*settings.size_mm))
      size.warnings.push_back(unusual_size(*settings.size_mm, own_longest, std::nullopt));
    return size;
  }
  size.unit = settings.units;
  if (settings.units == Unit::automatic) {
    VACUFORM_TRY(unit, guess_unit(longest, where));
    size.unit = unit;
    size.unit_guessed = true;
    if (auto warning = guess_warning(longest, unit)) size.warnings.push_back(std::move(*warning));
  }
  size.mm_per_unit = millimetres(size.unit);
  const double side = longest * size.mm_per_unit;
  if (!usable_side(side))
    return ask_for_size(Code::unusable_scan,
                        "in " + std::string(name(size.unit)) + " the scan's longest side is " +
                            (side < 10 ? "only " : "") + in_mm(side),
                        where, longest, settings.units);
  if (!size.unit_guessed && !is_head(side)) size.warnings.push_back(unusual_size(side, longest, size.unit));
  return size;
}

}  // namespace vacuform
