// How large an SVG is. Its lengths may be in millimetres, or in pixels that are longer or shorter in each program.
// Internal to worker/pattern.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "api/settings.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

struct SizedSvg {
  // With the width, height and viewBox of its root such that nobody has to guess: both sides in mm, every length inside in
  // user units or at 96 px an inch. The same bytes if that was so before.
  std::string text;
  Eigen::Vector2d size_mm{0, 0};
  // Which unit was taken and why, a clause for people: "340.16 x 226.77 px at 72 px/in, as Adobe Illustrator counts".
  std::string size_from;
  std::vector<Warning> warnings;  // "pattern-units": lengths inside are in px, and nothing says of which size
};

// Sizes in mm, cm, in, pt and pc count as they are, whatever their case. For px, numbers without a unit and a viewBox alone
// the first of these counts: settings.width_mm, settings.dpi, the program that wrote the file (api/redaction/svg_generator.hpp:
// Illustrator 72 px/in, Inkscape 96 or, before 0.92, 90). Otherwise unusable_pattern, with the sizes that it could have and
// the settings that choose one. `text` is well-formed XML.
Result<SizedSvg> size_svg(std::string text, const std::string& file_name, const PatternSettings& settings);

// "120.0 x 80.0 mm".
std::string size_text(const Eigen::Vector2d& mm);

}  // namespace vacuform
