#include "worker/pattern/svg_work.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "worker/pattern/curve.hpp"
#include "worker/pattern/svg_shape.hpp"
#include "worker/pattern/svg_style.hpp"

namespace vacuform {

namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

// Measured with librsvg 2.54 and cairo 1.16 on one slow core, each rounded up.
constexpr double seconds_an_element = 2e-5, seconds_a_byte = 2e-7, seconds_a_crossing = 2.2e-6;
constexpr double seconds_a_painted_pixel = 5e-10, seconds_an_outline_pixel = 1.6e-7;
constexpr double most_seconds = 4;  // a drawing with colour may be drawn twice

constexpr double seconds_a_letter = 5e-4;  // of a text of most_letters; its cost grows with the square
constexpr double most_letters = 1000;      // of one text
constexpr double most_stops = 1000;        // of one gradient: each run of pixels looks through them

constexpr double most_elements = 1e5, most_drawn_crossings = 1.8e6;
constexpr double most_matches = 2e7;            // of rules with elements
constexpr double most_visits = 2e6;             // of this count itself
constexpr int most_hops = 100;                  // references to references
constexpr double simple_crossings = 50;         // as of a line that does not cross itself
constexpr double most_measured_segments = 2e6;  // that are looked at for their length
constexpr double longest_sides = 2;             // of a piece of an outline, as far as it lies on the page
constexpr double surface_bytes = 4;             // a pixel
constexpr double most_surface_bytes = 5e8, fewest_pixels = 250'000;

// In pages: the cost of what copies, blends or filters a whole page.
constexpr double blended_pages = 4, masked_pages = 12, filtered_pages = 200, patterned_pages = 8,
                 clipped_pages = 2, shaded_pages = 6;

// Sizes grouped by powers of two, so that each group can be limited by the size of the page once its enlargement is
// known.
class Sizes {
 public:
  void add(double size, double count) {
    if (!(count > 0)) return;
    size = std::min(size, unbounded);
    Sum& sum = sums_[size > 0 ? std::ilogb(size) : -1000];
    sum.count += count;
    sum.size += count * size;
  }
  void add(const Sizes& other, double scale, double count) {
    for (const auto& [power, sum] : other.sums_) add(scale * sum.size / sum.count, count * sum.count);
  }
  // Their sum in units of `most`, with each size counted as at most `most`.
  double sum_up_to(double most) const {
    double out = 0;
    for (const auto& [power, sum] : sums_) out += std::min(sum.size / most, sum.count);
    return out;
  }
  // For sizes beyond `most`: how many points the library puts onto an arc of this radius, as a multiple of those for
  // `most`.
  double arcs_beyond(double most) const {
    double out = 0;
    for (const auto& [power, sum] : sums_)
      if (sum.size > most * sum.count) out += sum.count * std::sqrt(sum.size / sum.count / most);
    return out;
  }
  double count() const {
    double out = 0;
    for (const auto& [power, sum] : sums_) out += sum.count;
    return out;
  }
  static constexpr double unbounded = 1e60;

 private:
  struct Sum {
    double count = 0, size = 0;
  };
  std::map<int, Sum> sums_;
};

// The work of one element and of what it holds, in its own user units.
struct Part {
  SvgWork work;
  Sizes areas, lengths;  // of shapes, and of pieces of outlines

  // `scale`: of areas. Where that is unbounded, each shape counts as a whole page.
  void add(const Part& other, double scale, double count = 1) {
    work.elements += count * other.work.elements;
    work.text += count * other.work.text;
    work.crossings += count * other.work.crossings;
    work.pages += count * other.work.pages;
    work.sides += count * other.work.sides;
    work.layers += count * other.work.layers;
    work.surfaces = std::max(work.surfaces, other.work.surfaces);
    if (scale == Sizes::unbounded) {
      work.pages += count * other.areas.count();
      work.sides += count * longest_sides * other.lengths.count();
      return;
    }
    areas.add(other.areas, scale, count);
    lengths.add(other.lengths, std::sqrt(scale), count);
  }
};

tl::unexpected<Error> too_much(const std::string& what, double count, double limit, const std::string& fix,
                               const std::string& file_name) {
  const auto number = [](double x) {
    if (!(x < 1e15)) return std::string("more than 10^15");
    return std::to_string(static_cast<long long>(x));
  };
  return fail(Code::too_large, what + ": " + number(count) + ", above the limit of " + number(limit),
              file_name, fix);
}

class Counter {
 public:
  Counter(const pugi::xml_document& document, const std::string& file_name)
      : file_name_(file_name), root_(document.document_element()), sheets_(document) {
    bool entities = false;
    for (const pugi::xml_node node : document.children())
      entities |= node.type() == pugi::node_doctype &&
                  std::string_view(node.value()).find("<!ENTITY") != std::string_view::npos;
    document.find_node([&](const pugi::xml_node& node) {
      if (node.type() == pugi::node_element) ++elements_;
      if (entities) values_by_entities_ |= has_reference(node);
      if (const pugi::xml_attribute id = node.attribute("id")) of_id_.emplace(id.value(), node);
      if (local_name(node) == "style")
        for (const pugi::xml_node child : node.children()) count_rules(child.value());
      return false;
    });
  }

