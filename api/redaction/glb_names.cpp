#include "api/redaction/glb_names.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "api/redaction/picture_names.hpp"

namespace vacuform {

namespace {

constexpr std::uint32_t json_mark = 0x4E4F534A, binary_mark = 0x004E4942;

std::uint32_t little_endian(std::string_view bytes, std::size_t at) {
  std::uint32_t number = 0;
  for (std::size_t i = 4; i-- > 0;) number = number << 8 | static_cast<unsigned char>(bytes[at + i]);
  return number;
}

// The known properties of the parts of the binary chunk.
struct View {
  std::uint64_t offset = 0, bytes = 0;
  bool picture = false, geometry = false;
  void fields(FilterState& state) { state(offset, bytes, picture, geometry); }
};

// The JSON chunk, character by character: blanks its texts, and finds the views that contain pictures.
class JsonTexts {
 public:
  char step(char c) {
    if (spoilt_) return blank(c);
    if (in_string_) return in_string(c);
    if (dropping_) return drop(c);
    return between(c);
  }
  const std::vector<View>& views() const { return views_; }
  void fields(FilterState& state) {
    state(levels_, key_, number_, in_string_, escaped_, is_key_, dropping_, dropped_, drop_quoted_,
          drop_depth_, spoilt_, item_, views_);
  }

 private:
  static constexpr std::size_t deepest = 64, longest_key = 32, most_views = 65'536;

  // One open object or array.
  struct Level {
    bool object = false, wants_key = false;
    std::string key;  // of an array the one that it stands under
    void fields(FilterState& state) { state(object, wants_key, key); }
  };

  static char blank(char c) { return c == '\n' || c == '\r' || c == '\t' ? c : ' '; }

  // Texts that a reader of the geometry uses.
  static bool needed(std::string_view key) {
    constexpr std::array<std::string_view, 5> keys{"type", "version", "minVersion", "extensionsUsed",
                                                   "extensionsRequired"};
    return std::find(keys.begin(), keys.end(), key) != keys.end();
  }
  std::string_view key() const { return levels_.empty() ? std::string_view() : levels_.back().key; }

  char in_string(char c) {
    const bool end = c == '"' && !escaped_;
    escaped_ = c == '\\' && !escaped_;
    if (end) {
      in_string_ = false;
      if (is_key_) end_key();
      return c;
    }
    if (!is_key_) return needed(key()) ? c : blank(c);
    if (key_.size() <= longest_key) key_ += c;
    return c;
  }

  // Keys stay: the keys of glTF contain no names, and its "extras" are dropped completely.
  void end_key() {
    if (!levels_.empty()) levels_.back().key = key_;
    key_.clear();
  }

  char between(char c) {
    if (c >= '0' && c <= '9') {
      if (key() == "extras") return begin_drop(c);
      if (number_.size() < 16) number_ += c;
      return c;
    }
    if (!number_.empty()) end_number();
    switch (c) {
      case '"':
        is_key_ = !levels_.empty() && levels_.back().object && levels_.back().wants_key;
        if (!is_key_ && key() == "extras") return begin_drop(c);
        in_string_ = true;
        return c;
      case ':':
        if (!levels_.empty()) levels_.back().wants_key = false;
        return c;
      case ',':
        if (!levels_.empty()) levels_.back().wants_key = levels_.back().object;
        if (levels_.size() == 2) ++item_;
        return c;
      case '{':
      case '[':
        return key() == "extras" ? begin_drop(c) : open(c);
      case '}':
      case ']':
        if (!levels_.empty()) levels_.pop_back();
        return c;
      case ' ':
      case '\t':
      case '\r':
      case '\n':
        return c;
      default:  // true, false, null, a sign, a point
        return key() == "extras" ? begin_drop(c) : c;
    }
  }

  char open(char c) {
    if (levels_.size() == deepest) return spoil(c);
    const std::string under = c == '[' ? std::string(key()) : std::string();
    levels_.push_back({c == '{', c == '{', under});
    if (levels_.size() == 2) item_ = 0;
    return c;
  }

  char spoil(char c) {
    spoilt_ = true;
    return blank(c);
  }

  // Writes a zero in place of the value that starts here.
  char begin_drop(char c) {
    dropping_ = true;
    dropped_ = false;
    drop_depth_ = 0;
    return drop(c);
  }

