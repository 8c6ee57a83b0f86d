// SVG. The copy is written from what the parser (expat) finds: the elements and attributes of SVG, under one namespace, with
// entities replaced by what they stand for. Elements stay on their lines.
#include <expat.h>
#include <iconv.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "api/base/base64.hpp"
#include "api/base/text.hpp"
#include "api/print_step.hpp"
#include "api/redaction/formats.hpp"
#include "api/redaction/svg_generator.hpp"
#include "api/redaction/svg_names.hpp"
#include "api/redaction/svg_words.hpp"

namespace vacuform::redaction {

namespace {

constexpr std::string_view svg_uri = "http://www.w3.org/2000/svg", xlink_uri = "http://www.w3.org/1999/xlink",
                           inkscape_uri = "http://www.inkscape.org/namespaces/inkscape";
constexpr std::uint64_t most_expansion = 10;  // of the file by its entities
constexpr std::size_t most_spaces = 100;      // namespaces that are declared at one place

std::string escaped(std::string_view text, bool attribute) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (attribute && c == '"')
      out += "&quot;";
    else if (c == '\r' || (attribute && (c == '\n' || c == '\t')))
      out += "&#" + std::to_string(static_cast<int>(c)) + ";";
    else
      out += c;
  }
  return out;
}

// A style sheet or a list of declarations without comments, blanks beside signs, and addresses outside of the file.
std::string without_comments(std::string_view text) {
  std::string out;
  for (;;) {
    const std::size_t begin = text.find("/*");
    out += text.substr(0, begin);
    if (begin == std::string_view::npos) return out;
    const std::size_t end = text.find("*/", begin + 2);
    if (end == std::string_view::npos) return out;
    text.remove_prefix(end + 2);
  }
}
std::string without_addresses(std::string_view text, const OwnNames& own) {
  std::string out;
  for (;;) {
    const std::size_t begin = text.find("url(");
    out += text.substr(0, std::min(begin, text.size()));
    if (begin == std::string_view::npos) return out;
    const std::size_t end = std::min(text.find(')', begin), text.size());
    const std::string_view whole = text.substr(begin + 4, end - begin - 4),
                           address = trimmed(whole, " \t\r\n'\"");
    out += "url(";
    if (address.starts_with('#')) {
      const std::size_t word = whole.find('#') + 1;
      out.append(whole.substr(0, word))
          .append(own(address.substr(1)))
          .append(whole.substr(word + address.size() - 1));
    }
    text.remove_prefix(end);
  }
}
// Programs keep their own notes in properties that begin with a sign: "-inkscape-font-specification:...".
std::string without_notes(std::string_view declarations) {
  std::string out;
  while (!declarations.empty()) {
    const std::string_view one = declarations.substr(0, declarations.find(';'));
    declarations.remove_prefix(std::min(one.size() + 1, declarations.size()));
    if (!trimmed(one).starts_with('-')) out.append(out.empty() ? "" : ";").append(one);
  }
  return out;
}
std::string without_blanks(std::string_view text) {
  std::string out(text);
  std::erase_if(out, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; });
  return out;
}

// Whether declarations hide what they style.
bool hides(std::string_view declarations) {
  const std::string text = ";" + without_blanks(declarations) + ";";
  return text.find(";display:none;") != std::string::npos || text.find(";opacity:0;") != std::string::npos;
}

// A picture as base 64, without names; empty if the text is not base 64, or not of a PNG or JPEG.
Result<std::string> redacted_picture(std::string_view text) {
  const auto bytes = from_base64(text, " \t\r\n");
  if (!bytes || (!begins_png(*bytes) && !begins_jpeg(*bytes))) return std::string();
  std::string picture;
  Cursor in{std::string_view(*bytes)};
  Copy out([&](std::string_view some) -> Result<void> {
    picture += some;
    return {};
  });
  VACUFORM_CHECK(begins_png(*bytes) ? png(in, out) : jpeg(in, out));
  VACUFORM_CHECK(out.end());
  return to_base64(picture);
}

