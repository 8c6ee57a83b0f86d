#include "worker/pattern/svg_size.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <optional>
#include <pugixml.hpp>
#include <sstream>
#include <string_view>

#include "api/base/decimal.hpp"
#include "api/base/text.hpp"
#include "api/redaction/svg_generator.hpp"
#include "worker/pattern/svg_style.hpp"
#include "worker/pattern/svg_values.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

constexpr double css_dpi = 96;

// Millimetres of the units that have a length of their own; px and numbers without a unit have none.
struct Unit {
  std::string_view name;
  double mm;
};
constexpr std::array<Unit, 6> absolute_units{
    {{"mm", 1}, {"cm", 10}, {"in", 25.4}, {"pt", 25.4 / 72}, {"pc", 25.4 / 6}, {"q", 0.25}}};

struct Side {
  double value = 0;
  std::optional<Unit> unit;  // none: px
  bool named_px = false;
  double mm(double dpi) const { return value * (unit ? unit->mm : 25.4 / dpi); }
  std::string text() const {
    return short_decimal(value, 8) + (unit ? " " + std::string(unit->name) : named_px ? " px" : "");
  }
};

// Nothing for a length that is missing, relative, or not above zero.
std::optional<Side> side_of(std::string_view text) {
  text = trimmed(text);
  NumberCursor cursor(text);
  const auto value = cursor.number();
  if (!value || !(*value > 0)) return std::nullopt;
  const std::string unit = lower(trimmed(cursor.rest()));
  Side side{.value = *value, .unit = {}, .named_px = unit == "px"};
  if (unit.empty() || side.named_px) return side;
  for (const Unit& u : absolute_units)
    if (u.name == unit) side.unit = u;
  if (!side.unit) return std::nullopt;
  return side;
}

// How long a pixel is, and who says so.
struct Pixels {
  double dpi = css_dpi;
  std::string by;
};

std::optional<Pixels> of_program(const pugi::xml_document& document, const pugi::xml_node& root) {
  bool illustrator = false;
  for (const pugi::xml_node node : document.children())
    illustrator |= node.type() == pugi::node_comment && !svg_generator_comment(node.value()).empty();
  const std::string version = svg_inkscape_version(root.attribute("inkscape:version").value());
  // One of the two opened what the other wrote, and may or may not have changed its numbers.
  if (illustrator == !version.empty()) return std::nullopt;
  if (illustrator) return Pixels{72, "as Adobe Illustrator counts"};
  int major = 0, minor = 0;
  const char* const end = version.data() + version.size();
  const auto [point, error] = std::from_chars(version.data(), end, major);
  if (error != std::errc()) return std::nullopt;
  if (point != end) std::from_chars(point + 1, end, minor);
  const bool old = major == 0 && minor < 92;
  return Pixels{old ? 90.0 : 96.0, "as Inkscape " + version + " counts"};
}

std::string by_pixels(const Pixels& pixels) {
  return "at " + short_decimal(pixels.dpi) + " px/in, " + pixels.by;
}

// Nobody says how long a pixel is. `numbers` are those of a drawing without any unit, which may be millimetres.
tl::unexpected<Error> ask(const std::string& what, const std::optional<Vector2d>& numbers,
                          const std::function<Vector2d(double dpi)>& size_at, const std::string& file_name) {
  std::vector<Proposal> proposals;
  const auto propose = [&](const char* setting, double value, const Vector2d& mm, const std::string& why) {
    constexpr double least_mm = 1, most_mm = 2000;
    if (mm.x() >= least_mm && mm.x() <= most_mm && mm.y() <= most_mm)
      proposals.push_back({{{setting, value}}, size_text(mm) + why});
  };
  const auto width = [](double mm) { return std::round(1000 * mm) / 1000; };
  if (numbers) {
    propose("pattern.width_mm", width(numbers->x()), *numbers, ", if its numbers are mm");
    if (numbers->maxCoeff() < 30)
      propose("pattern.width_mm", width(25.4 * numbers->x()), 25.4 * *numbers, ", if they are inches");
  }
  for (const auto& [dpi, who] : {std::pair{72.0, ", as Illustrator, Affinity and PDF count"},
                                 std::pair{90.0, ", as Inkscape before 0.92 counts"},
                                 std::pair{96.0, ", as browsers and Inkscape count"}})
    propose("pattern.dpi", dpi, size_at(dpi), who);
  return fail(Code::unusable_pattern, what, file_name, "say how large it is", std::move(proposals),
              "export it with its width and height in mm");
}

