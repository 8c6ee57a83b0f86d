// Waiting for what another thread or process does: generously, and never for ever.
#pragma once

#include <chrono>
#include <thread>

namespace vacuform {

// True as soon as the condition holds; false when it does not within thirty seconds.
template <class Condition>
[[nodiscard]] bool eventually(const Condition& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace vacuform
