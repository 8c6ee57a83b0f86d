// The program itself: which configurations it accepts, which files it leaves, how it starts, stops and is killed.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <sysexits.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <thread>
#include <vector>

#include "api/base/secrets.hpp"
#include "tests/unit/server/eventually.hpp"

namespace vacuform {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class ServerProgram : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    folder_ = fs::temp_directory_path() / ("vacuform-program-" + random_hex(8));
    fs::create_directories(folder_);
  }
  void TearDown() override {
    if (process_ > 0) stop(SIGKILL);
    fs::remove_all(folder_);
  }

  bool has_nameless_file() const;
  fs::path data() const { return folder_ / "data"; }
  std::string said() const {
    std::stringstream text;
    text << std::ifstream(folder_ / "stderr").rdbuf();
    return text.str();
  }
  void start(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), VACUFORM_SERVER);
    std::vector<char*> words;
    for (auto& word : arguments) words.push_back(word.data());
    words.push_back(nullptr);
    const std::string log = folder_ / "stderr";
    process_ = ::fork();
    if (process_ == 0) {
      ::dup2(::open(log.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600), STDERR_FILENO);
      ::execv(words[0], words.data());
      ::_exit(126);
    }
  }
  // Uses a free port; returns when the server answers.
  void serve(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"--listen", "127.0.0.1:0", "--data",
                                       data(),     "--port-file", folder_ / "port"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    fs::remove(folder_ / "port");
    start(arguments);
    EXPECT_TRUE(eventually([&] { return fs::exists(folder_ / "port"); }));
    std::ifstream(folder_ / "port") >> port_;
    ASSERT_GT(port_, 0) << said();
  }
  // The exit code, or minus the signal that ended it.
  int wait() {
    int status = 0;
    if (!eventually([&] { return ::waitpid(process_, &status, WNOHANG) == process_; })) {
      ADD_FAILURE() << "the server does not end";
      ::kill(process_, SIGKILL);
      ::waitpid(process_, &status, 0);
    }
    process_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  int stop(int signal) {
    ::kill(process_, signal);
    return wait();
  }
  int connected() const {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port_));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return socket;
  }
  static std::string talk(int socket, const std::string& text) {
    EXPECT_EQ(::send(socket, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
    std::string answer;
    char piece[4096];
    for (ssize_t n; (n = ::recv(socket, piece, sizeof piece, 0)) > 0;)
      answer.append(piece, static_cast<std::size_t>(n));
    ::close(socket);
    return answer;
  }
  static std::string first_line(const fs::path& path) {
    std::string line;
    std::ifstream file(path);
    std::getline(file, line);
    return line;
  }
  static mode_t mode(const fs::path& path) {
    struct stat status {};
    EXPECT_EQ(::stat(path.c_str(), &status), 0) << path;
    return status.st_mode & 0777;
  }
  // True for an ended process, even if its status was not collected yet.
  static bool gone(pid_t process) {
    std::string line;
    std::ifstream file("/proc/" + std::to_string(process) + "/stat");
    std::getline(file, line);
    const auto end = line.rfind(") ");
    return end == std::string::npos || line[end + 2] == 'Z' || line[end + 2] == 'X';
  }
  bool soon(const std::function<bool()>& condition) { return eventually(condition); }
  int times_said(const std::string& words) {
    int n = 0;
    const std::string text = said();
    for (std::size_t at = 0; (at = text.find(words, at)) != std::string::npos; ++at) ++n;
    return n;
  }

  fs::path folder_;
  pid_t process_ = 0;
  int port_ = 0;
};

TEST_F(ServerProgram, ListensOnLoopbackOrNotAtAll) {
  for (const char* address :
       {"0.0.0.0:8080", "[::]:8080", "192.168.1.5:80", "example.org:80", "127.0.0.1.example.org:80"}) {
    start({"--listen", address, "--data", data()});
    EXPECT_EQ(wait(), 2) << address;
    EXPECT_NE(said().find("without a TLS front"), std::string::npos) << said();
    EXPECT_EQ(times_said("\n"), 1) << said();
  }
  for (const char* address : {"127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:http"}) {
    start({"--listen", address, "--data", data()});
    EXPECT_EQ(wait(), 2) << address;
    EXPECT_NE(said().find("not an address with a port"), std::string::npos) << said();
  }
  start({"--workers", "1", "--worker-program", folder_ / "none", "--data", data()});
  EXPECT_EQ(wait(), 2);
  EXPECT_NE(said().find("there is no worker program"), std::string::npos) << said();
  EXPECT_FALSE(fs::exists(data()));  // no data folder was created
}

TEST_F(ServerProgram, KeepsItsFilesToItselfAndStopsWhenAsked) {
  serve();
  EXPECT_EQ(mode(data()), 0700u);
  EXPECT_EQ(mode(data() / "worker-token"), 0600u);
  EXPECT_EQ(mode(data() / "jobs.sqlite"), 0600u);
  EXPECT_EQ(mode(data() / "admin-token"), 0600u);
  EXPECT_EQ(fs::file_size(data() / "worker-token"), 86u);
  EXPECT_EQ(stop(SIGTERM), 0);
  EXPECT_NE(said().find("\"event\":\"server-stopped\""), std::string::npos);
  std::string before, after;
  std::ifstream(data() / "worker-token") >> before;
  serve();
  std::ifstream(data() / "worker-token") >> after;
  EXPECT_EQ(before, after);
  EXPECT_EQ(stop(SIGINT), 0);
}

// The command works with and without a running server; a token is shown once and is stored nowhere.
TEST_F(ServerProgram, MakesListsAndRevokesTokens) {
  const auto command = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "token");
    words.insert(words.end(), {"--data", data()});
    start(words);
    return wait();
  };
  const fs::path out = folder_ / "token";
  const auto status = [&] {
    const std::string answer =
        talk(connected(),
             "GET /api/v1/jobs HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nAuthorization: Bearer " +
                 first_line(out) + "\r\n\r\n");
    return answer.substr(9, 3);
  };
  const std::vector<std::string> first{"create", "--owner", "local", "--scopes", "submit,read", "--out", out};
  for (const std::vector<std::string>& words : {first, {"list"}}) {  // a mistyped folder creates no store
    EXPECT_EQ(command(words), 2);
    EXPECT_NE(said().find("there is no job store in this folder"), std::string::npos) << said();
    EXPECT_FALSE(fs::exists(data()));
  }
  fs::create_directory(data());
  ASSERT_EQ(command(first), 0) << said();
  EXPECT_EQ(mode(out), 0600u);
  serve();
  const pid_t server = process_;
  EXPECT_EQ(status(), "200");
  ASSERT_EQ(command({"revoke", first_line(out).substr(4, 16)}), 0) << said();
  EXPECT_EQ(status(), "401");
  ASSERT_EQ(command({"create", "--owner", "local", "--scopes", "read", "--days", "1", "--out", out}), 0)
      << said();
  EXPECT_EQ(status(), "200");
  EXPECT_EQ(command({"list"}), 0) << said();
  EXPECT_EQ(command({"revoke", "0123456789abcdef"}), 2);
  EXPECT_NE(said().find("there is no such token"), std::string::npos) << said();
  EXPECT_EQ(command({"create", "--owner", "Jane Doe", "--scopes", "read"}), 2);
  EXPECT_NE(said().find("never the name of a person"), std::string::npos) << said();
  EXPECT_EQ(command({"create", "--owner", "a", "--scopes", "all"}), 2);
  process_ = server;
  EXPECT_EQ(stop(SIGTERM), 0);
}

