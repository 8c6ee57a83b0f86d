#pragma once

namespace vacuform {

// The steps of printing the conductors of a face, in their order.
enum class PrintStep { conductor, dielectric, bridges };

}  // namespace vacuform
