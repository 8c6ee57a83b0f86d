// Progress on a terminal: one line on stderr, redrawn.
#pragma once

#include <string>
#include <string_view>

#include "api/job.hpp"

namespace vacuform::cli {

// Off a terminal it is silent or prints a line when a stage begins. Used from one thread; as a Context::Listener by
//   ProgressBar bar(ProgressBar::Otherwise::silent);
//   Context context([&](Stage stage, double fraction) { bar.show(stage, fraction); });
class ProgressBar {
 public:
  enum class Otherwise { silent, line_a_stage };
  explicit ProgressBar(Otherwise otherwise) : ProgressBar(otherwise, stderr_is_terminal()) {}
  ProgressBar(Otherwise otherwise, bool terminal) : terminal_(terminal), otherwise_(otherwise) {}
  ~ProgressBar() { clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(Stage stage, double fraction);
  void show(std::string_view what, double fraction);  // not a stage: "upload", "queued"

  // Clears the line, so that something else can be printed.
  void clear();

 private:
  static bool stderr_is_terminal();

  bool terminal_;
  Otherwise otherwise_;
  std::string shown_;  // the current line on the terminal
  std::string stage_;  // the last name
};

}  // namespace vacuform::cli