  Result<SvgWork> count() {
    if (values_by_entities_)
      return fail(Code::unsupported_format, "the SVG takes values from entities of its document type",
                  file_name_, "save it as plain SVG");
    // Each element is matched with each selector, and also with its surroundings if selectors refer to these.
    if (selectors_ * elements_ * (sheets_.complete() ? 1 : 100) > most_matches)
      return too_much("the SVG has too many style rules for its elements",
                      selectors_ * elements_ * (sheets_.complete() ? 1 : 100), most_matches,
                      "export it with plain attributes instead of style sheets", file_name_);
    const Part all = part(root_, Style(), 0);
    if (too_deep_)
      return too_much("the SVG nests references to elements too deeply", most_hops + 1, most_hops,
                      "replace copies by the shapes themselves", file_name_);
    SvgWork work = all.work;
    const double side = std::sqrt(page_area());
    work.elements += all.lengths.arcs_beyond(longest_sides * side);
    if (!(visits_ <= most_visits) || !(work.elements <= most_elements))
      return too_much("the SVG draws too many elements", std::max(work.elements, visits_), most_elements,
                      "make fewer copies with <use>, patterns, markers or dashes, or join shapes to paths",
                      file_name_);
    if (!(most_stops_ <= most_stops))
      return too_much("a gradient of the SVG has too many stops", most_stops_, most_stops,
                      "remove stops, or give a picture", file_name_);
    if (!(longest_text_ <= most_letters))
      return too_much("a text of the SVG is too long, in bytes", longest_text_, most_letters,
                      "split the text, or convert it to paths", file_name_);
    if (!(work.crossings <= most_drawn_crossings) || segments_ > most_measured_segments)
      return too_much("the SVG's outlines cross too often (estimated)", std::max(work.crossings, segments_),
                      most_drawn_crossings, "simplify the paths, or unite their overlaps", file_name_);
    work.pages += all.areas.sum_up_to(page_area());
    work.sides += longest_sides * all.lengths.sum_up_to(longest_sides * side);
    return work;
  }

 private:
  // pugixml does not expand references to declared entities. In names of namespaces they do no harm.
  static bool has_reference(const pugi::xml_node& node) {
    const auto refers = [](std::string_view text) { return text.find('&') != text.npos; };
    for (const pugi::xml_attribute attribute : node.attributes()) {
      const std::string_view name = attribute.name();
      const bool counts = name.find(':') == name.npos || name.starts_with("xlink:");
      if (counts && name != "xmlns" && name != "requiredExtensions" && refers(attribute.value())) return true;
    }
    return local_name(node) == "style" && refers(node.child_value());
  }

  void count_rules(std::string_view text) {
    selectors_ += static_cast<double>(std::count(text.begin(), text.end(), '{') +
                                      std::count(text.begin(), text.end(), ','));
    effects_in_sheets_ |= text.find("url(") != text.npos || text.find("opacity") != text.npos ||
                          text.find("blend") != text.npos;
  }

  // In user units; 0 if the drawing does not say, so that every shape counts as a page.
  double page_area() const {
    const auto box = svg_numbers(root_.attribute("viewBox").value());
    if (box && box->size() == 4) return std::max(1e-9, std::abs((*box)[2] * (*box)[3]));
    const auto side = [&](const char* name, LengthOf of) {
      return svg_length(root_.attribute(name).value(), of, {0, 0}).value_or(0);
    };
    return std::max(1e-9, side("width", LengthOf::width) * side("height", LengthOf::height));
  }

