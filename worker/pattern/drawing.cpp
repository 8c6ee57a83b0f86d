#include "worker/pattern/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <pugixml.hpp>
#include <string_view>

#include "api/base/text.hpp"
#include "worker/pattern/area.hpp"
#include "worker/pattern/curve.hpp"
#include "worker/pattern/pieces.hpp"
#include "worker/pattern/sorting.hpp"
#include "worker/pattern/svg_shape.hpp"

namespace vacuform {

namespace {

using Eigen::Affine2d;
using Eigen::AlignedBox2d;
using Eigen::Vector2d;

// A drawing beyond these limits is not a coil pattern; they limit a hostile one to a second.
constexpr std::size_t most_segments = 200'000;
constexpr std::size_t most_work = 4'000'000;  // elements examined, texts by 16 characters, rules tried
constexpr int deepest = 256;
constexpr double farthest_mm = 1e5, longest_mm = 1e6;
// Crossings of outlines, estimated from the length of what is drawn in a box as for random lines (Santalo, "Integral
// geometry and geometric probability", 1976), up to a factor. Half a million take a second or two to resolve.
constexpr double most_crossings = 5e5, plain_crossings = 50;

bool one_of(std::string_view name, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}
bool is_shape(std::string_view name) {
  return one_of(name, {"path", "circle", "ellipse", "rect", "line", "polyline", "polygon"});
}
bool is_group(std::string_view name) { return one_of(name, {"g", "a", "svg", "switch"}); }

Curve page_outline(const Vector2d& size_mm) {
  const Vector2d half = size_mm / 2;
  const Vector2d corners[] = {-half, {half.x(), -half.y()}, half, {-half.x(), half.y()}, -half};
  Curve out{{corners[0]}, true};
  for (int i = 0; i < 4; ++i)
    for (int k = 1; k <= 3; ++k)
      out.points.emplace_back(corners[i] + (corners[i + 1] - corners[i]) * (k / 3.0));
  out.points.back() = out.points.front();
  return out;
}

class Reader {
 public:
  Reader(const pugi::xml_document& document, const Vector2d& size_mm)
      : sheets_(document), root_(document.document_element()) {
    drawing_.size_mm = size_mm;
    bool entities = false;
    for (const pugi::xml_node node : document.children())
      entities |= node.type() == pugi::node_doctype &&
                  std::string_view(node.value()).find("<!ENTITY") != std::string_view::npos;
    document.find_node([&](const pugi::xml_node& node) {
      index(node);
      if (entities) look_for_entities(node);
      if (is_group(local_name(node)) || local_name(node) == "use") {
        note_layer(layer_of(node));
      }
      return false;
    });
  }

  std::optional<Drawing> read(std::vector<Warning>& warnings) {
    if (!sheets_.complete())
      refuse("a style sheet with selectors of several parts", "export it with plain attributes");
    read_root();
    if (!refused()) {
      join_bare_bridges();
      forget_lone_covers();
      const std::vector<Shape> grounds = invert_openings();
      std::vector<SortedElement> sorted = sort_into_elements(painted_, nodes_);
      drawing_.elements = with_shapes(std::move(sorted), std::move(painted_));
      for (const Element& element : drawing_.elements)
        if (element.id.empty())
          for (const Shape& shape : element.shapes) drawing_.loose_ink_mm2 += ink_mm2(shape);
      if (!grounds.empty()) drawing_.elements.insert(drawing_.elements.begin(), Element{{}, {0, 0}, grounds});
      return std::move(drawing_);
    }
    warnings.push_back(
        {"pattern-as-picture",
         std::string("The drawing is printed as a picture and not as lines, because it contains ") +
             refusal_.what() + ".",
         {},
         {},
         "To keep its lines exact, " + refusal_.fix() + "."});
    if (layered())
      warnings.push_back({"layers-as-one",
                          "The layers of the drawing are printed as one, because it is printed as a picture.",
                          {},
                          {},
                          "To keep its layers, " + refusal_.fix() + "."});
    return std::nullopt;
  }

