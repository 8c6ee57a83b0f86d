#include "api/redaction/svg_names.hpp"

#include <algorithm>
#include <array>

#include "api/base/text.hpp"

namespace vacuform {

namespace {

constexpr std::string_view base64_letters =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::string_view svg_namespace = "http://www.w3.org/2000/svg";
constexpr std::size_t longest_name = 64;  // of an element or attribute; SVG has no longer ones

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
char blank(char c) { return is_blank(c) ? c : ' '; }

// "svg:path" -> "svg" and "path"; "path" -> "" and "path".
struct Name {
  std::string_view prefix, local;
  explicit Name(std::string_view name) {
    const std::size_t colon = name.find(':');
    prefix = colon == std::string_view::npos ? "" : name.substr(0, colon);
    local = colon == std::string_view::npos ? name : name.substr(colon + 1);
  }
};

// A picture as base 64, character by character: decoded, filtered, and put back into the same places. White space and
// references to characters (&#10;) between them stay where they are.
class Base64Picture {
 public:
  void step(char c, std::string& out) {
    const std::size_t letter = base64_letters.find(c);
    const bool is_letter = letter != std::string_view::npos;
    in_reference_ = c == '&' || (in_reference_ && (is_letter || c == '#'));
    if (in_reference_) {
      layout_ += c;
    } else if (is_letter && !ended_) {
      take(static_cast<std::uint32_t>(letter));
    } else {
      if (c == '=') end_of_letters();
      layout_ += c == '=' || c == ';' ? c : blank(c);
    }
    give(out);
  }

  void end(std::string& out) {
    end_of_letters();
    give(out);
  }

  void fields(FilterState& state) {
    std::string inner = state.reads() ? std::string() : filter_.state();
    state(in_reference_, ended_, group_, letters_, kept_, layout_, ready_, inner);
    if (state.reads()) filter_.go_on(inner);
  }

 private:
  static constexpr char place = '\1';  // of a letter in the layout

  void take(std::uint32_t letter) {
    layout_ += place;
    group_ = group_ << 6 | letter;
    if (++letters_ < 4) return;
    letters_ = 0;
    encode(filter_.pass(bytes_of_group(3)));
  }

  // At the first padding, or at the end of the text.
  void end_of_letters() {
    if (ended_) return;
    ended_ = true;
    const auto letters = static_cast<std::size_t>(letters_);
    group_ <<= 6 * (4 - letters_);
    if (letters > 1) encode(filter_.pass(bytes_of_group(letters - 1)));
    encode(filter_.finish());
    const std::size_t whole = ready_.size();
    kept_.resize(kept_.empty() ? 0 : 3, '\0');
    encode("");
    ready_.resize(whole + letters, 'A');  // one letter alone has no meaning
  }

  std::string bytes_of_group(std::size_t size) const {
    const std::string bytes{static_cast<char>(group_ >> 16 & 0xFF), static_cast<char>(group_ >> 8 & 0xFF),
                            static_cast<char>(group_ & 0xFF)};
    return bytes.substr(0, size);
  }
  // Encodes as many complete groups as there are.
  void encode(std::string_view bytes) {
    kept_ += bytes;
    std::size_t at = 0;
    for (; kept_.size() - at >= 3; at += 3) {
      std::uint32_t group = 0;
      for (std::size_t i = 0; i < 3; ++i) group = group << 8 | static_cast<unsigned char>(kept_[at + i]);
      for (int shift = 18; shift >= 0; shift -= 6) ready_ += base64_letters[group >> shift & 63];
    }
    kept_.erase(0, at);
  }
  // Fills the places that letters are there for.
  void give(std::string& out) {
    std::size_t at = 0, used = 0;
    for (; at < layout_.size(); ++at) {
      if (layout_[at] == place && used == ready_.size()) break;
      out += layout_[at] == place ? ready_[used++] : layout_[at];
    }
    layout_.erase(0, at);
    ready_.erase(0, used);
  }

