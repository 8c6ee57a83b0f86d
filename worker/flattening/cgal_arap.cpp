#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_parameterization/ARAP_parameterizer_3.h>
#include <CGAL/Surface_mesh_parameterization/parameterize.h>

#include "worker/flattening/methods.hpp"

namespace vacuform {

Result<FlatteningOutcome> flatten_cgal_arap(Chart& chart, const Context& context,
                                            std::optional<double> lambda) {
  namespace parameterization = CGAL::Surface_mesh_parameterization;
  using Kernel = CGAL::Simple_cartesian<double>;
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  using Vertex = Mesh::Vertex_index;
  const auto refuse = [](const std::string& why) {
    return fail(Code::unusable_surface, "CGAL's ARAP cannot flatten this region: " + why, "flattening.method",
                "use flattening.method = arap");
  };

  VACUFORM_CHECK(context.step(Stage::flattening, 0));
  Mesh mesh;
  for (const auto& p : chart.inked) mesh.add_vertex({p.x(), p.y(), p.z()});
  for (const Triangle& t : chart.triangles)
    if (mesh.add_face(Vertex(t[0]), Vertex(t[1]), Vertex(t[2])) == Mesh::null_face())
      return refuse("it is not a manifold");

  const auto border = CGAL::Polygon_mesh_processing::longest_border(mesh).first;
  if (border == Mesh::null_halfedge()) return refuse("it has no border");
  auto [uv, created] = mesh.add_property_map<Vertex, Kernel::Point_2>("v:uv");
  (void)created;
  const parameterization::ARAP_parameterizer_3<Mesh> method =
      lambda ? parameterization::ARAP_parameterizer_3<Mesh>(*lambda)
             : parameterization::ARAP_parameterizer_3<Mesh>();
  const auto code = parameterization::parameterize(mesh, method, border, uv);
  if (code != parameterization::OK) return refuse("its error " + std::to_string(static_cast<int>(code)));
  for (std::size_t i = 0; i < chart.uv.size(); ++i) {
    const auto& p = uv[Vertex(static_cast<Mesh::size_type>(i))];
    chart.uv[i] = {p.x(), p.y()};
  }
  VACUFORM_CHECK(context.step(Stage::flattening, 1));
  return FlatteningOutcome{50, true};  // CGAL's fixed number of iterations
}

}  // namespace vacuform