// "#id" stays, "data:image/png;base64,..." without its names. Everything else refers to something outside the file: a blank,
// so that the reader reports it.
Result<std::string> reference(std::string_view target) {
  const bool none = target.empty();
  target = trimmed(target);
  if (none || target.starts_with('#')) return std::string(target);
  if (!target.starts_with("data:")) return std::string(" ");
  for (const std::string_view kind :
       {"data:image/png;base64,", "data:image/jpeg;base64,", "data:image/jpg;base64,"})
    if (target.starts_with(kind)) {
      VACUFORM_TRY(data, redacted_picture(target.substr(kind.size())));
      return std::string(kind) + data;
    }
  return std::string("data:,");
}

bool known(std::string_view word, std::span<const std::string_view> words) {
  return std::binary_search(words.begin(), words.end(), word);
}

bool only_numbers(std::string_view value) {
  return value.size() <= 200 && value.find_first_not_of("0123456789+-.e ") == value.npos;
}

// An element or attribute with the namespace of its prefix.
struct Name {
  std::string_view uri, local;
};

// Calls what a subclass does with the elements and texts of a file.
class Walk {
 public:
  virtual ~Walk() = default;

  // Errors: corrupt_file, unsupported_format (not SVG), and those of the subclass.
  Result<void> read(const ByteSource& file) {
    parser_ = XML_ParserCreate(nullptr);
    const std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> owner(parser_,
                                                                                              XML_ParserFree);
    XML_SetUserData(parser_, this);
    XML_SetElementHandler(parser_, on_start, on_end);
    XML_SetCharacterDataHandler(parser_, on_text);
    XML_SetCommentHandler(parser_, on_comment);
    XML_SetUnknownEncodingHandler(parser_, on_encoding, nullptr);
    XML_SetEntityDeclHandler(parser_, on_entity);
    VACUFORM_TRY(size, file.size());
    left_ = most_expansion * size;
    Cursor in(file);
    for (;;) {
      VACUFORM_TRY(some, in.some());
      const bool good =
          XML_Parse(parser_, some.data(), static_cast<int>(some.size()), some.empty()) != XML_STATUS_ERROR;
      if (problem_) return tl::make_unexpected(*std::move(problem_));
      if (!good)
        return fail(Code::corrupt_file,
                    std::string("the SVG cannot be read: ") + XML_ErrorString(XML_GetErrorCode(parser_)) +
                        ", on line " + std::to_string(line()),
                    {}, "export the drawing again as plain SVG");
      if (some.empty()) return {};
      in.drop(some.size());
    }
  }

 protected:
  using Attributes = std::vector<std::pair<std::string_view, std::string_view>>;
  virtual Result<void> start(std::string_view element, const Attributes& attributes) = 0;
  virtual Result<void> end(std::string_view element) = 0;
  virtual Result<void> text(std::string_view text) = 0;
  virtual Result<void> comment(std::string_view) { return {}; }
  std::size_t line() const { return XML_GetCurrentLineNumber(parser_); }
  // Of a prefix that nobody declared, what everybody means by it.
  Name name(std::string_view written) const {
    const std::size_t colon = written.find(':');
    const std::string_view prefix = colon == std::string_view::npos ? "" : written.substr(0, colon);
    const std::string_view local = colon == std::string_view::npos ? written : written.substr(colon + 1);
    const auto at =
        std::find_if(spaces_.rbegin(), spaces_.rend(), [&](const Space& s) { return s.prefix == prefix; });
    if (at != spaces_.rend()) return {at->uri, local};
    return {prefix == "xlink" ? xlink_uri : prefix == "svg" || prefix.empty() ? svg_uri : prefix, local};
  }

 private:
  struct Space {
    std::string prefix, uri;
    int depth;
  };