  NameFilter filter_{""};
  std::string layout_;  // of what is held back: places for letters, and what stands between them
  std::string ready_;   // letters for them
  std::string kept_;    // out of the filter, and no whole group yet
  std::uint32_t group_ = 0;
  int letters_ = 0;  // of the group that comes in
  bool in_reference_ = false, ended_ = false;
};

class SvgNames : public NameFilter::Format {
 public:
  void take(std::string_view in, std::string& out) override {
    for (const char c : in) step(c, out);
  }
  void end(std::string& out) override {
    if (place_ == Place::value && treatment_ == Treatment::picture) picture_->end(out);
    if (place_ == Place::value && treatment_ == Treatment::reference) out.append(held_.size(), ' ');
    if (place_ == Place::markup) out += held_;
    if (place_ == Place::comment || place_ == Place::instruction || place_ == Place::cdata)
      out.append(held_.size(), ' ');
  }
  void fields(FilterState& state) override {
    state(place_, treatment_, held_, element_, attribute_, own_prefixes_, instruction_, keep_instruction_,
          depth_, shown_from_, hidden_from_, quote_, closing_, rooted_, in_declaration_, in_style_comment_,
          doctype_depth_, doctype_quote_, style_last_);
    bool picture = picture_ != nullptr;
    state(picture);
    if (picture && !picture_) picture_ = std::make_unique<Base64Picture>();
    if (picture) picture_->fields(state);
  }

 private:
  enum class Place {
    text,
    markup,
    comment,
    instruction,
    cdata,
    doctype,
    element,
    tag,
    attribute,
    before_value,
    value
  };
  enum class Treatment { keep, blank, reference, picture };

  void step(char c, std::string& out) {
    switch (place_) {
      case Place::text:
        return in_text(c, out);
      case Place::markup:
        return in_markup(c, out);
      case Place::comment:
        return until("-->", c, out, doctype_depth_ > 0 ? Place::doctype : Place::text, false);
      case Place::instruction:
        return in_instruction(c, out);
      case Place::cdata:
        return until("]]>", c, out, Place::text, shown());
      case Place::doctype:
        return in_doctype(c, out);
      case Place::element:
        return in_element_name(c, out);
      case Place::tag:
        return in_tag(c, out);
      case Place::attribute:
        return in_attribute_name(c, out);
      case Place::before_value:
        return before_value(c, out);
      case Place::value:
        return in_value(c, out);
    }
  }

  bool shown() const { return shown_from_ > 0 && hidden_from_ == 0; }

  void in_text(char c, std::string& out) {
    if (c == '<') {
      held_ = c;
      place_ = Place::markup;
      return;
    }
    // Before the root only white space and a mark of UTF-8 are XML.
    out += shown() || !rooted_ ? in_style(c) : blank(c);
  }

  // In style sheets, the comments are blanked.
  char in_style(char c) {
    if (Name(element_).local != "style") return c;
    if (in_style_comment_) {
      in_style_comment_ = !(c == '/' && style_last_ == '*');
      const bool sign = !in_style_comment_ || c == '*';  // a star may be that of the end
      style_last_ = c;
      return sign ? c : blank(c);
    }
    in_style_comment_ = c == '*' && style_last_ == '/';
    style_last_ = in_style_comment_ ? '\0' : c;
    return c;
  }

  // After '<', until the kind of markup is known.
  void in_markup(char c, std::string& out) {
    held_ += c;
    constexpr std::array<std::string_view, 3> long_ones{"<!--", "<![CDATA[", "<!DOCTYPE"};
    for (const std::string_view mark : long_ones)
      if (mark != held_ && mark.starts_with(held_)) return;
    out += held_;
    if (held_ == "<!--") {
      place_ = Place::comment;
    } else if (held_ == "<![CDATA[") {
      place_ = Place::cdata;
    } else if (held_.starts_with("<!")) {
      place_ = c == '>' ? Place::text : Place::doctype;
      doctype_depth_ = c == '>' ? 0 : 1;
      doctype_quote_ = '\0';
    } else if (held_ == "<?") {
      place_ = Place::instruction;
      in_declaration_ = true;
    } else {
      begin_element(c);
    }
    held_.clear();
  }

