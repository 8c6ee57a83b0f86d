#include "worker/cli/progress_bar.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace vacuform::cli {

bool ProgressBar::stderr_is_terminal() { return ::isatty(STDERR_FILENO) == 1; }

void ProgressBar::show(Stage stage, double fraction) { show(name(stage), fraction); }

void ProgressBar::show(std::string_view what, double fraction) {
  const bool next = what != stage_;
  stage_ = what;
  if (!terminal_) {
    if (next && otherwise_ == Otherwise::line_a_stage) std::fprintf(stderr, "%s\n", stage_.c_str());
    return;
  }
  constexpr int width = 40;
  const double part = std::clamp(fraction, 0.0, 1.0);
  const int full = static_cast<int>(part * width);
  char text[96];
  std::snprintf(text, sizeof text, "%-10.10s [%s%s] %3d %%", stage_.c_str(), std::string(full, '#').c_str(),
                std::string(width - full, ' ').c_str(), static_cast<int>(part * 100));
  if (text == shown_) return;
  shown_ = text;
  std::fprintf(stderr, "\r%s", text);
  std::fflush(stderr);
}

void ProgressBar::clear() {
  if (shown_.empty()) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  shown_.clear();
}

}  // namespace vacuform::cli
