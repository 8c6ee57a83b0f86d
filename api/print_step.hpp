// The steps in which the conductors of a face are printed, and the layers of a drawing that are named after them.
#pragma once

#include <optional>
#include <string_view>

namespace vacuform {

// In their order. Resist covers the finished circuits of a face, and a picture is printed over that in colours of its own.
enum class PrintStep { conductor, dielectric, bridges, resist, picture };

// Whether its ink carries current.
constexpr bool conducts(PrintStep step) { return step == PrintStep::conductor || step == PrintStep::bridges; }
// Whether its ink makes circuits or parts them. The other steps lie over circuits and change nothing about them.
constexpr bool of_circuits(PrintStep step) { return step < PrintStep::resist; }

// The face that a layer of a drawing names; first: none, it is that of pattern.inked_face; reverse: the other one.
enum class DrawnFace { first, reverse, outer, inner };

struct DrawnLayer {
  PrintStep step = PrintStep::conductor;
  DrawnFace face = DrawnFace::first;
  bool openings = false;  // of a resist that covers the page of the drawing otherwise
  bool operator==(const DrawnLayer&) const = default;
};

// What a layer with that name is: a step (conductor, silver, copper, traces, print; dielectric, insulator; bridges, jumpers,
// crossovers, second conductor; resist, solder mask, cover, overcoat, encapsulant; picture, artwork, image, decoration,
// colour, legend, silkscreen), and a face if it is not the first (reverse, inner, outer), in any order and case; "openings"
// makes a resist what its shapes leave free. Also the names of the print's own files, and of KiCad's layers: F.Cu, B.Cu,
// F.SilkS, B.SilkS, and F.Mask and B.Mask, which show openings; with "invert" (svg2shenzhen) they show the resist. Numbers of one or two digits say nothing. Words may be parted by anything but letters and
// digits. Nothing for every other name.
std::optional<DrawnLayer> drawn_layer(std::string_view name);

}  // namespace vacuform