  // Ends behind the value: with its last bracket or quote, or, of a bare word, before what follows.
  char drop(char c) {
    const char out = std::exchange(dropped_, true) ? blank(c) : '0';
    if (drop_quoted_) {
      drop_quoted_ = c != '"' || escaped_;
      escaped_ = c == '\\' && !escaped_;
      if (!drop_quoted_ && drop_depth_ == 0) end_drop();
    } else if (c == '"') {
      drop_quoted_ = true;
    } else if (c == '{' || c == '[') {
      ++drop_depth_;
    } else if (c == '}' || c == ']' || c == ',') {
      if (drop_depth_ == 0) return end_word(c);
      if (c != ',' && --drop_depth_ == 0) end_drop();
    }
    return out;
  }
  void end_drop() {
    dropping_ = false;
    levels_.back().key.clear();
  }
  char end_word(char c) {
    end_drop();
    return between(c);
  }

  // Of {"images": [{"bufferView": 3}], "bufferViews": [{"byteOffset": 12, "byteLength": 34}]} and the like.
  void end_number() {
    std::uint64_t number = 0;
    for (const char digit : number_) number = 10 * number + static_cast<std::uint64_t>(digit - '0');
    number_.clear();
    if (levels_.size() != 3) return;
    const std::string_view list = levels_[1].key, what = levels_[2].key;
    if (list == "bufferViews" && (what == "byteOffset" || what == "byteLength")) {
      if (View* view = view_of(item_)) (what == "byteOffset" ? view->offset : view->bytes) = number;
    } else if (what == "bufferView" && (list == "images" || list == "accessors")) {
      if (View* view = view_of(number)) (list == "images" ? view->picture : view->geometry) = true;
    }
  }
  View* view_of(std::uint64_t index) {
    if (index >= most_views) {
      spoilt_ = true;
      return nullptr;
    }
    if (index >= views_.size()) views_.resize(index + 1);
    return &views_[index];
  }

  std::vector<Level> levels_;
  std::string key_, number_;
  bool in_string_ = false, escaped_ = false, is_key_ = false, spoilt_ = false;
  bool dropping_ = false, dropped_ = false,
       drop_quoted_ = false;  // of a value that goes: whether its nought is out
  std::int64_t drop_depth_ = 0;
  std::uint64_t item_ = 0;  // of the list that the root's key names
  std::vector<View> views_;
};

// A picture of the binary chunk: PNG and JPEG keep their pixels and lose their texts, any other becomes zeros.
class PictureNames {
 public:
  void take(std::string_view in, std::string& out) {
    if (kind_ == Kind::undecided) {
      const std::size_t wanted = std::min(magic_size - head_.size(), in.size());
      head_ += in.substr(0, wanted);
      in.remove_prefix(wanted);
      if (head_.size() < magic_size) return;
      kind_ = head_ == "\x89PNG\r\n\x1a\n"        ? Kind::png
              : head_.starts_with("\xff\xd8\xff") ? Kind::jpeg
                                                  : Kind::other;
      format_ = format_of(kind_);
      pass(std::exchange(head_, {}), out);
    }
    pass(in, out);
  }
  // Of one picture; the next may begin.
  void end(std::string& out) {
    out.append(head_.size(), '\0');
    if (format_) format_->end(out);
    *this = {};
  }
  void fields(FilterState& state) {
    state(kind_, head_);
    if (state.reads()) format_ = format_of(kind_);
    if (format_) format_->fields(state);
  }

 private:
  enum class Kind { undecided, png, jpeg, other };
  static constexpr std::size_t magic_size = 8;

  static std::unique_ptr<NameFilter::Format> format_of(Kind kind) {
    return kind == Kind::png ? png_names() : kind == Kind::jpeg ? jpeg_names() : nullptr;
  }
  void pass(std::string_view in, std::string& out) {
    if (format_)
      format_->take(in, out);
    else
      out.append(in.size(), '\0');
  }