  pugi::xml_node target(std::string_view reference) const {
    if (!reference.starts_with('#')) return {};
    const auto at = of_id_.find(std::string(reference.substr(1)));
    return at == of_id_.end() ? pugi::xml_node() : at->second;
  }
  pugi::xml_node target_of_url(std::string_view value) const {
    const auto open = value.find('#');
    const auto close = value.find_first_of("'\") ", open);
    if (!value.starts_with("url(") || open == value.npos || close == value.npos) return {};
    return target(value.substr(open, close - open));
  }
  static std::string_view href(const pugi::xml_node& node) {
    for (const pugi::xml_attribute attribute : node.attributes()) {
      const std::string_view name = attribute.name();
      if (name == "href" || name.ends_with(":href")) return attribute.value();
    }
    return {};
  }

  // What a referred element draws, counted once for each style that it inherits.
  const Part& referred(const pugi::xml_node& node, const Style& style, int depth) {
    static const Part nothing;
    if (depth > most_hops) too_deep_ = true;
    if (!node || too_deep_) return nothing;
    const auto [at, fresh] = parts_.try_emplace({node.hash_value(), style.inherited()});
    if (!fresh) return at->second;  // or a cycle, which librsvg refuses
    // The entry stays empty until the part is complete, so that a cycle finds it empty.
    Part whole = part(node, style, depth);
    return at->second = std::move(whole);
  }

  // `depth`: of references.
  Part part(const pugi::xml_node& node, const Style& parent, int depth) {
    Part out;
    if (++visits_ > most_visits || too_deep_) return out;
    const std::string_view name = local_name(node);
    std::size_t ignored = 0;
    const Style style = sheets_.of(node, parent, ignored);
    visits_ += static_cast<double>(ignored) / 16;
    if (style[Property::display] == "none") return out;
    out.work.elements = 1;

    Part inside;
    if (name == "use") {
      const pugi::xml_node drawn = target(href(node));
      inside.add(referred(drawn, style, depth + 1), view_scale(drawn, node));
    } else if (name == "text") {
      const double letters = text_below(node);
      longest_text_ = std::max(longest_text_, letters);
      inside.work.text += letters * seconds_a_letter / seconds_a_byte;
      inside.work.pages += 0.5;
    } else if (name == "image" || name == "foreignObject") {
      inside.work.pages += shaded_pages;
    } else {
      paint(node, style, depth, inside);
      for (const pugi::xml_node child : node.children())
        if (child.type() == pugi::node_element && is_drawn_in_place(local_name(child)))
          inside.add(part(child, style, depth), view_scale(child, child));
    }
    effects(style, depth, inside);
    out.add(inside, style[Property::transform] == "none" ? transform_scale(node) : Sizes::unbounded);
    return out;
  }

  static bool is_drawn_in_place(std::string_view name) {
    for (const char* other : {"defs", "symbol", "clipPath", "mask", "marker", "pattern", "filter", "style",
                              "linearGradient", "radialGradient", "metadata", "title", "desc"})
      if (name == other) return false;
    return true;
  }

  double text_below(const pugi::xml_node& node) {
    double bytes = 0;
    for (const pugi::xml_node child : node.children()) {
      bytes += static_cast<double>(std::string_view(child.value()).size());
      if (child.type() == pugi::node_element) bytes += 16 + text_below(child);
      ++visits_;
    }
    return bytes;
  }

  // How a transform changes areas.
  static double transform_scale(const pugi::xml_node& node) {
    const pugi::xml_attribute attribute = node.attribute("transform");
    if (!attribute) return 1;
    const auto read = svg_transform(attribute.value());
    return read ? std::abs(read->linear().determinant()) : 1;
  }
  // How the viewBox of a symbol or an inner page changes areas, where `placed` gives it a size.
  double view_scale(const pugi::xml_node& node, const pugi::xml_node& placed) const {
    const std::string_view name = local_name(node);
    if (node == root_ || (name != "symbol" && name != "svg")) return 1;
    const auto box = svg_numbers(node.attribute("viewBox").value());
    if (!box || box->empty()) return 1;
    if (box->size() != 4 || !((*box)[2] > 0) || !((*box)[3] > 0)) return Sizes::unbounded;
    const Vector2d whole = Vector2d::Constant(std::sqrt(page_area()));
    const auto side = [&](const char* key, LengthOf of) {
      const pugi::xml_attribute own = placed.attribute(key);
      return svg_length((own ? own : node.attribute(key)).value(), of, whole).value_or(whole.x());
    };
    const Vector2d scale(side("width", LengthOf::width) / (*box)[2],
                         side("height", LengthOf::height) / (*box)[3]);
    return scale.cwiseAbs().maxCoeff() * scale.cwiseAbs().maxCoeff();
  }