 private:
  // What an element inherits from those around it.
  struct Under {
    Style style;
    Affine2d to_pattern = Affine2d::Identity();
    Vector2d viewport{0, 0};  // what percentages are taken of, user units
    double opacity = 1;
    int depth = 0;
    int node = -1;  // of the file, in which it stands
    std::optional<DrawnLayer> layer = {};
    bool copied = false;  // by a <use>, which names what it copies
  };

  // In a drawing without a dielectric a bridge is a part of the conductor.
  void join_bare_bridges() {
    const bool parted = std::any_of(painted_.begin(), painted_.end(), [](const PaintedShape& painted) {
      return painted.shape.layer && painted.shape.layer->step == PrintStep::dielectric;
    });
    if (parted) return;
    for (PaintedShape& painted : painted_)
      if (auto& layer = painted.shape.layer; layer && layer->step == PrintStep::bridges)
        layer->step = PrintStep::conductor;
  }

  // A picture alone, such as a group "image" that a program made, is a drawing like any other.
  void forget_lone_covers() {
    const auto covers = [](const std::optional<DrawnLayer>& layer) {
      return layer && !of_circuits(layer->step);
    };
    const auto inked = [](const Shape& s) {
      return (s.fill && s.fill->ink() > 0) || (s.stroke && s.stroke->colour.ink() > 0);
    };
    if (std::any_of(painted_.begin(), painted_.end(), [&](const PaintedShape& painted) {
          return !covers(painted.shape.layer) && inked(painted.shape);
        }))
      return;
    for (PaintedShape& painted : painted_)
      if (covers(painted.shape.layer)) painted.shape.layer.reset();
  }

  // A resist by its openings: of each face the whole page, to be painted first, on which its shapes turn white.
  std::vector<Shape> invert_openings() {
    std::vector<Shape> grounds;
    const auto invert = [](Colour& colour) {
      const double gray = colour.ink() > 0 ? 1 : 0;
      colour = {gray, gray, gray, 1};
    };
    for (PaintedShape& painted : painted_) {
      Shape& shape = painted.shape;
      if (!shape.layer || !std::exchange(shape.layer->openings, false)) continue;
      if (shape.fill) invert(*shape.fill);
      if (shape.stroke) invert(shape.stroke->colour);
      if (std::any_of(grounds.begin(), grounds.end(), [&](const Shape& s) { return s.layer == shape.layer; }))
        continue;
      grounds.push_back({{page_outline(drawing_.size_mm)}, Colour(), false, std::nullopt, shape.layer});
    }
    return grounds;
  }

  // Programs call groups pictures that nobody meant as a layer. Beside another layer it is one.
  void note_layer(const std::optional<DrawnLayer>& layer) {
    if (!layer) return;
    (layer->step == PrintStep::picture ? pictured_ : named_) = true;
    several_ |= layer->step != PrintStep::picture && *layer != DrawnLayer();
  }
  bool layered() const { return several_ || (named_ && pictured_); }

  void index(const pugi::xml_node& node) {
    const pugi::xml_attribute id = node.attribute("id");
    if (!id) return;
    of_id_.emplace(id.value(), node);
  }

  // pugixml does not expand entities. In the names of namespaces they do no harm.
  void look_for_entities(const pugi::xml_node& node) {
    bool found = local_name(node) == "style" &&
                 std::string_view(node.child_value()).find('&') != std::string_view::npos;
    for (const pugi::xml_attribute attribute : node.attributes())
      found |= std::string_view(attribute.name()).find(':') == std::string_view::npos &&
               std::string_view(attribute.name()) != "xmlns" &&
               std::string_view(attribute.value()).find('&') != std::string_view::npos;
    if (found) refuse("values by entities", "save it as plain SVG");
  }

  void refuse(const std::string& what, const std::string& fix) { refusal_.because(what, fix); }
  bool refused() const { return refusal_.given(); }
  void refuse_size() { refuse("more than can be kept as lines", "simplify it"); }