  Kind kind_ = Kind::undecided;
  std::string head_;
  std::unique_ptr<NameFilter::Format> format_;
};

class GlbNames : public NameFilter::Format {
 public:
  void take(std::string_view in, std::string& out) override {
    while (!in.empty()) {
      const std::size_t n = many(in, out);
      in.remove_prefix(n);
      if (n > 0 || in.empty()) continue;
      out += step(in[0]);
      in.remove_prefix(1);
    }
  }
  void end(std::string& out) override { picture_.end(out); }
  void fields(FilterState& state) override {
    state(place_, head_, left_, padding_, at_);
    json_.fields(state);
    picture_.fields(state);
  }

 private:
  enum class Place { head, json, padding, binary_head, binary, behind, as_it_is };

  // Takes as many of the next bytes as are of one sort, 0 if they go one by one.
  std::size_t many(std::string_view in, std::string& out) {
    if (place_ == Place::as_it_is) {
      out += in;
      return in.size();
    }
    if (place_ != Place::binary) return 0;
    if (!pictures_known_) find_pictures();
    while (next_ < pictures_.size() && at_ >= pictures_[next_].end) ++next_;
    const bool in_picture = next_ < pictures_.size() && at_ >= pictures_[next_].begin;
    const std::uint64_t stop = next_ == pictures_.size() ? at_ + left_
                               : in_picture              ? pictures_[next_].end
                                                         : pictures_[next_].begin;
    const auto n = static_cast<std::size_t>(std::min({std::uint64_t{in.size()}, left_, stop - at_}));
    at_ += n;
    left_ -= n;
    if (in_picture)
      picture_.take(in.substr(0, n), out);
    else
      out += in.substr(0, n);
    if (in_picture && (at_ == stop || left_ == 0)) picture_.end(out);
    if (left_ == 0) place_ = Place::behind;
    return n;
  }

  char step(char c) {
    switch (place_) {
      case Place::head:
        head_ += c;
        if (head_.size() == 20) begin_json();
        return c;
      case Place::json:
        c = json_.step(c);
        if (--left_ == 0) end_json();
        return c;
      case Place::padding:
        if (--padding_ == 0) place_ = Place::binary_head;
        return ' ';
      case Place::binary_head:
        head_ += c;
        if (head_.size() == 8) begin_binary();
        return c;
      case Place::behind:
        return '\0';
      case Place::binary:
      case Place::as_it_is:
        break;  // many() took them
    }
    return c;
  }

  // Invalid content stays as it is: the reader refuses it and reports what happened to the file.
  void begin_json() {
    left_ = little_endian(head_, 12);
    padding_ = (4 - left_ % 4) % 4;
    place_ = little_endian(head_, 4) == 2 && little_endian(head_, 16) == json_mark && left_ > 0
                 ? Place::json
                 : Place::as_it_is;
  }
  void end_json() {
    head_.clear();
    place_ = padding_ > 0 ? Place::padding : Place::binary_head;
  }
  void begin_binary() {
    left_ = little_endian(head_, 0);
    place_ = little_endian(head_, 4) != binary_mark ? Place::as_it_is
             : left_ > 0                            ? Place::binary
                                                    : Place::behind;
  }

  // The parts of the binary chunk that only pictures use, in order and without overlaps.
  void find_pictures() {
    pictures_known_ = true;
    pictures_.clear();
    next_ = 0;
    for (const View& view : json_.views())
      if (view.picture && !view.geometry) pictures_.push_back({view.offset, view.offset + view.bytes});
    std::sort(pictures_.begin(), pictures_.end(),
              [](const Stretch& a, const Stretch& b) { return a.begin < b.begin; });
    std::uint64_t end = 0;
    for (Stretch& picture : pictures_) {
      end = std::max(end, picture.end);
      picture.end = end;
    }
  }

  struct Stretch {
    std::uint64_t begin, end;
  };
  Place place_ = Place::head;
  std::string head_;
  std::uint64_t left_ = 0;     // of the chunk
  std::uint64_t padding_ = 0;  // behind the JSON chunk
  std::uint64_t at_ = 0;       // within the binary chunk
  JsonTexts json_;
  std::vector<Stretch> pictures_;  // made from json_ when they are needed
  std::size_t next_ = 0;
  PictureNames picture_;  // where next_ is
  bool pictures_known_ = false;
};

}  // namespace

std::unique_ptr<NameFilter::Format> glb_names() { return std::make_unique<GlbNames>(); }

}  // namespace vacuform
