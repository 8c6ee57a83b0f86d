// Makes every flush of a program to the disk take 2 ms longer, as on a plain SSD or a network disk:
//   LD_PRELOAD=$PWD/build/tests/lib/libslow_flush.so build/tests/bin/bench_store
#include <dlfcn.h>

#include <chrono>
#include <thread>

namespace {

int flush(const char* name, int file) {
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  return reinterpret_cast<int (*)(int)>(dlsym(RTLD_NEXT, name))(file);
}

}  // namespace

extern "C" int fsync(int file) { return flush("fsync", file); }
extern "C" int fdatasync(int file) { return flush("fdatasync", file); }