  static void on_start(void* data, const char* written, const char** given) {
    auto& walk = *static_cast<Walk*>(data);
    ++walk.depth_;
    Attributes attributes;
    for (; *given; given += 2) {
      const std::string_view key = given[0], value = given[1];
      if (key == "xmlns" || key.starts_with("xmlns:"))
        walk.spaces_.push_back(
            {std::string(key.substr(std::min<std::size_t>(6, key.size()))), std::string(value), walk.depth_});
      else
        attributes.emplace_back(key, value);
      walk.count(value);
    }
    if (walk.spaces_.size() > most_spaces)
      return walk.stop(Error{Code::too_large,
                             "the SVG declares more than " + std::to_string(most_spaces) + " namespaces",
                             {},
                             "save it as plain SVG"});
    const Name name = walk.name(written);
    if (walk.depth_ == 1 && (name.local != "svg" || name.uri != svg_uri))
      return walk.stop(Error{
          Code::unsupported_format, "the file is XML, but not SVG", {}, "give a PNG, JPEG or SVG file"});
    // An element of another namespace, or one that SVG does not have, goes with all that is in it.
    if (walk.foreign_ == 0 && (name.uri != svg_uri || !known(name.local, svg_elements)))
      walk.foreign_ = walk.depth_;
    if (walk.foreign_ == 0) walk.call(walk.start(name.local, attributes));
  }
  static void on_end(void* data, const char* written) {
    auto& walk = *static_cast<Walk*>(data);
    if (walk.problem_) return;  // the parser tells the end of an element whose beginning stopped it
    if (walk.foreign_ == 0) walk.call(walk.end(walk.name(written).local));
    if (walk.foreign_ == walk.depth_) walk.foreign_ = 0;
    while (!walk.spaces_.empty() && walk.spaces_.back().depth == walk.depth_) walk.spaces_.pop_back();
    --walk.depth_;
  }
  static void on_text(void* data, const char* letters, int size) {
    auto& walk = *static_cast<Walk*>(data);
    const std::string_view text(letters, static_cast<std::size_t>(size));
    walk.count(text);
    if (walk.foreign_ == 0) walk.call(walk.text(text));
  }
  static void on_comment(void* data, const char* written) {
    auto& walk = *static_cast<Walk*>(data);
    if (!walk.problem_) walk.call(walk.comment(written));
  }
  // Drawing programs declare entities for the names of namespaces. Those of markup, of other entities or of other files could
  // stand for any number of elements.
  static void on_entity(void* data, const char*, int is_parameter, const char* value, int size, const char*,
                        const char*, const char*, const char*) {
    const std::string_view text(value ? value : "<", value ? static_cast<std::size_t>(size) : 1);
    if (is_parameter != 0 || text.find_first_of("<&") == std::string_view::npos) return;
    static_cast<Walk*>(data)->stop({Code::unsupported_format,
                                    "the SVG's document type declares parts of the drawing",
                                    {},
                                    "save it as plain SVG"});
  }
  // An encoding of one byte a character that the C library knows, as windows-1252.
  static int on_encoding(void*, const XML_Char* name, XML_Encoding* encoding) {
    const iconv_t converter = ::iconv_open("UTF-32LE", name);
    if (reinterpret_cast<std::intptr_t>(converter) == -1) return XML_STATUS_ERROR;
    for (int i = 0; i < 256; ++i) {
      char byte = static_cast<char>(i), *in = &byte;
      std::array<unsigned char, 4> wide{};
      char* out = reinterpret_cast<char*>(wide.data());
      std::size_t left = 1, room = wide.size();
      const bool good =
          ::iconv(converter, &in, &left, &out, &room) != static_cast<std::size_t>(-1) && room == 0;
      ::iconv(converter, nullptr, nullptr, nullptr, nullptr);
      encoding->map[i] = good ? wide[0] | wide[1] << 8 | wide[2] << 16 : -1;
    }
    ::iconv_close(converter);
    encoding->data = nullptr;
    encoding->convert = nullptr;
    encoding->release = nullptr;
    return XML_STATUS_OK;
  }
  void count(std::string_view text) {
    if (text.size() > left_)
      stop({Code::too_large,
            "the entities of the SVG make it more than " + std::to_string(most_expansion) + " times as large",
            {},
            "save it as plain SVG"});
    left_ -= std::min<std::uint64_t>(left_, text.size());
  }
  void call(Result<void> done) {
    if (!done) stop(std::move(done.error()));
  }
  void stop(Error error) {
    if (!problem_) problem_ = std::move(error);
    XML_StopParser(parser_, XML_FALSE);
  }

  XML_Parser parser_ = nullptr;
  std::uint64_t left_ = 0;  // bytes of text that may come
  std::vector<Space> spaces_;
  int depth_ = 0, foreign_ = 0;  // foreign_: from what depth on
  std::optional<Error> problem_;
};