// A backup contains the row of the administrator's token, but not its file.
TEST_F(ServerProgram, MakesAnotherAdminTokenWhereTheFileIsMissing) {
  serve();
  EXPECT_EQ(stop(SIGTERM), 0);
  const std::string before = first_line(data() / "admin-token");
  fs::remove(data() / "admin-token");
  fs::remove(data() / "worker-token");
  serve();
  const pid_t server = process_;
  const std::string after = first_line(data() / "admin-token");
  EXPECT_NE(after, before);
  EXPECT_NE(said().find("\"event\":\"admin-token-revoked\",\"token\":\"" + before.substr(4, 16) + "\""),
            std::string::npos)
      << said();
  const auto status = [&](const std::string& token) {
    return talk(connected(),
                "GET /api/v1/tokens HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nAuthorization: "
                "Bearer " +
                    token + "\r\n\r\n")
        .substr(9, 3);
  };
  EXPECT_EQ(status(before), "401");
  EXPECT_EQ(status(after), "200");
  start({"token", "list", "--data", data()});  // through the server
  EXPECT_EQ(wait(), 0) << said();
  process_ = server;
  EXPECT_EQ(stop(SIGTERM), 0);
  serve();
  EXPECT_EQ(first_line(data() / "admin-token"), after);
  EXPECT_EQ(stop(SIGTERM), 0);
}

TEST_F(ServerProgram, OneServerAPort) {
  serve();
  const pid_t first = process_;
  start({"--listen", "127.0.0.1:" + std::to_string(port_), "--data", folder_ / "other"});
  EXPECT_EQ(wait(), 2);
  EXPECT_NE(said().find("check whether another program listens there"), std::string::npos) << said();
  process_ = first;
  EXPECT_EQ(stop(SIGTERM), 0);
}

// Whether the server has a file open whose name is gone already.
bool ServerProgram::has_nameless_file() const {
  for (const auto& entry : fs::directory_iterator("/proc/" + std::to_string(process_) + "/fd")) {
    std::error_code closed;
    if (fs::read_symlink(entry, closed).string().starts_with((data() / "incoming").string())) return true;
  }
  return false;
}