  void read_root() {
    const auto absolute = [&](const char* name) -> double {
      const std::string_view text = trimmed(root_.attribute(name).value());
      if (text.empty() || text.ends_with('%') || text == "auto") return 0;
      const auto px = svg_length(text, LengthOf::width, {0, 0});
      if (!px) refuse("a size in units that depend on a font", "give its size in mm");
      return px.value_or(0);
    };
    const double width = absolute("width"), height = absolute("height");
    Under under;
    Affine2d page = Affine2d::Identity();  // millimetres from the top left corner
    const Vector2d& size = drawing_.size_mm;
    const auto box = svg_numbers(root_.attribute("viewBox").value());
    if (box && !box->empty()) {
      const auto view = svg_view(*box, root_.attribute("preserveAspectRatio").value(), size);
      if (!view) return refuse("a viewBox that cannot be used", "correct it");
      page = *view;
      under.viewport = {(*box)[2], (*box)[3]};
    } else if (width > 0 && height > 0) {
      page.scale(size.x() / width);
      under.viewport = {width, height};
    } else {
      return refuse("no size", "give it a viewBox");
    }
    if (root_.attribute("transform")) return refuse("a turned page", "turn the shapes instead");
    under.to_pattern.matrix() << 1, 0, -size.x() / 2, 0, -1, size.y() / 2, 0, 0, 1;
    under.to_pattern = under.to_pattern * page;
    under.style = sheets_.of(root_, under.style, work_);
    if (!enter(root_, under)) return;
    const std::size_t before = paints_;
    children(root_, under);
    if (under.opacity < 1 && paints_ - before > 1) refuse_blend();
  }

  void refuse_blend() { refuse("an opacity of several shapes together", "give each shape its own colour"); }

  void children(const pugi::xml_node& node, const Under& under) {
    for (const pugi::xml_node child : node.children()) {
      if (refused()) return;
      if (child.type() == pugi::node_element) visit(child, under);
    }
  }

  // Applies the part of the element's own style that concerns all of it. False if nothing of it is drawn.
  bool enter(const pugi::xml_node& node, Under& under) {
    const Style& style = under.style;
    if (style[Property::display] == "none") return false;
    const auto set = [&](Property p, std::string_view off) { return style[p] != off; };
    if (set(Property::clip_path, "none")) refuse("clipping paths", "cut the shapes themselves");
    if (set(Property::mask, "none")) refuse("masks", "cut the shapes themselves");
    if (set(Property::filter, "none")) refuse("filters", "remove them");
    if (set(Property::mix_blend_mode, "normal")) refuse("blend modes", "remove them");
    if (set(Property::transform, "none") || set(Property::transform_origin, ""))
      refuse("transforms in styles", "export it with plain attributes");
    under.opacity *= svg_opacity(style[Property::opacity]).value_or(1);
    if (const pugi::xml_attribute transform = node.attribute("transform")) {
      work_ += std::string_view(transform.value()).size() / 16;
      const auto read = svg_transform(transform.value());
      if (!read)
        refuse("a transform that cannot be read", "correct it");
      else
        under.to_pattern = under.to_pattern * *read;
    }
    return !refused() && under.opacity > 0;
  }

  void visit(const pugi::xml_node& node, const Under& parent) {
    if (++work_ > most_work || parent.depth > deepest) return refuse_size();
    const std::string_view name = local_name(node);
    const bool shape = is_shape(name), use = name == "use";
    if (one_of(name, {"text", "image"})) return refuse_picture(node, name, parent);
    if (!shape && !use && !is_group(name)) return;
    Under under = parent;
    ++under.depth;
    under.style = sheets_.of(node, parent.style, work_);
    if (!enter(node, under)) return;

    const auto layer = shape ? std::nullopt : layer_of(node);
    if (layer) {
      // What a layer shows by being pale is no ink. A copy lies where it is drawn, and not where it comes from.
      under.opacity = parent.opacity;
      if (!parent.copied || !parent.layer) under.layer = layer;
    }
    const std::size_t before = paints_;
    if (std::string id = parent.copied || layer ? std::string() : id_of(node, use); !shape || !id.empty()) {
      nodes_.push_back({std::move(id), parent.node, shape, parent.copied ? std::nullopt : place_of(node),
                        layer.has_value()});
      under.node = static_cast<int>(nodes_.size()) - 1;
    }
    if (shape)
      paint(node, name, under);
    else if (use)
      follow(node, under);
    else if (name == "switch")
      choose(node, under);
    else if (name == "svg")
      nested(node, under, node.attribute("width").value(), node.attribute("height").value());
    else
      children(node, under);
    if (under.opacity < 1 && parent.opacity != under.opacity && paints_ - before > 1) refuse_blend();
  }