// What counts for elements before it: what <use> draws, the classes that style sheets hide, all ids and classes, and the rules of
// style sheets that name neither, without blanks.
class Looks : public Walk {
 public:
  Names used, hidden_classes, names, general_rules;

 private:
  Result<void> start(std::string_view element, const Attributes& attributes) override {
    in_style_ = element == "style";
    for (const auto& [key, value] : attributes)
      if (element == "use" && name(key).local == "href" && value.starts_with('#'))
        used.emplace(value.substr(1));
      else if (key == "id" || key == "xml:id")
        names.emplace(value);
      else if (key == "class")
        with_words(value, note_);
    return {};
  }
  Result<void> text(std::string_view text) override {
    if (in_style_) sheet_ += text;
    return {};
  }
  Result<void> end(std::string_view) override {
    in_style_ = false;
    const std::string sheet = without_comments(std::exchange(sheet_, {}));
    for (std::string_view rest = sheet; !rest.empty();) {
      const std::size_t open = std::min(rest.find('{'), rest.size()),
                        close = std::min(rest.find('}'), rest.size());
      if (!with_names(rest.substr(0, open), note_) && rest.substr(0, open).find_first_of(".#@") == rest.npos)
        general_rules.insert(without_blanks(rest.substr(0, close)));
      if (open < close && hides(rest.substr(open + 1, close - open - 1)))
        hide(without_blanks(rest.substr(0, open)));
      rest.remove_prefix(std::min(close + 1, rest.size()));
    }
    return {};
  }
  void hide(std::string_view selectors) {
    while (!selectors.empty()) {
      const std::string_view one = selectors.substr(0, selectors.find(','));
      if (one.starts_with('.')) hidden_classes.emplace(one.substr(1));
      selectors.remove_prefix(std::min(one.size() + 1, selectors.size()));
    }
  }

  const NewName note_ = [this](std::string_view word) { return *names.emplace(word).first; };
  bool in_style_ = false;
  std::string sheet_;
};

// Where a drawing stands among those that become one.
struct Part {
  std::string_view layer;  // empty: it is the whole
  bool first = true, last = true;
  OwnNames own = {};
  const Names* shared_rules = nullptr;  // general rules of all parts
};

class Writer : public Walk {
 public:
  Writer(const Looks& looks, const Part& part, Copy& out) : looks_(looks), part_(part), out_(out) {}

  // How large its page is, by the attributes of the root.
  const std::string& page() const { return page_; }

 private:
  static constexpr std::string_view of_pages[] = {"width", "height", "viewBox", "preserveAspectRatio",
                                                  "inkscape:version"};

  Result<void> start(std::string_view element, const Attributes& attributes) override {
    open_.push_back({std::string(element), hidden(attributes)});
    if (!in_text()) VACUFORM_CHECK(reach_line());
    texts_ += element == "text" ? 1 : 0;
    std::string tag, of_page;
    const bool root = open_.size() == 1;
    for (const auto& [key, value] : attributes) {
      VACUFORM_TRY(kept, attribute(key, value));
      if (kept.first.empty()) continue;
      if (root && kept.first == "inkscape:version") program_ = kept.second;
      (root && one_of(kept.first, of_pages) ? of_page : tag) +=
          " " + kept.first + "=\"" + escaped(kept.second, true) + "\"";
    }
    if (!root) return write("<" + std::string(element) + tag + ">");
    page_ = page_of(attributes);
    std::string begin = "<svg xmlns=\"" + std::string(svg_uri) + "\" xmlns:xlink=\"" +
                        std::string(xlink_uri) + "\" xmlns:inkscape=\"" + std::string(inkscape_uri) + "\"";
    if (part_.layer.empty()) return write(begin + of_page + tag + ">");
    return write((part_.first ? begin + of_page + ">" : std::string()) +
                 "<g inkscape:groupmode=\"layer\" inkscape:label=\"" + escaped(part_.layer, true) + "\"" +
                 tag + ">");
  }
  Result<void> end(std::string_view element) override {
    if (!sheet_.empty()) {
      VACUFORM_TRY(sheet, own_sheet(without_comments(std::exchange(sheet_, {}))));
      VACUFORM_CHECK(write(escaped(sheet, false)));
    }
    texts_ -= element == "text" ? 1 : 0;
    open_.pop_back();
    if (!open_.empty() || part_.layer.empty()) return write("</" + std::string(element) + ">");
    return write(part_.last ? "</g></svg>" : "</g>");
  }
  // Between elements that are not texts only white space is kept.
  Result<void> text(std::string_view text) override {
    if (open_.empty()) return {};
    if (open_.back().element == "style") {
      sheet_ += text;
      return {};
    }
    if (in_text() && !open_.back().hidden) return write(escaped(text, false));
    std::string white(text);
    std::erase_if(white, [](char c) { return c != ' ' && c != '\t' && c != '\n'; });
    return write(white);
  }