// Replaces lengths in units that have one by user units of `dpi` to the inch. In an attribute the whole text is a length or
// a list of them; in a style they follow a sign.
std::string in_user_units(std::string_view text, double dpi) {
  std::string out;
  const auto ends_word = [](char c) {
    return !(c >= '0' && c <= '9') && !(lower(c) >= 'a' && lower(c) <= 'z') && c != '.' && c != '-' &&
           c != '_' && c != '#' && c != '+';
  };
  for (std::size_t i = 0; i < text.size();) {
    const bool begins = i == 0 || ends_word(text[i - 1]);
    double value = 0;
    std::size_t number_end = i;
    if (begins && (text[i] == '.' || text[i] == '-' || (text[i] >= '0' && text[i] <= '9'))) {
      const auto [end, error] = std::from_chars(text.data() + i, text.data() + text.size(), value);
      if (error == std::errc()) number_end = static_cast<std::size_t>(end - text.data());
    }
    std::size_t end = number_end;
    while (end < text.size() && lower(text[end]) >= 'a' && lower(text[end]) <= 'z') ++end;
    const std::string unit = lower(text.substr(number_end, end - number_end));
    const auto known = std::find_if(absolute_units.begin(), absolute_units.end(),
                                    [&](const Unit& u) { return u.name == unit; });
    const bool whole = end == text.size() || ends_word(text[end]);
    if (number_end > i && known != absolute_units.end() && whole && std::isfinite(value)) {
      out += short_decimal(value * known->mm * dpi / 25.4, 12);
      i = end;
    } else {
      const std::size_t next = std::max(number_end, i + 1);
      out += text.substr(i, next - i);
      i = next;
    }
  }
  return out;
}

constexpr std::string_view length_attributes[] = {"cx",
                                                  "cy",
                                                  "dx",
                                                  "dy",
                                                  "font-size",
                                                  "height",
                                                  "r",
                                                  "rx",
                                                  "ry",
                                                  "x1",
                                                  "x2",
                                                  "stroke-width",
                                                  "stroke-dasharray",
                                                  "stroke-dashoffset",
                                                  "width",
                                                  "x",
                                                  "y",
                                                  "y1",
                                                  "y2",
                                                  "style"};

// Whether something was changed.
bool convert_lengths(pugi::xml_node node, double dpi, bool is_root) {
  bool changed = false;
  for (pugi::xml_attribute attribute : node.attributes()) {
    const std::string_view name = attribute.name();
    if (std::find(std::begin(length_attributes), std::end(length_attributes), name) ==
        std::end(length_attributes))
      continue;
    if (is_root && (name == "width" || name == "height" || name == "x" || name == "y")) continue;
    const std::string converted = in_user_units(attribute.value(), dpi);
    if (converted == attribute.value()) continue;
    attribute.set_value(converted.c_str());
    changed = true;
  }
  if (local_name(node) == "style")
    for (pugi::xml_node text : node.children())
      if (text.type() == pugi::node_pcdata || text.type() == pugi::node_cdata) {
        const std::string converted = in_user_units(text.value(), dpi);
        if (converted == text.value()) continue;
        text.set_value(converted.c_str());
        changed = true;
      }
  return changed;
}

bool convert_all_lengths(pugi::xml_document& document, double dpi) {
  bool changed = false;
  const pugi::xml_node root = document.document_element();
  document.find_node([&](pugi::xml_node node) {
    if (node.type() == pugi::node_element) changed |= convert_lengths(node, dpi, node == root);
    return false;
  });
  return changed;
}

