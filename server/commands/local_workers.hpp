// The workers that the server starts itself: vacuform-worker beside its own executable, restarted when they
// die.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace vacuform {

struct WorkerCommand {
  std::filesystem::path program;
  std::string server_url;
  std::filesystem::path token_file;
  std::filesystem::path work = {};  // their folder for work; empty: their own choice
  std::string user = {};            // whom they become; empty: who they are
};

// All functions are for one thread, which must live as long as the workers: the kernel ends a worker when the
// thread that started it ends, so that none outlives the server however that dies.
class LocalWorkers {
 public:
  LocalWorkers(WorkerCommand command, int count);
  // Starts those that are due: at first all, later the dead ones after a pause that doubles from 1 s to 30 s
  // with every death in less than a minute. Gives the names of those that died since the last call. Call it
  // about every second and after SIGCHLD.
  std::vector<std::string> tend();
  // Asks all to end (they give their jobs back) and waits; kills what is left after ten seconds.
  void stop();

  static std::string name_of(std::size_t number);  // "local-1" for 0

 private:
  using Instant = std::chrono::steady_clock::time_point;
  struct Worker {
    pid_t process = 0;  // 0: not running
    Instant started{}, due{};
    std::chrono::seconds pause{1};
  };
  void start(Worker& worker, std::size_t number);
  std::vector<std::string> reap();

  WorkerCommand command_;
  std::vector<Worker> workers_;
};

}  // namespace vacuform
