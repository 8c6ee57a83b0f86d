// preview-findings.png: warnings with a place, as numbered marks on a view of the formed sheet, with a legend. Internal
// to worker/inspection.
//
// Each code has its own shape and colour. The colours are those of Okabe and Ito ("Color universal design", 2008),
// which people without full colour vision can distinguish, and two darker ones for heat. The number of a mark is its
// place in the list of the warning, worst first; a ring shows its size, dashed where the sheet hides it.
#pragma once

#include <vector>

#include "worker/inspection/view.hpp"
#include "worker/stage/context.hpp"

namespace vacuform {

// The marks of the warnings that have any: all vents, and the six worst of the others; more would hide the part.
class Callouts {
 public:
  explicit Callouts(const std::vector<Warning>& warnings);

  // Removes the marks that the sheet hides from the view, and returns them.
  Callouts take_hidden(const View& view);
  // Removes the marks that lie as deep behind the sheet from this view as from the previous one, and returns them.
  Callouts take_no_better(const View& view);
  void add(const Callouts& others);
  bool empty() const { return marks_.empty(); }

  // Draws them onto a picture that `view` drew, within its rows from `top` to `bottom`.
  void draw(const View& view, Picture& picture, int top, int bottom) const;

 private:
  struct Mark {
    int look;
    int number;
    Eigen::Vector3d place;
    double size_mm;
    double behind_mm = 0;  // the sheet, from the view asked last
  };
  Callouts() = default;
  template <class Takes>
  Callouts take(const View& view, Takes&& takes);
  std::vector<Mark> marks_;
};

// Titles the picture and replaces its lower caption by a legend of the warnings that have marks, which makes the
// picture higher. `behind`, if present, comes between: a second picture of the same width with `behind_top` rows for
// its own title.
void write_findings(const std::vector<Warning>& warnings, Picture& picture, const Picture* behind);
inline constexpr int behind_height = 760, behind_top = 56;

}  // namespace vacuform