class Sizer {
 public:
  Sizer(std::string text, const std::string& file_name, const PatternSettings& settings)
      : text_(std::move(text)), file_name_(file_name), settings_(settings) {}

  Result<SizedSvg> run() {
    // White space counts in texts.
    if (!document_.load_buffer(text_.data(), text_.size(), pugi::parse_full | pugi::parse_ws_pcdata))
      return fail(Code::corrupt_file, "the SVG cannot be read", file_name_,
                  "export the drawing again as plain SVG");
    root_ = document_.document_element();
    width_ = side_of(root_.attribute("width").value());
    height_ = side_of(root_.attribute("height").value());
    const auto box = svg_numbers(root_.attribute("viewBox").value());
    if (box && box->size() == 4 && (*box)[2] > 0 && (*box)[3] > 0 && std::isfinite((*box)[2] / (*box)[3]))
      box_ = Vector2d((*box)[2], (*box)[3]);
    if (settings_.dpi)
      pixels_ = Pixels{*settings_.dpi, "as pattern.dpi says"};
    else
      pixels_ = of_program(document_, root_);
    VACUFORM_CHECK(find_size());
    say_more();
    return rewritten();
  }

 private:
  static bool in_pixels(const std::optional<Side>& side) { return side && !side->unit; }

  // Fills in size_mm and size_from.
  Result<void> find_size() {
    const bool pixels = in_pixels(width_) || in_pixels(height_),
               absolute = (width_ && width_->unit) || (height_ && height_->unit);
    if (!width_ && !height_) return by_box();
    if (!box_ && !(width_ && height_)) return no_size();
    std::string said = width_ ? width_->text() : height_->text() + " high";
    if (width_ && height_) said = said_of_both();
    // With both sides of one kind the shape is known, whatever a pixel is.
    const double some_dpi = pixels_ ? pixels_->dpi : css_dpi;
    const bool mixed = pixels && absolute;
    const auto at_dpi = [this](double dpi) { return sides_mm(dpi); };
    if (mixed && !pixels_) {
      if (settings_.width_mm && box_) return by_width(box_->x() / box_->y());
      return ask("the SVG is " + said + ", and programs differ in how many px an inch has", {}, at_dpi,
                 file_name_);
    }
    const Vector2d mm = sides_mm(some_dpi);
    if (settings_.width_mm) return by_width(mm.x() / mm.y());
    if (pixels && !pixels_) {
      const bool named = (width_ && width_->named_px) || (height_ && height_->named_px);
      return ask("the SVG is " + said +
                     (named ? ", and programs differ in how many px an inch has" : ", without a unit"),
                 named ? std::optional<Vector2d>() : mm * css_dpi / 25.4, at_dpi, file_name_);
    }
    sized_.size_mm = mm;
    sized_.size_from = pixels ? said + " " + by_pixels(*pixels_) : said + ", as the file says";
    return {};
  }
  // Only a viewBox: Illustrator counts its units as it counts pixels; in other programs they are anything.
  Result<void> by_box() {
    if (!box_) return no_size();
    if (settings_.width_mm) return by_width(box_->x() / box_->y());
    const std::string said = short_decimal(box_->x(), 8) + " x " + short_decimal(box_->y(), 8) + " units";
    if (!settings_.dpi && !(pixels_ && pixels_->dpi == 72))
      return ask(
          "the SVG does not say how large the drawing is: its viewBox has " + said, box_,
          [this](double dpi) { return Vector2d(*box_ * 25.4 / dpi); }, file_name_);
    sized_.size_mm = *box_ * 25.4 / pixels_->dpi;
    sized_.size_from = "a viewBox of " + said + " " + by_pixels(*pixels_);
    return {};
  }
  Result<void> by_width(double aspect) {
    sized_.size_mm = {*settings_.width_mm, *settings_.width_mm / aspect};
    sized_.size_from =
        "a width of " + short_decimal(*settings_.width_mm, 8) + " mm, as pattern.width_mm says";
    return {};
  }
  Result<void> no_size() const {
    return fail(Code::unusable_pattern, "the SVG has no size", file_name_,
                "give its svg element a width, height and viewBox");
  }
  Vector2d sides_mm(double dpi) const {
    const double w = width_ ? width_->mm(dpi) : 0, h = height_ ? height_->mm(dpi) : 0;
    if (width_ && height_) return {w, h};
    return width_ ? Vector2d(w, w * box_->y() / box_->x()) : Vector2d(h * box_->x() / box_->y(), h);
  }
  std::string said_of_both() const {
    const auto name = [](const Side& side) {
      return side.unit ? side.unit->name : side.named_px ? std::string_view("px") : std::string_view();
    };
    if (name(*width_) != name(*height_)) return width_->text() + " x " + height_->text();
    return short_decimal(width_->value, 8) + " x " + height_->text();
  }