  // Blanks, or keeps, what comes before `mark`, which ends it.
  void until(std::string_view mark, char c, std::string& out, Place then, bool kept) {
    held_ += c;
    if (held_ == mark) {
      out += held_;
      held_.clear();
      place_ = then;
      return;
    }
    while (!held_.empty() && !mark.starts_with(held_)) {
      out += kept ? in_style(held_[0]) : blank(held_[0]);
      held_.erase(0, 1);
    }
  }

  // "<?xml version...?>" stays; other instructions keep only their target.
  void in_instruction(char c, std::string& out) {
    if (in_declaration_ && !is_blank(c) && c != '?') {
      if (instruction_.size() < longest_name) instruction_ += c;
      out += c;
      return;
    }
    if (in_declaration_) {
      in_declaration_ = false;
      keep_instruction_ = instruction_ == "xml";
      instruction_.clear();
    }
    until("?>", c, out, Place::text, keep_instruction_);
  }

  void in_doctype(char c, std::string& out) {
    if (doctype_quote_ != '\0') {
      if (c == doctype_quote_) doctype_quote_ = '\0';
    } else if (c == '"' || c == '\'') {
      doctype_quote_ = c;
    } else if (c == '<') {
      ++doctype_depth_;
    } else if (c == '>' && --doctype_depth_ == 0) {
      place_ = Place::text;
    }
    out += c;
    // A comment among the declarations.
    held_ =
        doctype_quote_ == '\0' && std::string_view("<!--").starts_with(held_ + c) ? held_ + c : std::string();
    if (held_ != "<!--") return;
    --doctype_depth_;
    held_.clear();
    place_ = Place::comment;
  }

  void begin_element(char c) {
    closing_ = c == '/';
    element_.clear();
    if (!closing_) element_ += c;
    place_ = Place::element;
  }

  void in_element_name(char c, std::string& out) {
    if (!is_blank(c) && c != '>' && c != '/') {
      if (element_.size() < longest_name) element_ += c;
      out += c;
      return;
    }
    if (!closing_) open_element();
    place_ = Place::tag;
    in_tag(c, out);
  }

  void open_element() {
    ++depth_;
    const Name name(element_);
    if (!rooted_) own(name.prefix);
    rooted_ = true;
    const bool foreign = !name.prefix.empty() && name.prefix != "svg" && !owns(name.prefix);
    constexpr std::array<std::string_view, 4> hidden{"metadata", "title", "desc", "script"};
    constexpr std::array<std::string_view, 2> with_text{"text", "style"};
    if (hidden_from_ == 0 && (foreign || one_of(name.local, hidden))) hidden_from_ = depth_;
    if (shown_from_ == 0 && one_of(name.local, with_text)) shown_from_ = depth_;
    in_style_comment_ = false;
    style_last_ = '\0';
  }

  // The prefixes of SVG's elements: that of the root, and those that are declared to be.
  void own(std::string_view prefix) {
    if (!owns(prefix) && own_prefixes_.size() < 16 * longest_name) own_prefixes_.append(prefix).append(":");
  }
  bool owns(std::string_view prefix) const {
    const std::string wanted = std::string(":").append(prefix).append(":");
    return own_prefixes_.find(wanted) != std::string::npos;
  }

  void close_element() {
    if (hidden_from_ == depth_) hidden_from_ = 0;
    if (shown_from_ == depth_) shown_from_ = 0;
    depth_ -= depth_ > 0 ? 1 : 0;
  }

  // Between the attributes of a tag.
  void in_tag(char c, std::string& out) {
    out += c;
    if (c == '>') {
      if (closing_) close_element();
      closing_ = false;
      place_ = Place::text;
    } else if (c == '/') {
      closing_ = true;  // "<path/>", whose end comes at once
    } else if (!is_blank(c)) {
      attribute_ = c;
      place_ = Place::attribute;
    }
  }

