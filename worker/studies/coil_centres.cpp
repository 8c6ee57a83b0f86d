#include "worker/studies/coil_centres.hpp"

#include <librsvg/rsvg.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <pugixml.hpp>
#include <string_view>

namespace vacuform {

namespace {

struct Release {
  void operator()(RsvgHandle* handle) const { g_object_unref(handle); }
};
using Handle = std::unique_ptr<RsvgHandle, Release>;

std::string_view local_name(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  return name.substr(name.find(':') + 1);
}

bool is_shape(std::string_view name) {
  constexpr std::string_view shapes[] = {"path", "circle",   "ellipse", "rect",
                                         "line", "polyline", "polygon", "use"};
  return std::find(std::begin(shapes), std::end(shapes), name) != std::end(shapes);
}

bool holds_groups(const pugi::xml_node& node) {
  return node.find_node(
      [](const pugi::xml_node& inner) { return local_name(inner) == "g" && inner.attribute("id"); });
}

// The ids of the coils under `node`, which is itself none.
void collect(const pugi::xml_node& node, std::vector<std::string>& ids) {
  for (const pugi::xml_node child : node.children()) {
    const std::string_view name = local_name(child);
    const std::string id = child.attribute("id").value();
    const bool layer = std::string_view(child.attribute("inkscape:groupmode").value()) == "layer";
    if (name == "g" && !id.empty() && !layer && !holds_groups(child))
      ids.push_back(id);
    else if (name == "g" || name == "svg" || name == "a")
      collect(child, ids);
    else if (is_shape(name) && !id.empty())
      ids.push_back(id);
  }
}

std::vector<CoilCentre> of_groups(std::span<const std::uint8_t> bytes, const Eigen::Vector2d& size_mm) {
  std::vector<CoilCentre> out;
  pugi::xml_document document;
  std::vector<std::string> ids;
  if (!document.load_buffer(bytes.data(), bytes.size())) return out;
  collect(document.document_element(), ids);
  const Handle handle(rsvg_handle_new_from_data(bytes.data(), bytes.size(), nullptr));
  if (!handle) return out;
  // At its size in pixels librsvg draws the document as it is, whichever viewport a version goes by.
  double width = 0, height = 0;
  const bool sized = rsvg_handle_get_intrinsic_size_in_pixels(handle.get(), &width, &height);
  const Eigen::Vector2d size = sized && width > 0 && height > 0 ? Eigen::Vector2d(width, height) : size_mm;
  const Eigen::Vector2d mm = size_mm.cwiseQuotient(size);
  const RsvgRectangle viewport{0, 0, size.x(), size.y()};
  for (const std::string& id : ids) {
    RsvgRectangle ink{}, box{};
    const std::string reference = "#" + id;
    if (!rsvg_handle_get_geometry_for_layer(handle.get(), reference.c_str(), &viewport, &ink, &box, nullptr))
      continue;
    if (!(box.width > 0) && !(box.height > 0)) continue;  // nothing is drawn
    const Eigen::Vector2d middle(box.x + box.width / 2 - size.x() / 2, size.y() / 2 - box.y - box.height / 2);
    out.push_back({id, middle.cwiseProduct(mm)});
  }
  return out;
}

// Connected parts of what is inked, on a raster of about a million points.
std::vector<CoilCentre> of_ink(const Pattern& pattern) {
  const Eigen::Vector2d size = pattern.size_mm();
  const double step = std::max(0.1, std::sqrt(size.prod() / 1e6));
  const int columns = std::max(1, static_cast<int>(size.x() / step)),
            rows = std::max(1, static_cast<int>(size.y() / step));
  const auto uv = [&](int x, int y) {
    return Eigen::Vector2d((x + 0.5) * step - size.x() / 2, size.y() / 2 - (y + 0.5) * step);
  };
  std::vector<int> parent(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), -1);
  const auto root = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      int& up = parent[static_cast<std::size_t>(i)];
      up = parent[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  };
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      if (pattern.sample(uv(x, y), step).coverage() < 0.5f) continue;
      const int here = y * columns + x;
      parent[static_cast<std::size_t>(here)] = here;
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}}) {
        if (x + dx < 0 || x + dx >= columns || y + dy < 0) continue;
        const int beside = here + dy * columns + dx;
        if (parent[static_cast<std::size_t>(beside)] < 0) continue;
        const int a = root(beside), b = root(here);
        parent[static_cast<std::size_t>(std::max(a, b))] =
            std::min(a, b);  // the first in order names the part
      }
    }
  std::vector<Eigen::Vector3d> sums(parent.size(), Eigen::Vector3d::Zero());  // u, v, points
  for (int i = 0; i < columns * rows; ++i)
    if (parent[static_cast<std::size_t>(i)] >= 0) {
      const Eigen::Vector2d at = uv(i % columns, i / columns);
      sums[static_cast<std::size_t>(root(i))] += Eigen::Vector3d(at.x(), at.y(), 1);
    }
  std::vector<CoilCentre> out;
  for (const Eigen::Vector3d& sum : sums)
    if (sum.z() * step * step > 1)
      out.push_back({"ink-" + std::to_string(out.size() + 1), sum.head<2>() / sum.z()});
  return out;
}

}  // namespace

std::vector<CoilCentre> coil_centres(std::span<const std::uint8_t> bytes, const Pattern& pattern) {
  std::vector<CoilCentre> centres;
  if (pattern.format() == "SVG") centres = of_groups(bytes, pattern.size_mm());
  return centres.empty() ? of_ink(pattern) : centres;
}

}  // namespace vacuform
