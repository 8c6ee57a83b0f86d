// What share of the half space over a small flat element a parallel rectangle fills, weighted by the cosine: the view
// factor from the element to the rectangle. Exact, by signed corner sums (Howell, A Catalog of Radiation Heat Transfer
// Configuration Factors, B-4; Hamilton and Morgan, NACA TN 2836, 1952).
#pragma once

namespace vacuform {

// The rectangle spans x0..x1 and y0..y1 as seen from the element, `height` away along its normal, all in one unit.
// It may lie anywhere, beside the element too. height > 0.
double view_factor(double x0, double x1, double y0, double y1, double height);

}  // namespace vacuform
