// libFuzzer's door to the entry points: VACUFORM_FUZZ_TARGET names the one that is fuzzed.
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/targets.hpp"

namespace {
const vacuform::fuzz::Target* chosen = nullptr;
}

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* name = std::getenv("VACUFORM_FUZZ_TARGET");
  chosen = vacuform::fuzz::target(name ? name : "");
  if (chosen) return 0;
  std::fprintf(stderr, "VACUFORM_FUZZ_TARGET names none of:");
  for (const auto& t : vacuform::fuzz::targets()) std::fprintf(stderr, " %s", t.name.data());
  std::fprintf(stderr, "\n");
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  chosen->run({bytes, size});
  return 0;
}
