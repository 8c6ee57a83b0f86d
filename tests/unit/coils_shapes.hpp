// A formed sheet that is a sphere, and drawings of rings, for the tests of worker/coils.
#pragma once

#include "tests/unit/hand_made_sheets.hpp"
#include "worker/pattern/drawing.hpp"

namespace vacuform::hand_made {

// The sheet as the top of a sphere: every point lands as far from the pole along the sphere as it lay from the sheet's
// centre, and the chart is the sheet itself. All of it within `reach` mm is the chart.
inline Sample sphere(double radius, double side, int n, double reach = 1e9) {
  Sample x = grid(side, n);
  for (std::size_t i = 0; i < x.sheet.rest.size(); ++i) {
    const Vector2d st = x.sheet.rest[i];
    const double r = st.norm(), a = r / radius;
    const Vector2d along = r > 0 ? Vector2d(st / r) : Vector2d(1, 0);
    x.sheet.formed[i] = {radius * std::sin(a) * along.x(), radius * std::sin(a) * along.y(),
                         radius * std::cos(a)};
    x.sheet.contact[i] = Contact::mold;
  }
  x.mold.top = {0, 0, radius};
  lay_chart(x, reach, [](const Vector2d& st) { return st; });
  return x;
}

// The sphere with bumps on it, so close and high that geodesics cross within some millimetres.
inline Sample bumpy_sphere(double radius, double side, int n, double height_mm, double reach = 1e9) {
  Sample x = sphere(radius, side, n, reach);
  for (std::size_t i = 0; i < x.sheet.rest.size(); ++i) {
    const Vector2d st = x.sheet.rest[i] / 3;
    x.sheet.formed[i] *= 1 + height_mm / radius * std::cos(st.x()) * std::cos(1.1 * st.y());
  }
  x.flattening.inked = x.sheet.formed;
  return x;
}

inline Element ring(const std::string& id, const Vector2d& centre, double radius, double width = 3) {
  const double k = 0.5522847498 * radius;
  Curve circle;
  circle.closed = true;
  for (const Vector2d& p :
       {Vector2d(radius, 0), Vector2d(radius, k), Vector2d(k, radius), Vector2d(0, radius),
        Vector2d(-k, radius), Vector2d(-radius, k), Vector2d(-radius, 0), Vector2d(-radius, -k),
        Vector2d(-k, -radius), Vector2d(0, -radius), Vector2d(k, -radius), Vector2d(radius, -k),
        Vector2d(radius, 0)})
    circle.points.push_back(centre + p);
  Shape shape;
  shape.curves = {circle};
  shape.stroke = Stroke{};
  shape.stroke->width_mm = width;
  return {id, centre, {shape}};
}

// One in the middle and six around it.
inline Drawing seven_rings(double radius, double apart) {
  Drawing out;
  out.size_mm = Vector2d::Constant(2 * (apart + radius));
  out.elements.push_back(ring("coil-0", {0, 0}, radius));
  for (int i = 0; i < 6; ++i)
    out.elements.push_back(ring("coil-" + std::to_string(i + 1),
                                apart * Vector2d(std::cos(i * M_PI / 3), std::sin(i * M_PI / 3)), radius));
  return out;
}

}  // namespace vacuform::hand_made
