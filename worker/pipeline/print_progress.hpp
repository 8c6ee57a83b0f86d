// What each step of a print has of the progress of its stage. The stages before have only one step.
#pragma once

#include "worker/stage/sub_progress.hpp"

namespace vacuform::progress {

inline constexpr StageShare cutting{Stage::printing, 0, 0.05};
inline constexpr StageShare placing{Stage::printing, 0.05, 0.2};
inline constexpr StageShare decoupling{Stage::printing, 0.2, 0.4};
inline constexpr StageShare pulling_back{Stage::printing, 0.4, 0.5};
inline constexpr StageShare printing{Stage::printing, 0.5, 1};
inline constexpr StageShare measuring{Stage::inspection, 0, 0.2};
inline constexpr StageShare comparing{Stage::inspection, 0.2, 0.3};
inline constexpr StageShare showing{Stage::inspection, 0.3, 1};

}  // namespace vacuform::progress