  void refuse_picture(const pugi::xml_node& node, std::string_view name, const Under& parent) {
    const Style style = sheets_.of(node, parent.style, work_);
    if (style[Property::display] == "none" || svg_opacity(style[Property::opacity]) == 0) return;
    if (name == "image")
      return style[Property::visibility] == "visible" ? refuse("a picture", "trace it") : void();
    if (shows_letters(node, style, parent.depth)) refuse("text", "turn it into paths");
  }

  // Programs hide texts that stand for the strokes that they draw (KiCad), or that only search finds.
  bool shows_letters(const pugi::xml_node& node, const Style& style, int depth) {
    if (++work_ > most_work || depth > deepest) return true;
    Refusal unknown;
    const bool inked = style[Property::visibility] == "visible" &&
                       (fill_of(style, 1, unknown) || style[Property::stroke] != "none" || unknown.given());
    for (const pugi::xml_node child : node.children()) {
      if (child.type() != pugi::node_element) {
        if (inked && !trimmed(child.value()).empty()) return true;
        continue;
      }
      if (one_of(local_name(child), {"title", "desc", "metadata"})) continue;
      const Style own = sheets_.of(child, style, work_);
      if (own[Property::display] != "none" && svg_opacity(own[Property::opacity]) != 0 &&
          shows_letters(child, own, depth + 1))
        return true;
    }
    return false;
  }

  // As a layout writes it (svg_of_rings()): at, u, drawn.
  static std::optional<CoilPlace> place_of(const pugi::xml_node& node) {
    const auto n = svg_numbers(node.attribute("data-place").value());
    if (!n || n->size() != 8) return std::nullopt;
    CoilPlace out{{(*n)[0], (*n)[1], (*n)[2]}, {(*n)[3], (*n)[4], (*n)[5]}, {(*n)[6], (*n)[7]}};
    if (!(out.u.norm() > 0.5)) return std::nullopt;
    out.u.normalize();
    return out;
  }

  static std::optional<DrawnLayer> layer_of(const pugi::xml_node& node) {
    const auto layer = drawn_layer(node.attribute("inkscape:label").value());
    return layer ? layer : drawn_layer(node.attribute("id").value());
  }

  // A copy without an id has the id of what it copies.
  std::string id_of(const pugi::xml_node& node, bool use) const {
    const std::string id = node.attribute("id").value();
    return use && id.empty() ? target(node).attribute("id").value() : id;
  }

  void add(Shape shape, int node) {
    for (Shape& piece : pieces_of(std::move(shape))) painted_.push_back({std::move(piece), node});
  }

  pugi::xml_node target(const pugi::xml_node& node) const {
    std::string_view reference = node.attribute("href").value();
    for (const pugi::xml_attribute attribute : node.attributes())
      if (reference.empty() && std::string_view(attribute.name()).ends_with(":href"))
        reference = attribute.value();
    if (!reference.starts_with('#')) return {};
    const auto at = of_id_.find(std::string(reference.substr(1)));
    return at == of_id_.end() ? pugi::xml_node() : at->second;
  }

  void follow(const pugi::xml_node& node, const Under& under) {
    const pugi::xml_node drawn = target(node);
    if (!drawn) return;
    Under moved = under;
    moved.copied = true;
    moved.to_pattern.translate(
        Vector2d(length_of(node, "x", LengthOf::width, under.viewport, refusal_).value_or(0),
                 length_of(node, "y", LengthOf::height, under.viewport, refusal_).value_or(0)));
    const std::string_view name = local_name(drawn);
    if (name != "symbol" && name != "svg") return visit(drawn, moved);
    moved.style = sheets_.of(drawn, under.style, work_);
    if (++moved.depth > deepest) return refuse_size();
    if (!enter(drawn, moved)) return;
    const auto side = [&](const char* key) {
      const std::string_view own = node.attribute(key).value();
      return own.empty() && name == "svg" ? drawn.attribute(key).value() : node.attribute(key).value();
    };
    const std::size_t before = paints_;
    nested(drawn, moved, side("width"), side("height"));
    if (moved.opacity < under.opacity && paints_ - before > 1) refuse_blend();
  }

