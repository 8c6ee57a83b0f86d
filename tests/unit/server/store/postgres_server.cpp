#include "tests/unit/server/store/postgres_server.hpp"

#include <fcntl.h>
#include <pwd.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>
#include <vector>

#include "api/base/secrets.hpp"

namespace vacuform {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void give_up(const std::string& what) {
  std::fprintf(stderr, "postgres_server: %s\n", what.c_str());
  std::exit(1);
}

// The newest version of Debian's packages.
fs::path programs() {
  fs::path newest;
  std::error_code error;
  for (const auto& version : fs::directory_iterator("/usr/lib/postgresql", error))
    if (fs::exists(version.path() / "bin/initdb") && version.path() > newest) newest = version.path();
  if (newest.empty()) give_up("PostgreSQL is not installed; deploy/packages --tests installs it");
  return newest / "bin";
}

// PostgreSQL refuses to run as root; null: this program does not.
const passwd* ordinary_user() {
  if (::geteuid() != 0) return nullptr;
  const passwd* user = ::getpwnam("postgres");
  if (!user) user = ::getpwnam("nobody");
  if (!user) give_up("no user to run PostgreSQL as");
  return user;
}

pid_t run(const std::vector<std::string>& words, const fs::path& output) {
  // All that allocates comes before the fork: the threads of a store may hold the allocator's locks.
  const passwd* user = ordinary_user();
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = ::fork();
  if (child != 0) return child;
  const int file = ::open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(file, 1);
  ::dup2(file, 2);
  ::setsid();
  const bool ready = !user || (::setgid(user->pw_gid) == 0 && ::setuid(user->pw_uid) == 0);
  if (ready && ::chdir("/") == 0) ::execv(arguments[0], arguments.data());
  ::_exit(127);
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

int status_of(pid_t child) {
  int status = 0;
  return ::waitpid(child, &status, 0) == child && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

PostgresServer& PostgresServer::get() {
  static PostgresServer server;
  return server;
}

PostgresServer::PostgresServer() : folder_(fs::temp_directory_path() / ("vacuform-pg-" + random_hex(4))) {
  fs::create_directories(folder_);
  if (const passwd* user = ordinary_user(); user && ::chown(folder_.c_str(), user->pw_uid, user->pw_gid) != 0)
    give_up("its folder cannot be given to " + std::string(user->pw_name));
  fs::permissions(folder_, fs::perms::owner_all | fs::perms::others_exec);
  const fs::path log = folder_.string() + "-initdb.log";
  const pid_t made = run({programs() / "initdb", "-D", folder_ / "data", "-U", "vacuform", "-A", "trust",
                          "-E", "UTF8", "--locale=C", "--no-sync", "--no-instructions"},
                         log);
  if (status_of(made) != 0) give_up("initdb failed: " + text_of(log));
  fs::remove(log);
  start();
}

void PostgresServer::start() {
  const fs::path log = folder_.string() + ".log";
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  do {
    if (std::chrono::steady_clock::now() > until) give_up("PostgreSQL did not start: " + text_of(log));
    // It ends at once while processes of a killed server are still there.
    if (process_ == 0 || ::waitpid(process_, nullptr, WNOHANG) != 0)
      process_ = run({programs() / "postgres", "-D", folder_ / "data", "-k", folder_, "-c",
                      "listen_addresses=", "-c", "max_connections=60"},
                     log);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  } while (answer("SELECT 1") != "1\n");
}

void PostgresServer::kill() {
  ::kill(process_, SIGSTOP);  // it starts none of its processes again
  const std::string id = std::to_string(process_);
  std::ifstream children("/proc/" + id + "/task/" + id + "/children");
  for (pid_t child = 0; children >> child;) ::kill(child, SIGKILL);
  ::kill(process_, SIGKILL);
  status_of(process_);
  process_ = 0;
}

std::string PostgresServer::answer(const std::string& sql) {
  const fs::path output = folder_.string() + "-psql.log";
  const pid_t child = run({programs() / "psql", "-h", folder_, "-U", "vacuform", "-d", "postgres", "-X", "-A",
                           "-t", "-q", "-c", sql},
                          output);
  status_of(child);
  const std::string text = text_of(output);
  fs::remove(output);
  return text;
}

std::string PostgresServer::url(const std::string& schema) {
  answer("CREATE SCHEMA IF NOT EXISTS \"" + schema + "\"");
  return "postgresql://vacuform@/postgres?host=" + folder_.string() + "&options=-csearch_path%3D" + schema;
}

PostgresServer::~PostgresServer() {
  if (process_ != 0) {
    ::kill(process_, SIGINT);  // ends all connections
    status_of(process_);
  }
  fs::remove_all(folder_);
  fs::remove(folder_.string() + ".log");
}

}  // namespace vacuform
