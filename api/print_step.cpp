#include "api/print_step.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "api/base/text.hpp"

namespace vacuform {

namespace {

constexpr std::string_view conductors[] = {"conductor", "conductors", "silver", "copper", "trace", "traces"};
constexpr std::string_view dielectrics[] = {"dielectric", "dielectrics", "insulator", "insulators",
                                            "insulation"};
constexpr std::string_view bridges[] = {"bridge", "bridges", "jumper", "jumpers", "crossover", "crossovers"};
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
  return std::nullopt;
}

std::optional<DrawnFace> face_of(std::string_view word) {
  if (word == "reverse") return DrawnFace::reverse;
  if (word == "outer") return DrawnFace::outer;
  if (word == "inner") return DrawnFace::inner;
  return std::nullopt;
}

}  // namespace

std::optional<DrawnLayer> drawn_layer(std::string_view name) {
  constexpr std::size_t longest = 64;
  // A letter beyond ASCII would part a word in two.
  if (name.size() > longest || std::any_of(name.begin(), name.end(), [](char c) { return (c & 0x80) != 0; }))
    return std::nullopt;
  std::optional<PrintStep> step;
  std::optional<DrawnFace> face;
  bool print = false, second = false;
  for (const std::string& word : runs_of(name)) {
    if (const auto found = step_of(word)) {
      if (step) return std::nullopt;
      step = found;
    } else if (const auto side = face_of(word)) {
      if (face) return std::nullopt;
      face = side;
    } else if (is_ascii_digit(word.front())) {
      // Drawing programs number layers of one name. A longer number may be that of a patient.
      if (word.size() > 2) return std::nullopt;
    } else if (word == "second") {
      second = true;
    } else if (word == "print") {
      print = true;
    } else if (!one_of(word, fillers)) {
      return std::nullopt;
    }
  }
  if (!step && !print) return std::nullopt;
  DrawnLayer out{step.value_or(PrintStep::conductor), face.value_or(DrawnFace::first)};
  if (second && out.step == PrintStep::conductor) out.step = PrintStep::bridges;
  return out;
}

}  // namespace vacuform
