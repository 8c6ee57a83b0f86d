// Measures the store alone, without HTTP: jobs per second from submission through a lease to their end, and the cost of
// a long queue. Every answer is durable: SQLite in WAL mode with synchronous=FULL, where concurrent changes share one flush;
// or PostgreSQL with its own settings.
//
// bench_store [FOLDER [DATABASE [CYCLES]]]
//   FOLDER: of the store, whose disk is flushed; default: the folder for temporary files.
//   DATABASE: an empty one, as postgresql://user@host/database, or "sqlite"
//   CYCLES: measures instead that many cycles, a fifth at a time: dead rows would make the last fifth slower
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "api/base/file.hpp"
#include "api/base/secrets.hpp"
#include "server/store/store.hpp"

namespace {

using namespace vacuform;
using Seconds = std::chrono::duration<double>;

double seconds_of(const std::function<void()>& work) {
  const auto started = std::chrono::steady_clock::now();
  work();
  return Seconds(std::chrono::steady_clock::now() - started).count();
}

template <class T>
T sound(Result<T> result) {
  if (!result) {
    std::fprintf(stderr, "bench_store: %s\n", result.error().text().c_str());
    std::exit(1);
  }
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

// The median time of a flush of 4 KiB, which bounds what one change at a time can do.
double milliseconds_of_flush(const std::filesystem::path& folder) {
  const auto path = folder / "flushed";
  File file = sound(File::create(path));
  std::vector<double> times;
  for (int i = 0; i < 200; ++i)
    times.push_back(1000 * seconds_of([&] {
                      sound(file.write(std::string(4096, 'x')));
                      sound(file.sync());
                    }));
  std::filesystem::remove(path);
  std::nth_element(times.begin(), times.begin() + 100, times.end());
  return times[100];
}

void together(int threads, const std::function<void()>& work) {
  std::vector<std::thread> all;
  for (int i = 0; i < threads; ++i) all.emplace_back(work);
  for (auto& thread : all) thread.join();
}

// All jobs use the same files, so the benchmark measures rows and not the disk's bandwidth.
void submit(Store& store, const Job& model, int thread) {
  NewJob job{.settings = "{}"};
  for (const Input& input : model.inputs) job.add(input.name, input.blob, input.extension);
  job.owner = "station-" + std::to_string(thread);
  sound(store.create(std::move(job)));
}

Job with_files(Store& store) {
  NewJob job{.settings = "{}"};
  for (const char* name : {"scan", "pattern"}) {
    Upload upload = sound(store.upload());
    if (!upload.write(name)) std::exit(1);
    job.add(name, std::move(upload), "stl");
  }
  return sound(store.create(std::move(job)));
}

bool run_one(Store& store) {
  const auto lease = sound(store.lease("bench"));
  if (!lease) return false;
  sound(store.fail_job({lease->job.id, lease->token}, {}, Retry::never));
  return true;
}

// One cycle at a time in each thread, until `more` is false; how many there were.
int cycles(Store& store, const Job& model, int threads, const std::function<bool()>& more) {
  std::atomic<int> done{0}, number{0};
  together(threads, [&] {
    const int me = number++;
    while (more()) {
      submit(store, model, me);
      if (run_one(store)) ++done;
    }
  });
  return done;
}

void measure_many(Store& store, const Job& model, int count) {
  std::printf("\n%10s %14s\n", "cycles", "cycles/s");
  for (int part = 1; part <= 5; ++part) {
    std::atomic<int> left{count / 5};
    const double took = seconds_of([&] { cycles(store, model, 8, [&] { return left-- > 0; }); });
    std::printf("%10d %14.0f\n", part * (count / 5), count / 5 / took);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (!start_secrets()) return 1;
  const std::filesystem::path folder =
      (argc > 1 ? std::filesystem::path(argv[1]) : std::filesystem::temp_directory_path()) /
      "vacuform-bench-store";
  std::filesystem::remove_all(folder);
  StoreOptions options;
  const bool postgres = argc > 2 && std::string(argv[2]) != "sqlite";
  if (postgres) options.database = argv[2];
  options.most_queued = options.most_queued_by_owner = 1'000'000;
  auto store = sound(open_store(folder, options));
  const Job model = with_files(*store);
  std::printf("%s; store in %s\n", postgres ? "PostgreSQL" : "SQLite: WAL, synchronous=FULL, group commit",
              folder.c_str());

  std::printf("a flush of 4 KiB there takes %.2f ms (median of 200)\n", milliseconds_of_flush(folder));

  if (argc > 3) {
    measure_many(*store, model, std::atoi(argv[3]));
    store.reset();
    std::filesystem::remove_all(folder);
    return 0;
  }
  std::printf("\n%10s %14s %20s\n", "threads", "cycles/s", "(submit+lease+end)");
  for (const int threads : {1, 8, 32, 64}) {
    constexpr double wanted = 4;
    const auto until = std::chrono::steady_clock::now() + Seconds(wanted);
    int done = 0;
    const double took = seconds_of([&] {
      done = cycles(*store, model, threads, [&] { return std::chrono::steady_clock::now() < until; });
    });
    std::printf("%10d %14.0f\n", threads, done / took);
  }
  while (run_one(*store)) {
  }

  std::printf("\n%10s %14s %14s %16s %14s\n", "queued", "submits/s", "page of 100", "lease+end, first",
              "drained/s");
  for (const int count : {100, 1000, 10000}) {
    const double submitted = seconds_of([&] {
      std::atomic<int> left{count}, number{0};
      together(8, [&] {
        const int me = number++;
        while (left-- > 0) submit(*store, model, me);
      });
    });
    std::string cursor;
    int pages = 0, jobs = 0;
    const double paged = seconds_of([&] {
      do {
        const auto page = sound(store->list(100, cursor));
        jobs += static_cast<int>(page.jobs.size());
        cursor = page.next.value_or("");
        ++pages;
      } while (!cursor.empty() && jobs < count);
    });
    const double first = seconds_of([&] { run_one(*store); });
    const double drained = seconds_of([&] {
      together(8, [&] {
        while (run_one(*store)) {
        }
      });
    });
    std::printf("%10d %14.0f %11.2f ms %13.2f ms %14.0f\n", count, count / submitted, 1000 * paged / pages,
                1000 * first, (count - 1) / drained);
    std::fflush(stdout);
  }
  store.reset();
  std::filesystem::remove_all(folder);
  return 0;
}