  // The program that wrote the file decides how long its pixels are.
  Result<void> comment(std::string_view text) override {
    const std::string generator = svg_generator_comment(text);
    if (generator.empty() || said_generator_) return {};
    said_generator_ = true;
    program_ = generator;
    if (!part_.first) return {};
    VACUFORM_CHECK(reach_line());
    return write("<!-- " + generator + " -->");
  }

  // What stays of an attribute: its name, empty if nothing does, and its value.
  Result<std::pair<std::string, std::string>> attribute(std::string_view key, std::string_view value) const {
    using Kept = std::pair<std::string, std::string>;
    const std::size_t colon = key.find(':');
    const Name whole = name(key);
    if (whole.local == "href" && (colon == key.npos || whole.uri == xlink_uri)) {
      VACUFORM_TRY(target, reference(value));
      if (target.starts_with('#')) target = "#" + part_.own(std::string_view(target).substr(1));
      return Kept(colon == key.npos ? "href" : "xlink:href", std::move(target));
    }
    if (key == "xml:space") return Kept(key, value);
    if (key == "xml:id" || key == "id") return Kept(key, part_.own(value));
    if (key == "class") return Kept(key, with_words(value, part_.own));
    if (whole.local == "groupmode" && whole.uri == inkscape_uri && value == "layer")
      return Kept("inkscape:groupmode", value);
    if (whole.local == "label" && whole.uri == inkscape_uri && drawn_layer(value))
      return Kept("inkscape:label", value);
    if (whole.local == "version" && whole.uri == inkscape_uri && open_.size() == 1)
      if (std::string version = svg_inkscape_version(value); !version.empty())
        return Kept("inkscape:version", std::move(version));
    // Where a layout put a coil on the head: eight numbers.
    if (key == "data-place") return Kept(only_numbers(value) ? key : "", value);
    if (colon != key.npos || !known(key, svg_attributes)) return Kept();
    if (key == "requiredExtensions") return Kept(key, trimmed(value).empty() ? "" : "unknown");
    if (key == "style") return Kept(key, without_notes(addresses(without_comments(value))));
    return Kept(key, addresses(value));
  }

  // Pixels are longer or shorter in each program, so there it counts, too.
  std::string page_of(const Attributes& attributes) const {
    std::string out;
    bool absolute = false, box = false;
    for (const std::string_view name : {"width", "height", "viewBox"})
      for (const auto& [key, value] : attributes) {
        if (key != name) continue;
        const std::string size = without_blanks(value);
        out.append(out.empty() ? "" : ", ").append(name).append(" ").append(trimmed(value));
        box |= name == "viewBox";
        absolute |= !size.empty() && lower(size.back()) >= 'a' && lower(size.back()) <= 'z' &&
                    !lower(size).ends_with("px");
      }
    return absolute && box ? out : out + (program_.empty() ? "" : ", by " + program_);
  }
  std::string addresses(std::string_view text) const { return without_addresses(text, part_.own); }
  // A style sheet counts in the whole file. Beside other drawings, each of its selectors must name a class or an id, or all of
  // them have that rule.
  Result<std::string> own_sheet(std::string_view sheet) const {
    if (part_.layer.empty()) return addresses(sheet);
    std::string out;
    while (!trimmed(sheet).empty()) {
      const std::size_t open = std::min(sheet.find('{'), sheet.size()),
                        close = std::min(sheet.find('}', open), sheet.size());
      auto selectors = with_names(sheet.substr(0, open), part_.own);
      if (!selectors && part_.shared_rules->contains(without_blanks(sheet.substr(0, close))))
        selectors = sheet.substr(0, open);
      if (!selectors || trimmed(sheet).starts_with('@'))
        return fail(
            Code::unusable_pattern, "the style sheet of this drawing would style the other drawings, too", {},
            "save it with its styles in the shapes (Illustrator: presentation attributes), or draw all "
            "layers in one file");
      out += *selectors + addresses(sheet.substr(open, close - open)) + (close < sheet.size() ? "}" : "");
      sheet.remove_prefix(std::min(close + 1, sheet.size()));
    }
    return out;
  }