  // An inner <svg>, or a <symbol> that is used: a viewport of its own.
  void nested(const pugi::xml_node& node, Under under, std::string_view width, std::string_view height) {
    const auto side = [&](std::string_view text, LengthOf of, double whole) {
      return text.empty() || text == "auto" ? std::optional<double>(whole)
                                            : svg_length(text, of, under.viewport);
    };
    const auto w = side(width, LengthOf::width, under.viewport.x()),
               h = side(height, LengthOf::height, under.viewport.y());
    if (!w || !h) return refuse("a size in units that depend on a font", "give sizes in mm");
    if (!(*w > 0) || !(*h > 0)) return;
    if (local_name(node) == "svg")
      under.to_pattern.translate(
          Vector2d(length_of(node, "x", LengthOf::width, under.viewport, refusal_).value_or(0),
                   length_of(node, "y", LengthOf::height, under.viewport, refusal_).value_or(0)));
    const Affine2d outside = under.to_pattern;
    under.viewport = {*w, *h};
    if (node.attribute("refX") || node.attribute("refY"))
      return refuse("symbols with a reference point", "draw them without");
    const auto box = svg_numbers(node.attribute("viewBox").value());
    if (box && !box->empty()) {
      const auto view = svg_view(*box, node.attribute("preserveAspectRatio").value(), {*w, *h});
      if (!view) return refuse("a viewBox that cannot be used", "correct it");
      under.to_pattern = under.to_pattern * *view;
      under.viewport = {(*box)[2], (*box)[3]};
    }
    const std::size_t mark = boxes_.size();
    children(node, under);
    // What sticks out of the viewport would be cut off there.
    const Affine2d inside = outside.inverse();
    const AlignedBox2d frame(Vector2d(-1e-6, -1e-6) * (*w + *h),
                             Vector2d(*w, *h) + Vector2d(1e-6, 1e-6) * (*w + *h));
    for (std::size_t i = mark; i < boxes_.size() && !refused(); ++i)
      for (const auto corner : {AlignedBox2d::BottomLeft, AlignedBox2d::BottomRight, AlignedBox2d::TopLeft,
                                AlignedBox2d::TopRight})
        if (!frame.contains(inside * boxes_[i].corner(corner)))
          return refuse("symbols or inner pages that are cut off at their border",
                        "cut the shapes themselves");
  }

  void choose(const pugi::xml_node& node, const Under& under) {
    for (const pugi::xml_node child : node.children()) {
      if (child.type() != pugi::node_element || local_name(child) == "foreignObject" ||
          child.attribute("requiredExtensions"))
        continue;
      if (child.attribute("systemLanguage")) return refuse("parts for one language", "remove them");
      return visit(child, under);
    }
  }

  void paint(const pugi::xml_node& node, std::string_view name, const Under& under) {
    const Style& style = under.style;
    if (style[Property::visibility] != "visible") return;
    if (!(std::abs(under.to_pattern.linear().determinant()) > 0)) return;
    Shape shape;
    for (const char* text : {"d", "points"})
      work_ += std::string_view(node.attribute(text).value()).size() / 16;
    shape.curves =
        curves_of(node, under.viewport, most_segments - std::min(most_segments, segments_) + 1, refusal_);
    for (const Curve& curve : shape.curves) segments_ += curve.points.size() / 3;
    if (segments_ > most_segments) return refuse_size();
    if (shape.curves.empty() || refused()) return;
    if (name != "line") shape.fill = fill_of(style, under.opacity, refusal_);
    shape.even_odd = style[Property::fill_rule] == "evenodd";
    shape.stroke = stroke_of(style, under.opacity, under.to_pattern, under.viewport, refusal_);
    if (shape.stroke && !shape.stroke->dashes_mm.empty() && node.attribute("pathLength"))
      refuse("dashes by a path's own measure", "give them in mm");
    const bool marked = style[Property::marker_start] != "none" || style[Property::marker_mid] != "none" ||
                        style[Property::marker_end] != "none";
    if (marked && one_of(name, {"path", "line", "polyline", "polygon"}))
      refuse("markers", "turn them into paths");
    if (refused() || (!shape.fill && !shape.stroke)) return;
    paints_ += (shape.fill ? 1u : 0u) + (shape.stroke ? 1u : 0u);
    place(shape, under);
    if (refused()) return;
    shape.layer = under.layer;
    const bool stroke_first = style[Property::paint_order].starts_with("stroke") ||
                              style[Property::paint_order].starts_with("markers stroke");
    if (shape.fill && shape.stroke && stroke_first) {
      Shape line = shape;
      line.fill.reset();
      shape.stroke.reset();
      add(std::move(line), under.node);
    }
    add(std::move(shape), under.node);
  }

