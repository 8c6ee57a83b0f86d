// The steps in which the conductors of a face are printed, and the layers of a drawing that are named after them.
#pragma once

#include <optional>
#include <string_view>

namespace vacuform {

// In their order.
enum class PrintStep { conductor, dielectric, bridges };

// The face that a layer of a drawing names; first: none, it is that of pattern.inked_face; reverse: the other one.
enum class DrawnFace { first, reverse, outer, inner };

struct DrawnLayer {
  PrintStep step = PrintStep::conductor;
  DrawnFace face = DrawnFace::first;
  bool operator==(const DrawnLayer&) const = default;
};

// What a layer with that name is: a step (conductor, silver, copper, traces, print; dielectric, insulator; bridges, jumpers,
// crossovers, second conductor), and a face if it is not the first (reverse, inner, outer), in any order and case; also the
// names of the print's own files. Numbers of one or two digits say nothing. Words may be parted by anything but letters and
// digits. Nothing for every other name.
std::optional<DrawnLayer> drawn_layer(std::string_view name);

}  // namespace vacuform
