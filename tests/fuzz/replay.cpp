// Runs one entry point over every file of some folders, then over random mutations of them: flipped bits, extreme
// numbers, pieces cut out, repeated and exchanged between files. The random numbers are the same on every machine, so a
// failure can be reproduced.
//
//   fuzz_replay TARGET SECONDS FOLDER...
//   fuzz_replay --costly TARGET SECONDS FOLDER...
//
// With --costly the mutations begin with the inputs that took the most time per byte so far, to find those for which a
// small file is much work; the costliest is saved as costliest-TARGET.
//
// An input may use ten seconds of processor time and 1 GiB of memory. An input that uses more, or breaks an assertion,
// ends the program and is saved in the working directory as found-TARGET. At the end the ten slowest inputs are listed.
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/targets.hpp"

namespace {

using namespace vacuform::fuzz;
using Input = std::vector<std::uint8_t>;

constexpr int most_seconds = 10;
constexpr rlim_t most_memory = rlim_t{1} << 30;
constexpr std::size_t largest_input = 1 << 20;

// Data of the signal handler, global so that the handler can reach it.
std::array<char, 64> found_file{};
const Input* running = nullptr;

void keep_what_ran(int signal) {
  const int file = ::open(found_file.data(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file >= 0 && running) {
    [[maybe_unused]] const ssize_t n = ::write(file, running->data(), running->size());
  }
  constexpr char late[] = "the input took longer than 10 s of the processor\n";
  if (signal == SIGPROF) {
    [[maybe_unused]] const ssize_t n = ::write(STDERR_FILENO, late, sizeof late - 1);
  }
  ::signal(SIGABRT, SIG_DFL);
  ::abort();
}

void limit_this_process(std::string_view target_name) {
  std::snprintf(found_file.data(), found_file.size(), "found-%s", target_name.data());
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGPROF})
    ::signal(signal, keep_what_ran);
  const rlimit memory{most_memory, most_memory};
  ::setrlimit(RLIMIT_DATA, &memory);
}

double processor_seconds() {
  timespec t{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// What ran and how long, in seconds of processor time.
struct Run {
  double seconds;
  std::string name;
};

Run run(const Target& target, const Input& input, std::string name) {
  running = &input;
  const itimerval limit{{0, 0}, {most_seconds, 0}}, none{};
  ::setitimer(ITIMER_PROF, &limit, nullptr);
  const double started = processor_seconds();
  target.run(input);
  const double seconds = processor_seconds() - started;
  ::setitimer(ITIMER_PROF, &none, nullptr);
  return {seconds, std::move(name)};
}

// Keeps the ten slowest runs, the slowest first.
void remember(std::vector<Run>& slowest, Run r) {
  const auto place = std::find_if(slowest.begin(), slowest.end(),
                                  [&](const Run& other) { return r.seconds > other.seconds; });
  slowest.insert(place, std::move(r));
  if (slowest.size() > 10) slowest.pop_back();
}

struct Seed {
  std::string name;
  Input bytes;
};

std::vector<Seed> read_seeds(int count, char** folders) {
  std::vector<std::filesystem::path> files;
  for (int i = 0; i < count; ++i)
    if (std::filesystem::is_directory(folders[i]))
      for (const auto& entry : std::filesystem::directory_iterator(folders[i])) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<Seed> seeds;
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    seeds.push_back({file.filename().string(), Input(std::istreambuf_iterator<char>(in), {})});
  }
  return seeds;
}

// The same numbers on every machine: the standard fixes mt19937_64 itself, but not its distributions.
class Chance {
 public:
  std::size_t below(std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(engine_() % n); }

 private:
  std::mt19937_64 engine_{20181};
};

// Applies one mutation to the input.
void mutate_once(Input& input, const std::vector<Seed>& seeds, Chance& chance) {
  static constexpr std::array<std::uint32_t, 10> numbers{
      0, 1, 0x7f, 0xff, 0x7fff, 0x7fffffff, 0x80000000, 0xffffffff, 0x7fc00000, 0x7f800000};
  static constexpr std::array<std::string_view, 12> words{
      "-1", "0",     "1e308", "nan", "inf", "4294967296",
      "\n", "solid", "\r\n",  "\"",  "{",   "999999999999999999999"};
  const std::size_t at = chance.below(input.size() + 1);
  const auto place = input.begin() + static_cast<std::ptrdiff_t>(at);
  const std::size_t length = 1 + chance.below(std::min<std::size_t>(input.size() - at + 1, 256));
  const auto end = input.begin() + static_cast<std::ptrdiff_t>(std::min(at + length, input.size()));
  switch (chance.below(7)) {
    case 0:  // flip a bit
      if (at < input.size()) input[at] ^= static_cast<std::uint8_t>(1u << chance.below(8));
      break;
    case 1: {  // set a number, in either byte order
      std::uint32_t number = numbers[chance.below(numbers.size())];
      if (chance.below(2) == 1) number = __builtin_bswap32(number);
      if (at + 4 <= input.size()) std::memcpy(&input[at], &number, 4);
      break;
    }
    case 2: {  // insert a word
      const std::string_view word = words[chance.below(words.size())];
      input.insert(place, word.begin(), word.end());
      break;
    }
    case 3:  // remove a piece
      input.erase(place, end);
      break;
    case 4: {  // repeat a piece
      const Input piece(place, end);
      input.insert(input.begin() + static_cast<std::ptrdiff_t>(at), piece.begin(), piece.end());
      break;
    }
    case 5: {  // insert a piece of another input
      const Input& other = seeds[chance.below(seeds.size())].bytes;
      const std::size_t from = chance.below(other.size() + 1);
      const std::size_t n = std::min(length, other.size() - from);
      const auto piece = other.begin() + static_cast<std::ptrdiff_t>(from);
      input.insert(place, piece, piece + static_cast<std::ptrdiff_t>(n));
      break;
    }
    default:  // cut off the end
      if (chance.below(4) == 0) input.resize(at);
  }
}

// The inputs that take the most time per byte, the costliest first.
class Costliest {
 public:
  void offer(const Input& input, double seconds) {
    const double cost = seconds / static_cast<double>(input.size() + usual_head);
    const auto place =
        std::find_if(kept_.begin(), kept_.end(), [&](const auto& other) { return cost > other.first; });
    if (place == kept_.end() && kept_.size() == most) return;
    kept_.insert(place, {cost, {"", input}});
    if (kept_.size() > most) kept_.pop_back();
  }
  const Input& any(Chance& chance) const { return kept_[chance.below(kept_.size())].second.bytes; }
  const Input& first() const { return kept_.front().second.bytes; }

 private:
  static constexpr std::size_t most = 24, usual_head = 256;  // bytes: less is not a small file but none
  std::vector<std::pair<double, Seed>> kept_;
};

Input mutated(const Input& from, const std::vector<Seed>& seeds, Chance& chance) {
  Input input = from;
  for (std::size_t i = 0, turns = 1 + chance.below(6); i < turns; ++i) mutate_once(input, seeds, chance);
  if (input.size() > largest_input) input.resize(largest_input);
  return input;
}

}  // namespace