  void paint(const pugi::xml_node& node, const Style& style, int depth, Part& out) {
    const Vector2d viewport = Vector2d::Constant(std::sqrt(page_area()));
    Refusal unreadable;
    const auto most = static_cast<std::size_t>(std::max(0.0, most_measured_segments - segments_)) + 1;
    const std::vector<Curve> curves = curves_of(node, viewport, most, unreadable);
    if (curves.empty()) return;
    out.work.text += static_cast<double>(std::string_view(node.attribute("d").value()).size() +
                                         std::string_view(node.attribute("points").value()).size());
    AlignedBox2d box;
    double length = 0, pieces = 0, turned = 0;
    for (const Curve& curve : curves) {
      for (const Vector2d& p : curve.points) box.extend(p);
      for (std::size_t i = 1; i < curve.points.size(); ++i)
        length += (curve.points[i] - curve.points[i - 1]).norm();
      pieces += std::floor(static_cast<double>(curve.points.size()) / 3);
      turned += 1 + turns(curve);
    }
    segments_ += pieces;
    const bool stroked = style[Property::stroke] != "none";
    const auto given = svg_length(style[Property::stroke_width], LengthOf::diagonal, viewport);
    const double width = stroked ? given.value_or(1e30) : 0;
    const double dashes = stroked ? dashes_along(style, length, viewport) : 0;
    const Vector2d sides = box.sizes() + Vector2d::Constant(width);
    const double outline = length + (turned + dashes) * std::min(width, box.sizes().norm());
    if (sides.minCoeff() > 0)
      out.work.crossings +=
          (stroked ? 2 : 1) * std::max(0.0, outline * outline / sides.prod() - simple_crossings);
    out.work.elements += dashes / 10;
    const bool known = sheets_.complete() && !unreadable.given();
    const bool filled = style[Property::fill] != "none";
    if (filled) out.areas.add(known ? box.sizes().prod() : Sizes::unbounded, 1);
    if (stroked)
      out.areas.add(known ? std::min(sides.prod(), width * (length + 2 * width)) : Sizes::unbounded, 1);
    const double outlines = (filled ? 1 : 0) + (stroked ? 2 : 0);
    out.lengths.add(length / std::max(pieces, 1.0) + (stroked ? width : 0), outlines * pieces);
    if (stroked) out.lengths.add(width, 2 * dashes);
    for (const Property p : {Property::fill, Property::stroke}) paint_server(style[p], style, depth, out);
    for (const Property p : {Property::marker_start, Property::marker_mid, Property::marker_end})
      if (style[p] != "none")
        out.add(referred(target_of_url(style[p]), style, depth + 1), Sizes::unbounded,
                p == Property::marker_mid ? pieces : static_cast<double>(curves.size()));
  }

  static double dashes_along(const Style& style, double length, const Vector2d& viewport) {
    double period = 0, count = 0;
    std::string_view list = style[Property::stroke_dasharray];
    if (list == "none") return 0;
    while (!list.empty()) {
      const auto end = std::min(list.find_first_of(", \t\r\n"), list.size());
      if (const auto dash =
              end > 0 ? svg_length(list.substr(0, end), LengthOf::diagonal, viewport) : std::nullopt) {
        period += *dash;
        ++count;
      }
      list.remove_prefix(std::min(end + 1, list.size()));
    }
    return period > 0 ? std::min(1e30, length / period * count) : 0;
  }

