#include "worker/cli/progress_bar.hpp"

#include <gtest/gtest.h>

namespace vacuform::cli {
namespace {

std::string shown_by(bool terminal, ProgressBar::Otherwise otherwise) {
  testing::internal::CaptureStderr();
  {
    ProgressBar bar(otherwise, terminal);
    bar.show(Stage::scan, 0);
    bar.show(Stage::scan, 0.5);
    bar.show(Stage::scan, 0.5);  // nothing new, nothing drawn
    bar.show("a name that is far too long", 2);
  }
  return testing::internal::GetCapturedStderr();
}

TEST(ProgressBar, RedrawsOneLineOfATerminalAndTakesItAway) {
  const std::string blank(40, ' '), half = std::string(20, '#') + std::string(20, ' '), full(40, '#');
  EXPECT_EQ(shown_by(true, ProgressBar::Otherwise::silent),
            "\rscan       [" + blank + "]   0 %" + "\rscan       [" + half + "]  50 %" + "\ra name tha [" +
                full + "] 100 %" + "\r\033[K");
}

TEST(ProgressBar, OffATerminalItIsSilentOrALineAStage) {
  EXPECT_EQ(shown_by(false, ProgressBar::Otherwise::silent), "");
  EXPECT_EQ(shown_by(false, ProgressBar::Otherwise::line_a_stage), "scan\na name that is far too long\n");
}

}  // namespace
}  // namespace vacuform::cli
