#include "server/commands/local_workers.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "api/base/log.hpp"

namespace vacuform {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

std::string LocalWorkers::name_of(std::size_t number) { return "local-" + std::to_string(number + 1); }

LocalWorkers::LocalWorkers(WorkerCommand command, int count)
    : command_(std::move(command)), workers_(static_cast<std::size_t>(count)) {}

void LocalWorkers::start(Worker& worker, std::size_t number) {
  // Everything that allocates comes before the fork: other threads may hold the allocator's locks.
  const std::string name = name_of(number), program = command_.program.string();
  std::vector<std::string> words{
      program, "--server", command_.server_url, "--token-file", command_.token_file.string(), "--name", name};
  if (!command_.work.empty()) words.insert(words.end(), {"--work", command_.work.string()});
  if (!command_.user.empty()) words.insert(words.end(), {"--user", command_.user});
  std::vector<char*> arguments;
  for (const auto& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);  // the server died in between
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    ::close_range(3, ~0u, 0);  // no socket and no store for a worker
    ::execv(program.c_str(), arguments.data());
    ::_exit(127);
  }
  worker.started = steady_clock::now();
  worker.process = std::max<pid_t>(child, 0);
  if (child < 0) worker.due = worker.started + worker.pause;
  log_event(child < 0 ? "worker-not-started" : "worker-started", {{"worker", name}, {"process", child}});
}

std::vector<std::string> LocalWorkers::reap() {
  std::vector<std::string> died;
  for (std::size_t i = 0; i < workers_.size(); ++i) {
    Worker& worker = workers_[i];
    int status = 0;
    if (worker.process == 0 || ::waitpid(worker.process, &status, WNOHANG) != worker.process) continue;
    const auto now = steady_clock::now();
    if (now - worker.started > 1min) worker.pause = 1s;
    worker.due = now + worker.pause;
    worker.pause = std::min<std::chrono::seconds>(worker.pause * 2, 30s);
    worker.process = 0;
    died.push_back(name_of(i));
    log_event("worker-ended", {{"worker", died.back()},
                               {WIFSIGNALED(status) ? "signal" : "exit",
                                WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status)}});
  }
  return died;
}

std::vector<std::string> LocalWorkers::tend() {
  std::vector<std::string> died = reap();
  for (std::size_t i = 0; i < workers_.size(); ++i)
    if (workers_[i].process == 0 && steady_clock::now() >= workers_[i].due) start(workers_[i], i);
  return died;
}

void LocalWorkers::stop() {
  const auto running = [&] {
    return std::any_of(workers_.begin(), workers_.end(), [](const Worker& w) { return w.process != 0; });
  };
  const auto tell = [&](int signal) {
    for (const Worker& worker : workers_)
      if (worker.process != 0) ::kill(worker.process, signal);
  };
  tell(SIGTERM);
  const auto deadline = steady_clock::now() + 10s;
  while (running() && steady_clock::now() < deadline) std::this_thread::sleep_for(20ms), reap();
  tell(SIGKILL);
  while (running()) std::this_thread::sleep_for(20ms), reap();
}

}  // namespace vacuform