  // From user units to pattern coordinates.
  void place(Shape& shape, const Under& under) {
    AlignedBox2d box;
    double length = 0, turned = 0;  // what is drawn across the line: at its turns and ends
    for (Curve& curve : shape.curves) {
      for (Vector2d& p : curve.points) {
        p = under.to_pattern * p;
        if (!p.allFinite() || p.cwiseAbs().maxCoeff() > farthest_mm)
          return refuse("shapes far off the page", "remove them");
        box.extend(p);
      }
      for (std::size_t i = 1; i < curve.points.size(); ++i)
        length += (curve.points[i] - curve.points[i - 1]).norm();
      turned += 1 + turns(curve);
    }
    const double width = shape.stroke ? widest_mm(*shape.stroke) : 0;
    if (width > farthest_mm) return refuse_size();
    if (shape.stroke && !shape.stroke->dashes_mm.empty()) {
      double period = 0;
      for (const double d : shape.stroke->dashes_mm) period += d;
      const double own_length = length * width / shape.stroke->width_mm;  // at most, by the pen's measure
      const double dashes = own_length / period * static_cast<double>(shape.stroke->dashes_mm.size());
      if (!(dashes < most_segments)) return refuse_size();
      segments_ += static_cast<std::size_t>(dashes);
      turned += dashes;
    }
    const Vector2d sides = box.sizes() + Vector2d::Constant(width + 0.01);
    const double drawn = length + turned * width;
    length_ += length;
    crossings_ += std::max(0.0, drawn * drawn / sides.prod() - plain_crossings);
    if (length_ > longest_mm || crossings_ > most_crossings || segments_ > most_segments)
      return refuse_size();
    const Vector2d margin = Vector2d::Constant(width / 2);
    boxes_.emplace_back(box.min() - margin, box.max() + margin);
  }

  const StyleSheets sheets_;
  const pugi::xml_node root_;
  std::map<std::string, pugi::xml_node> of_id_;
  Drawing drawing_;
  std::vector<AlignedBox2d> boxes_;  // around each painted shape
  std::vector<FileNode> nodes_;
  std::vector<PaintedShape> painted_;
  std::size_t work_ = 0, segments_ = 0, paints_ = 0;
  double length_ = 0, crossings_ = 0;
  bool named_ = false, pictured_ = false,
       several_ = false;  // layers: of any step but pictures, pictures, not the first
  Refusal refusal_;
};

}  // namespace

bool Drawing::layered() const {
  return std::any_of(elements.begin(), elements.end(), [](const Element& element) {
    return std::any_of(element.shapes.begin(), element.shapes.end(),
                       [](const Shape& shape) { return shape.layer && *shape.layer != DrawnLayer(); });
  });
}

bool Drawing::parts_loops() const {
  return std::any_of(elements.begin(), elements.end(), [](const Element& element) {
    return std::any_of(element.shapes.begin(), element.shapes.end(), [](const Shape& shape) {
      return shape.layer && *shape.layer != DrawnLayer() && of_circuits(shape.layer->step);
    });
  });
}

std::optional<Drawing> read_drawing(const std::string& svg, const Vector2d& size_mm,
                                    std::vector<Warning>& warnings) {
  pugi::xml_document document;
  if (svg.empty() || !document.load_buffer(svg.data(), svg.size(), pugi::parse_default | pugi::parse_doctype))
    return std::nullopt;
  return Reader(document, size_mm).read(warnings);
}

std::optional<Drawing> read_drawing(const Pattern& pattern, std::vector<Warning>& warnings) {
  return read_drawing(pattern.svg(), pattern.size_mm(), warnings);
}

}  // namespace vacuform
