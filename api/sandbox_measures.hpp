// The words for what keeps a job's process from everything but its job; worker/agent/sandbox.hpp says what each is.
#pragma once

#include <array>
#include <string_view>

namespace vacuform {

inline constexpr std::array<std::string_view, 3> sandbox_measures{"namespaces", "landlock", "seccomp"};

}  // namespace vacuform