int main(int argc, char** argv) {
  const bool costly = argc > 1 && std::string_view(argv[1]) == "--costly";
  if (costly) --argc, ++argv;
  const Target* chosen = argc > 3 ? target(argv[1]) : nullptr;
  double seconds = 0;
  if (!chosen || std::from_chars(argv[2], argv[2] + std::strlen(argv[2]), seconds).ec != std::errc()) {
    std::fprintf(stderr, "usage: fuzz_replay [--costly] TARGET SECONDS FOLDER...\n");
    return 2;
  }
  const auto seeds = read_seeds(argc - 3, argv + 3);
  if (std::none_of(seeds.begin(), seeds.end(),
                   [](const Seed& s) { return s.bytes.size() <= largest_input; })) {
    std::fprintf(stderr, "there is nothing to run in the folders\n");
    return 2;
  }
  limit_this_process(chosen->name);

  std::vector<Run> slowest;
  Costliest costliest;
  for (const Seed& seed : seeds) {
    std::printf("%s\n", seed.name.c_str());
    std::fflush(stdout);
    const Run done = run(*chosen, seed.bytes, seed.name);
    if (seed.bytes.size() <= largest_input) costliest.offer(seed.bytes, done.seconds);
    remember(slowest, done);
  }
  Chance chance;
  std::size_t count = 0;
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  for (; std::chrono::steady_clock::now() < until; ++count) {
    const Input* from = nullptr;
    do from = costly ? &costliest.any(chance) : &seeds[chance.below(seeds.size())].bytes;
    while (from->size() > largest_input);
    const Input input = mutated(*from, seeds, chance);
    Run done = run(*chosen, input,
                   "mutation " + std::to_string(count) + ", " + std::to_string(input.size()) + " bytes");
    if (costly) costliest.offer(input, done.seconds);
    remember(slowest, std::move(done));
  }
  if (costly) {
    const Input& first = costliest.first();
    std::ofstream("costliest-" + std::string(chosen->name), std::ios::binary)
        .write(reinterpret_cast<const char*>(first.data()), static_cast<std::streamsize>(first.size()));
  }
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  std::printf("%s: %zu files and %zu mutations, memory at most %ld MiB, the slowest:\n", argv[1],
              seeds.size(), count, used.ru_maxrss / 1024);
  for (const Run& r : slowest) std::printf("%8.2f s  %s\n", r.seconds, r.name.c_str());
  return 0;
}
