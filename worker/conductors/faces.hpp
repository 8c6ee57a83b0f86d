// Which face of the sheet each loop of an array lies on.
#pragma once

#include <vector>

#include "worker/conductors/crossings.hpp"

namespace vacuform {

// For each of `count` loops 0 or 1. If two faces suffice (the graph of the loops that cross has no odd circle), no two
// loops on one face cross. Otherwise no move of one loop or exchange of two leaves fewer crossings on a face: three loops
// that all cross need a bridge. The first loop of each connected group is on face 0. Deterministic; at most 50 rounds.
std::vector<int> choose_faces(int count, const std::vector<Crossing>& crossings);

// Those whose loops lie on that face.
std::vector<Crossing> crossings_on(int face, const std::vector<int>& faces,
                                   const std::vector<Crossing>& crossings);

}  // namespace vacuform