  // What else hangs on the length of a pixel: the drawing itself, if there is no viewBox.
  void say_more() {
    const bool absolute = (width_ && width_->unit) || (height_ && height_->unit);
    if (!box_ && absolute && !pixels_) {
      Warning warning{"pattern-units",
                      "The SVG has a size in " +
                          std::string(width_->unit ? width_->unit->name : height_->unit->name) +
                          ", but no viewBox. The shapes in it are taken at 96 px/in, as browsers take them."};
      warning.place = "the drawing";
      warning.proposals = {{{{"pattern.dpi", 72.0}}, "as Illustrator counts"},
                           {{{"pattern.dpi", 90.0}}, "as Inkscape before 0.92 counts"}};
      sized_.warnings.push_back(std::move(warning));
    }
    if (settings_.dpi && !settings_.width_mm && box_ && absolute && !in_pixels(width_) && !in_pixels(height_))
      sized_.size_from += "; pattern.dpi has no effect";
  }

  SizedSvg rewritten() {
    const double dpi = pixels_ ? pixels_->dpi : css_dpi;
    bool changed = dpi != css_dpi && convert_all_lengths(document_, dpi);
    const auto set = [&](const char* name, const std::string& value) {
      pugi::xml_attribute attribute = root_.attribute(name);
      if (!attribute) attribute = root_.append_attribute(name);
      attribute.set_value(value.c_str());
      changed = true;
    };
    if (!box_) {
      const Vector2d units(width_->unit ? width_->mm(dpi) * dpi / 25.4 : width_->value,
                           height_->unit ? height_->mm(dpi) * dpi / 25.4 : height_->value);
      set("viewBox", "0 0 " + short_decimal(units.x(), 15) + " " + short_decimal(units.y(), 15));
    }
    const auto plain = [&](const std::optional<Side>& side, const char* name, double mm) {
      const std::string_view text = root_.attribute(name).value();
      // Also in the smaller letters that every reader knows.
      if (!side || !side->unit || lower(text) != text || side->unit->name == "q" || settings_.width_mm)
        set(name, short_decimal(mm, 15) + "mm");
    };
    plain(width_, "width", sized_.size_mm.x());
    plain(height_, "height", sized_.size_mm.y());
    if (changed) {
      if (const pugi::xml_node first = document_.first_child(); first.type() == pugi::node_declaration)
        document_.remove_child(first);  // it may name another encoding
      std::ostringstream out;
      document_.save(out, "", pugi::format_raw | pugi::format_no_declaration, pugi::encoding_utf8);
      text_ = std::move(out).str();
    }
    sized_.text = std::move(text_);
    return std::move(sized_);
  }

  std::string text_;
  const std::string& file_name_;
  const PatternSettings& settings_;
  pugi::xml_document document_;
  pugi::xml_node root_;
  std::optional<Side> width_, height_;
  std::optional<Vector2d> box_;
  std::optional<Pixels> pixels_;
  SizedSvg sized_;
};

}  // namespace

std::string size_text(const Vector2d& mm) { return decimal(mm.x(), 1) + " x " + decimal(mm.y(), 1) + " mm"; }

Result<SizedSvg> size_svg(std::string text, const std::string& file_name, const PatternSettings& settings) {
  return Sizer(std::move(text), file_name, settings).run();
}

}  // namespace vacuform