TEST_F(ServerProgram, KilledInTheMiddleOfAnUploadItLeavesNoTrace) {
  serve();
  const std::string host = "127.0.0.1:" + std::to_string(port_);
  const std::string part =
      "--XX\r\nContent-Disposition: form-data; name=\"scan\"; filename=\"a.stl\"\r\n\r\n" +
      std::string(200'000, 's');
  const int socket = connected();
  const std::string text =
      "POST /api/v1/jobs HTTP/1.1\r\nHost: " + host + "\r\nAuthorization: Bearer " +
      first_line(data() / "admin-token") +
      "\r\nContent-Type: multipart/form-data; boundary=XX\r\nContent-Length: 10000000\r\n\r\n" + part;
  ASSERT_EQ(::send(socket, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
  ASSERT_TRUE(soon([&] { return has_nameless_file(); }));
  EXPECT_EQ(stop(SIGKILL), -SIGKILL);
  ::close(socket);
  serve();
  EXPECT_TRUE(fs::is_empty(data() / "incoming"));
  EXPECT_TRUE(fs::is_empty(data() / "blobs"));
  const std::string answer =
      talk(connected(), "GET /api/v1/jobs HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) +
                            "\r\nConnection: close\r\nAuthorization: Bearer " +
                            first_line(data() / "admin-token") + "\r\n\r\n");
  EXPECT_NE(answer.find("{\"jobs\":[],\"next\":null}"), std::string::npos) << answer;
  EXPECT_EQ(stop(SIGTERM), 0);
}

// After a flush that failed nobody knows what is on the disk: a server that went on would lose what it accepts.
TEST_F(ServerProgram, EndsWhenTheDiskDoesNotTakeWhatItHadAccepted) {
  const fs::path fails = folder_ / "fails";
  ::setenv("LD_PRELOAD", VACUFORM_FAILING_DISK, 1);
  ::setenv("VACUFORM_FAILING_DISK", fails.c_str(), 1);
  const char* const asan =
      ::getenv("ASAN_OPTIONS");  // which wants to be the first library, with that sanitizer
  ::setenv("ASAN_OPTIONS", (std::string(asan ? asan : "") + ":verify_asan_link_order=0").c_str(), 1);
  serve();
  ::unsetenv("LD_PRELOAD");
  const auto token = first_line(data() / "admin-token");
  const auto make_token = [&](const std::string& owner) {
    const std::string body = R"({"owner": ")" + owner + R"(", "scopes": ["read"]})";
    return talk(connected(), "POST /api/v1/tokens HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) +
                                 "\r\nConnection: close\r\nAuthorization: Bearer " + token +
                                 "\r\nContent-Type: application/json\r\nContent-Length: " +
                                 std::to_string(body.size()) + "\r\n\r\n" + body);
  };
  EXPECT_EQ(make_token("before").substr(9, 3), "201");
  std::ofstream(fails) << "now";
  EXPECT_EQ(make_token("lost"), "");
  EXPECT_EQ(wait(), EX_IOERR) << said();
  EXPECT_NE(said().find("\"event\":\"disk-failed\""), std::string::npos) << said();
  fs::remove(fails);
  serve();
  EXPECT_EQ(make_token("after").substr(9, 3), "201");
  EXPECT_EQ(stop(SIGTERM), 0);
}

TEST_F(ServerProgram, StartsItsWorkersAgainAndTakesThemAlong) {
  const fs::path worker = folder_ / "worker";
  std::ofstream(worker)
      << "#!/bin/sh\necho \"$@\" > \"$0.words.$$\"\necho $$ >> \"$0.pids\"\nexec sleep 600\n";
  fs::permissions(worker, fs::perms::owner_all);
  const auto pids = [&] {
    std::vector<pid_t> found;
    std::ifstream file(worker.string() + ".pids");
    for (pid_t pid; file >> pid;) found.push_back(pid);
    return found;
  };
  serve({"--workers", "2", "--worker-program", worker});
  ASSERT_TRUE(soon([&] { return pids().size() == 2; }));
  std::string words;
  std::getline(std::ifstream(worker.string() + ".words." + std::to_string(pids()[0])), words);
  EXPECT_NE(words.find("--server http://127.0.0.1:" + std::to_string(port_) + " --token-file " +
                       (data() / "worker-token").string() + " --name local-"),
            std::string::npos)
      << words;
  ::kill(pids()[0], SIGKILL);
  ASSERT_TRUE(soon([&] { return pids().size() == 3; })) << said();
  EXPECT_EQ(times_said("\"worker-ended\""), 1);
  EXPECT_EQ(stop(SIGKILL), -SIGKILL);
  EXPECT_TRUE(soon([&] { return gone(pids()[1]) && gone(pids()[2]); }));  // no worker outlives its server
}

}  // namespace
}  // namespace vacuform
