// For loops that the compiler makes twice, for every processor and for those with AVX2: the same operations lane by lane,
// so the results are the same.
#pragma once

// Of what both versions call: it is compiled into either.
#define VACUFORM_INLINE [[gnu::always_inline]] inline

namespace vacuform {

inline bool processor_has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2");
#else
  return false;
#endif
}

}  // namespace vacuform