  // Whether nobody sees the texts in the element that is last in open_.
  bool hidden(const Attributes& attributes) const {
    bool hidden = !open_.empty() && open_.back().hidden;
    for (const auto& [key, value] : attributes) {
      hidden |= (key == "display" && trimmed(value) == "none") ||
                (key == "opacity" && trimmed(value) == "0") || (key == "style" && hides(value));
      for (std::string_view rest = key == "class" ? value : ""; !rest.empty();) {
        const std::string_view one = rest.substr(0, rest.find(' '));
        hidden |= looks_.hidden_classes.contains(one);
        rest.remove_prefix(std::min(one.size() + 1, rest.size()));
      }
    }
    // <use> draws an element whatever hides those around it.
    for (const auto& [key, value] : attributes) hidden &= key != "id" || !looks_.used.contains(value);
    return hidden;
  }
  bool in_text() const { return texts_ > 0; }
  Result<void> reach_line() {
    return line() > line_ ? write(std::string(line() - line_, '\n')) : Result<void>();
  }
  Result<void> write(const std::string& text) {
    line_ += static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
    return out_.write(text);
  }

  struct Open {
    std::string element;
    bool hidden = false;
  };
  const Looks& looks_;
  const Part& part_;
  Copy& out_;
  std::string page_, program_;
  std::vector<Open> open_;
  std::size_t texts_ = 0;  // of them that are open
  std::string sheet_;
  std::size_t line_ = 1;
  bool said_generator_ = false;
};

}  // namespace

Result<void> svg(const ByteSource& file, Copy& out) {
  VACUFORM_TRY(size, file.size());
  if (size > most_svg)
    return fail(Code::too_large, "the SVG has more than " + std::to_string(most_svg >> 20) + " MiB", {},
                "simplify the drawing");
  Looks looks;
  VACUFORM_CHECK(looks.read(file));
  return Writer(looks, Part(), out).read(file);
}

Result<void> svg_of_layers(std::span<const LayerFile> files, Copy& out) {
  Names taken, shared;
  std::string page;
  std::vector<std::unique_ptr<Looks>> looks;
  const auto at_file = [](const LayerFile& file, Error error) {
    if (error.where.empty()) error.where = "the zip, " + file.path;
    return tl::make_unexpected(std::move(error));
  };
  for (const LayerFile& file : files) {
    looks.push_back(std::make_unique<Looks>());
    if (auto read = looks.back()->read(MemorySource(file.text)); !read)
      return at_file(file, std::move(read.error()));
    const Names& rules = looks.back()->general_rules;
    if (looks.size() == 1) shared = rules;
    std::erase_if(shared, [&](const std::string& rule) { return !rules.contains(rule); });
  }
  for (std::size_t i = 0; i < files.size(); ++i) {
    const LayerFile& file = files[i];
    const Part part{file.layer, i == 0, i + 1 == files.size(), OwnNames(looks[i]->names, taken), &shared};
    Writer writer(*looks[i], part, out);
    if (auto written = writer.read(MemorySource(file.text)); !written)
      return at_file(file, std::move(written.error()));
    if (i == 0) page = writer.page();
    if (writer.page() != page)
      return fail(Code::unusable_pattern,
                  "the drawings of the zip have different pages: " + page + " in " + files.front().path +
                      ", " + writer.page() + " in this one",
                  "the zip, " + file.path, "draw all layers on one page: the same width, height and viewBox");
    for (const std::string& word : looks[i]->names) taken.insert(part.own(word));
  }
  return {};
}

}  // namespace vacuform::redaction
