// The bundled sample: a head form and a coil pattern that the project makes itself, so that a first run needs
// no patient's scan and no licence. `vacuform sample` writes them; tests and benchmarks read them from here.
// Both are deterministic.
#pragma once

#include <string>

#include "worker/surface/triangle_mesh.hpp"

namespace vacuform {

enum class HeadForm { adult, newborn };

// A smooth head form without a face, closed, oriented outwards, mm, Z up, front +Y, resting on z = 0.
// The adult's measures lie between the means of women and men of the 2012 survey of US Army personnel (Gordon
// et al. 2014, Natick/TR-15/007): breadth 152, length 195 (glabella to opisthocranion), circumference 564. The
// vault rises 88 above the widest level without an undercut; below it the form tapers into a neck, which is one.
// The newborn's is the same form at 0.61 of the size: circumference 344, between the medians of girls (339) and
// boys (345) at birth (WHO child growth standards, 2007).
TriangleMesh sample_head(HeadForm form = HeadForm::adult);

// Nineteen overlapping loops of 45 mm in a hexagonal array, as an SVG in millimetres. Neighbours are 0.75802
// diameters apart, where coplanar circles have no mutual inductance (Roemer et al. 1990, "The NMR phased
// array"). The lines are 2.5 mm wide, which leaves room for bridges between the crossings. Each loop is one <g id="coil-1"> ... <g id="coil-19">.
std::string sample_pattern();

}  // namespace vacuform