  void paint_server(std::string_view value, const Style& style, int depth, Part& out) {
    if (!value.starts_with("url(")) return;
    pugi::xml_node server = target_of_url(value);
    const bool pattern = local_name(server) == "pattern";
    out.work.pages += pattern ? patterned_pages : shaded_pages;
    if (pattern) out.add(referred(server, Style(), depth + 1), Sizes::unbounded);
    if (pattern) out.work.surfaces += 2;
    // A server can take its stops or tiles from another one.
    double stops = 0;
    for (int hops = 0; server; ++hops) {
      for (const pugi::xml_node child : server.children())
        if (local_name(child) == "stop") out.work.elements += 0.1, ++visits_, ++stops;
      most_stops_ = std::max(most_stops_, stops);
      out.work.elements += 0.1;
      if (hops > most_hops) {
        too_deep_ = true;
        return;
      }
      server = target(href(server));
      if (pattern && server) out.add(referred(server, style, depth + 1), Sizes::unbounded);
    }
  }

  void effects(const Style& style, int depth, Part& inside) {
    const auto set = [&](Property p, std::string_view off) { return style[p] != off; };
    const bool unknown = !sheets_.complete() && effects_in_sheets_;
    if (unknown || svg_opacity(style[Property::opacity]).value_or(1) < 1 ||
        set(Property::mix_blend_mode, "normal")) {
      inside.work.pages += blended_pages;
      inside.work.surfaces += 1;
    }
    if (set(Property::clip_path, "none")) {
      inside.add(referred(target_of_url(style[Property::clip_path]), style, depth + 1), Sizes::unbounded);
      inside.work.pages += clipped_pages;
      inside.work.surfaces += 1;
    }
    if (set(Property::mask, "none")) {
      Part mask = referred(target_of_url(style[Property::mask]), style, depth + 1);
      mask.work.surfaces += 3;
      inside.add(mask, Sizes::unbounded);
      inside.work.layers += masked_pages;
      inside.work.surfaces += 1;
    }
    if (set(Property::filter, "none")) filter(style[Property::filter], inside);
  }

  // What a primitive costs grows with its numbers: the order of a matrix, a radius, octaves.
  void filter(std::string_view value, Part& inside) {
    inside.work.surfaces += 4;
    inside.work.layers += filtered_pages;
    for (std::size_t at = 0; (at = value.find("url(", at)) != value.npos; at += 4)
      for (const pugi::xml_node primitive : target_of_url(value.substr(at)).children()) {
        ++visits_;
        inside.work.surfaces += 0.5;
        double each = 1;
        for (const char* key : {"order", "radius", "numOctaves"})
          if (const auto numbers = svg_numbers(primitive.attribute(key).value()))
            for (const double n : *numbers) each = std::max(each, key[0] == 'n' ? n : n * n);
        inside.work.layers += filtered_pages * std::min(each, 1e30);
      }
    if (!value.starts_with("url(")) inside.work.layers += filtered_pages * static_cast<double>(value.size());
  }

  const std::string& file_name_;
  const pugi::xml_node root_;
  const StyleSheets sheets_;
  std::map<std::string, pugi::xml_node> of_id_;
  std::map<std::pair<std::size_t, std::string>, Part> parts_;
  double elements_ = 0, selectors_ = 0, visits_ = 0, segments_ = 0, longest_text_ = 0, most_stops_ = 0;
  bool too_deep_ = false, effects_in_sheets_ = false, values_by_entities_ = false;
};

}  // namespace

double SvgWork::seconds(double pixels) const {
  // It is drawn in bands, and each band goes through all elements.
  const double bands = std::ceil(pixels / 4e6);
  return bands * (elements * seconds_an_element + text * seconds_a_byte +
                  layers * pixels * seconds_a_painted_pixel) +
         crossings * seconds_a_crossing + pages * pixels * seconds_a_painted_pixel +
         sides * std::sqrt(pixels) * seconds_an_outline_pixel;
}

Result<SvgWork> work_to_draw(const pugi::xml_document& document, const std::string& file_name) {
  return Counter(document, file_name).count();
}

Result<double> affordable_pixels(const SvgWork& work, double wanted, const std::string& file_name) {
  double pixels = wanted;
  if (work.surfaces > 0) pixels = std::min(pixels, most_surface_bytes / (surface_bytes * work.surfaces));
  while (pixels > fewest_pixels && work.seconds(pixels) > most_seconds) pixels *= 0.9;
  if (pixels >= std::min(wanted, fewest_pixels)) return pixels;
  return too_much("the SVG paints too much over itself, in pages", work.pages + work.layers,
                  most_seconds / (fewest_pixels * seconds_a_painted_pixel),
                  "remove masks, filters, patterns and transparent groups, or give a picture", file_name);
}

}  // namespace vacuform
