#include "api/print_step.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "api/base/text.hpp"

namespace vacuform {

namespace {

constexpr std::string_view conductors[] = {"conductor", "conductors", "conductive", "silver",
                                           "copper",    "cu",         "trace",      "traces"};
constexpr std::string_view dielectrics[] = {"dielectric", "dielectrics", "insulator",
                                            "insulators", "insulation",  "insulating"};
constexpr std::string_view bridges[] = {"bridge", "bridges", "jumper", "jumpers", "crossover", "crossovers"};
constexpr std::string_view resists[] = {"resist",      "resists",  "soldermask",  "solderresist",
                                        "cover",       "coverlay", "covercoat",   "overcoat",
                                        "encapsulant", "varnish",  "encapsulants"};
constexpr std::string_view pictures[] = {"graphic",  "graphics",   "picture", "pictures",   "artwork",
                                         "artworks", "image",      "images",  "decoration", "decorations",
                                         "colour",   "colours",    "color",   "colors",     "legend",
                                         "legends",  "silkscreen", "silks"};
// After F. or B. they name a layer of a board: in "silver b" the letter may be anything.
constexpr std::string_view of_boards[] = {"cu", "silkscreen", "silks", "mask"};
constexpr std::string_view fillers[] = {"layer", "ink", "face", "side", "step"};

bool is_ascii_letter(char c) { return lower(c) >= 'a' && lower(c) <= 'z'; }
bool is_ascii_digit(char c) { return c >= '0' && c <= '9'; }

// Runs of letters and runs of digits, in lower case.
std::vector<std::string> runs_of(std::string_view name) {
  std::vector<std::string> out;
  char before = ' ';
  for (const char c : name) {
    const bool letter = is_ascii_letter(c);
    if (letter || is_ascii_digit(c)) {
      if (letter ? !is_ascii_letter(before) : !is_ascii_digit(before)) out.emplace_back();
      out.back() += lower(c);
    }
    before = c;
  }
  return out;
}

std::optional<PrintStep> step_of(std::string_view word) {
  if (one_of(word, conductors)) return PrintStep::conductor;
  if (one_of(word, dielectrics)) return PrintStep::dielectric;
  if (one_of(word, bridges)) return PrintStep::bridges;
  if (one_of(word, resists)) return PrintStep::resist;
  if (one_of(word, pictures)) return PrintStep::picture;
  return std::nullopt;
}

std::optional<DrawnFace> face_of(std::string_view word) {
  if (word == "reverse") return DrawnFace::reverse;
  if (word == "outer") return DrawnFace::outer;
  if (word == "inner") return DrawnFace::inner;
  return std::nullopt;
}

// What the words of a name say together.
class LayerName {
 public:
  // False: with this word it is a name like any other.
  bool add(const std::string& word) {
    if (const auto found = step_of(word)) return set(step_, *found) && note_board(word);
    if (const auto side = face_of(word)) return set(face_, *side);
    // Drawing programs number layers of one name. A longer number may be that of a patient.
    if (is_ascii_digit(word.front())) return word.size() <= 2;
    if (word == "f" || word == "b") {
      by_letter_ = true;
      return set(face_, word == "b" ? DrawnFace::reverse : DrawnFace::first);
    }
    if (bool* const flag = flag_of(word)) {
      *flag = true;
      return note_board(word);
    }
    return one_of(word, fillers);
  }

  std::optional<DrawnLayer> layer() const {
    // A mask alone may be anything that covers.
    const bool of_board = mask_ && by_letter_;
    const auto step = !step_ && mask_ && (solder_ || of_board) ? std::optional(PrintStep::resist) : step_;
    const bool resist = step == PrintStep::resist;
    if ((!step && !print_) || (by_letter_ && !board_)) return std::nullopt;
    if ((mask_ || solder_ || openings_) && !resist) return std::nullopt;
    if (invert_ && !of_board) return std::nullopt;
    DrawnLayer out{step.value_or(PrintStep::conductor), face_.value_or(DrawnFace::first),
                   openings_ || (of_board && !invert_)};
    if (second_ && out.step == PrintStep::conductor) out.step = PrintStep::bridges;
    return out;
  }

 private:
  template <class T>
  static bool set(std::optional<T>& what, T value) {
    return !std::exchange(what, value);
  }
  bool* flag_of(std::string_view word) {
    return word == "second"                          ? &second_
           : word == "print"                         ? &print_
           : word == "solder"                        ? &solder_
           : word == "mask"                          ? &mask_
           : word == "invert"                        ? &invert_
           : word == "opening" || word == "openings" ? &openings_
                                                     : nullptr;
  }
  bool note_board(std::string_view word) {
    board_ |= one_of(word, of_boards);
    return true;
  }

  std::optional<PrintStep> step_;
  std::optional<DrawnFace> face_;
  bool print_ = false, second_ = false, solder_ = false, mask_ = false, openings_ = false, invert_ = false;
  bool by_letter_ = false, board_ = false;
};

}  // namespace

std::optional<DrawnLayer> drawn_layer(std::string_view name) {
  constexpr std::size_t longest = 64;
  // A letter beyond ASCII would part a word in two.
  if (name.size() > longest || std::any_of(name.begin(), name.end(), [](char c) { return (c & 0x80) != 0; }))
    return std::nullopt;
  LayerName words;
  for (const std::string& word : runs_of(name))
    if (!words.add(word)) return std::nullopt;
  return words.layer();
}

}  // namespace vacuform