  void in_attribute_name(char c, std::string& out) {
    if (c == '>' || c == '/') {  // not XML
      place_ = Place::tag;
      return in_tag(c, out);
    }
    out += c;
    if (c == '=')
      place_ = Place::before_value;
    else if (!is_blank(c) && attribute_.size() < longest_name)
      attribute_ += c;
  }

  void before_value(char c, std::string& out) {
    if (c == '>') {
      place_ = Place::tag;
      return in_tag(c, out);
    }
    out += c;
    if (c != '"' && c != '\'') return;
    quote_ = c;
    held_.clear();
    treatment_ = treatment();
    place_ = Place::value;
  }

  Treatment treatment() const {
    const Name name(attribute_);
    if (name.prefix == "xmlns" || attribute_ == "xmlns") return Treatment::keep;
    if (hidden_from_ > 0) return Treatment::blank;
    if (name.local == "href") return Treatment::reference;
    constexpr std::array<std::string_view, 3> kept{"xml:space", "xml:id", "inkscape:groupmode"};
    if (!name.prefix.empty()) return one_of(attribute_, kept) ? Treatment::keep : Treatment::blank;
    const bool telling = attribute_.size() >= longest_name || attribute_.starts_with("data-") ||
                         attribute_.starts_with("aria-") || attribute_ == "title" || attribute_ == "alt";
    return telling ? Treatment::blank : Treatment::keep;
  }

  void in_value(char c, std::string& out) {
    if (c == quote_) {
      if (treatment_ == Treatment::reference) out.append(held_.size(), ' ');
      if (treatment_ == Treatment::picture) picture_->end(out);
      picture_.reset();
      if (held_ == svg_namespace && attribute_.starts_with("xmlns:")) own(Name(attribute_).local);
      held_.clear();
      out += c;
      place_ = Place::tag;
      return;
    }
    switch (treatment_) {
      case Treatment::keep:
        if (held_.size() <= svg_namespace.size()) held_ += c;
        out += c;
        return;
      case Treatment::blank:
        out += blank(c);
        return;
      case Treatment::reference:
        return in_reference(c, out);
      case Treatment::picture:
        return picture_->step(c, out);
    }
  }

  // "#id" stays, "data:image/png;base64,..." is filtered, everything else refers to something outside the file.
  void in_reference(char c, std::string& out) {
    constexpr std::string_view data = "data:";
    if (held_.empty() && (is_blank(c) || c == '#')) {
      out += c;
      if (c == '#') treatment_ = Treatment::keep;
      return;
    }
    held_ += c;
    const bool embedded = held_.starts_with(data), perhaps = data.starts_with(held_);
    if (perhaps || (embedded && c != ',' && held_.size() < longest_name)) return;
    const bool encoded = embedded && held_.ends_with(";base64,");
    if (encoded) picture_ = std::make_unique<Base64Picture>();
    treatment_ = encoded ? Treatment::picture : Treatment::blank;
    // Data that is not a picture stays recognisable as such, so that its reader reports it.
    if (embedded && c == ',')
      out += held_;
    else
      out.append(held_.size(), ' ');
    held_.clear();
  }

  Place place_ = Place::text;
  Treatment treatment_ = Treatment::keep;
  std::string held_;                 // what cannot be decided yet
  std::string element_, attribute_;  // of the last tag
  std::string own_prefixes_ = ":";   // each with a colon behind it
  int depth_ = 0, shown_from_ = 0,
      hidden_from_ = 0;                    // of elements; where text is shown, or nothing is, from 1
  char quote_ = '\0';                      // that ends the value
  bool closing_ = false, rooted_ = false;  // the tag ends an element; there was a first one
  std::string instruction_;                // of a processing instruction
  bool in_declaration_ = false, keep_instruction_ = false;
  bool in_style_comment_ = false;
  int doctype_depth_ = 0;
  char doctype_quote_ = '\0', style_last_ = '\0';
  std::unique_ptr<Base64Picture> picture_;
};

}  // namespace

std::unique_ptr<NameFilter::Format> svg_names() { return std::make_unique<SvgNames>(); }

}  // namespace vacuform
