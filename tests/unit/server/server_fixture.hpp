// A real server with its store on a free port, and a client that can send what no HTTP library would.
#pragma once

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <set>
#include <string>

#include "api/base/secrets.hpp"
#include "api/redaction/redaction.hpp"
#include "server/access/tokens.hpp"
#include "server/http/server.hpp"
#include "server/routes/routes.hpp"
#include "server/routes/status_routes.hpp"
#include "tests/unit/server/eventually.hpp"

namespace vacuform {

struct Answer {
  int status = 0;  // 0: the connection ended without an answer
  std::string head, body;
  std::string header(const std::string& name) const {
    const auto at = head.find("\r\n" + name + ": ");
    if (at == std::string::npos) return {};
    const auto begin = at + name.size() + 4;
    return head.substr(begin, head.find("\r\n", begin) - begin);
  }
};

// What is stored of "<svg/>".
inline std::string stored_svg() {
  std::vector<std::uint8_t> bytes{'<', 's', 'v', 'g', '/', '>'};
  EXPECT_TRUE(redact(bytes, "p.svg"));
  return {bytes.begin(), bytes.end()};
}

class ServerTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(start_secrets());
    data_ = std::filesystem::temp_directory_path() / ("vacuform-server-" + random_hex(8));
    store_ = std::move(*open_store(data_, store_options()));
    access_ = std::make_unique<Access>(*store_, *store_);
    uploads_ = std::move(*Uploads::open(*store_, data_ / "uploads"));
    service_ = std::make_unique<Service>(Service{*store_, *access_, workers_, *uploads_, 30, 1});
    user_ = token("station-1", {Scope::submit, Scope::read});
    worker_ = token("workers", {Scope::work});
    admin_ = token("admin", {Scope::admin});
    http::ServerOptions options;
    options.refuse = refuse;
    options.observe = [this](const http::Answered& answered) { metrics_.answered(answered); };
    options.limits = limits();
    http::Router router = all_routes(*service_);
    router.add("GET", "/fault",
               [](http::Request&) -> Result<http::Response> { throw std::runtime_error("secret text"); });
    auto server = http::Server::start(std::move(options), std::move(router));
    ASSERT_TRUE(server) << server.error().text();
    server_ = std::move(*server);
    status_ = std::make_unique<Status>(
        Status{*store_, metrics_, data_, [this] { return server_->connections(); }, 64});
    http::ServerOptions status_options;
    status_options.refuse = refuse;
    auto status = http::Server::start(std::move(status_options), status_routes(*status_));
    ASSERT_TRUE(status) << status.error().text();
    status_server_ = std::move(*status);
  }
  void TearDown() override {
    status_server_.reset();
    server_.reset();
    store_.reset();
    std::filesystem::remove_all(data_);
  }

  virtual StoreOptions store_options() const { return {}; }
  virtual http::Limits limits() const { return {}; }

  std::string token(const std::string& owner, Scopes scopes) const {
    return make_token(*store_, {owner, scopes, std::nullopt})->text;
  }
  static std::string bearer(const std::string& token) { return "Authorization: Bearer " + token + "\r\n"; }
  static constexpr const char* json_type = "Content-Type: application/json\r\n";
  static constexpr const char* anonymous = "Authorization: none\r\n";

  int connected() const { return connected_to(*server_); }
  static int connected_to(const http::Server& server) {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(server.port()));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{90, 0};  // a test that hangs fails
    EXPECT_EQ(::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience), 0);
    EXPECT_EQ(::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return socket;
  }
  static bool send_all(int socket, std::string_view text) {
    while (!text.empty()) {
      const ssize_t n = ::send(socket, text.data(), text.size(), MSG_NOSIGNAL);
      if (n <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }
  // Everything until the server closes.
  static std::string receive_all(int socket) {
    std::string text;
    char piece[65536];
    for (ssize_t n; (n = ::recv(socket, piece, sizeof piece, 0)) > 0;)
      text.append(piece, static_cast<std::size_t>(n));
    ::close(socket);
    return text;
  }
  static Answer parsed(std::string text) {
    if (text.starts_with("HTTP/1.1 100")) text.erase(0, text.find("\r\n\r\n") + 4);
    Answer answer;
    const auto end = text.find("\r\n\r\n");
    if (end == std::string::npos) return answer;
    answer.status = std::stoi(text.substr(9, 3));
    answer.head = text.substr(0, end) + "\r\n";
    answer.body = text.substr(end + 4);
    return answer;
  }
  // One answer, by its Content-Length; without one, all until the server closes.
  static std::string receive_one(int socket, bool head_only = false) {
    std::string text;
    char piece[65536];
    for (ssize_t n; (n = ::recv(socket, piece, sizeof piece, 0)) > 0;) {
      text.append(piece, static_cast<std::size_t>(n));
      if (text.starts_with("HTTP/1.1 100") && text.find("\r\n\r\n") != std::string::npos)
        text.erase(0, text.find("\r\n\r\n") + 4);
      const Answer answer = parsed(text);
      if (answer.status == 0) continue;
      const std::string length = answer.header("Content-Length");
      const bool bare = head_only || answer.status == 204 || answer.status == 304;
      if (bare || (!length.empty() && answer.body.size() >= std::stoull(length))) break;
    }
    return text;
  }
  Answer raw(std::string_view text) const {
    const int socket = connected();
    send_all(socket, text);
    const Answer answer = parsed(receive_one(socket, text.starts_with("HEAD ")));
    ::close(socket);
    return answer;
  }
  std::string host() const { return "127.0.0.1:" + std::to_string(server_->port()); }
  // `headers` as lines that end with \r\n; the user's token goes with them, unless they say who asks, and of a body
  // that it is JSON, unless they say what it is.
  Answer ask(const std::string& method, const std::string& path, const std::string& headers = "",
             const std::string& body = "") const {
    const bool said = ("\n" + headers).find("\nAuthorization:") != std::string::npos ||
                      ("\n" + headers).find("\nCookie:") != std::string::npos;
    const bool typed = headers.find("Content-Type:") != std::string::npos;
    return raw(method + " " + path + " HTTP/1.1\r\nHost: " + host() + "\r\n" + headers +
               (said ? "" : bearer(user_)) + (body.empty() || typed ? "" : json_type) +
               (body.empty() ? "" : "Content-Length: " + std::to_string(body.size()) + "\r\n") + "\r\n" +
               body);
  }

  // Of the listener for health and metrics.
  Answer status(const std::string& path) const {
    const int socket = connected_to(*status_server_);
    send_all(socket, "GET " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    return parsed(receive_all(socket));
  }

  static std::string part(const std::string& name, const std::string& file_name, const std::string& bytes) {
    return "--XX\r\nContent-Disposition: form-data; name=\"" + name + "\"" +
           (file_name.empty() ? "" : "; filename=\"" + file_name + "\"") + "\r\n\r\n" + bytes + "\r\n";
  }
  static constexpr const char* form_type = "Content-Type: multipart/form-data; boundary=XX\r\n";
  Answer submit(const std::string& more = "", const std::string& path = "/api/v1/jobs") const {
    return ask("POST", path, form_type,
               part("scan", "Head.STL", "solid") + part("pattern", "p.svg", "<svg/>") + more + "--XX--\r\n");
  }
  // The artifacts that the leased job must have, but for those that are there.
  void put_artifacts(const LeaseKey& key, const std::set<std::string>& there = {}) const {
    const auto job = store_->leased(key);
    ASSERT_TRUE(job);
    for (const ArtifactKind& kind : artifact_kinds) {
      if (!due(job->kind, kind) || there.count(std::string(kind.name)) != 0) continue;
      auto file = store_->upload(Use::artifact);
      ASSERT_TRUE(file && file->write("an artifact"));
      ASSERT_TRUE(store_->put_artifact(key, std::string(kind.name), std::move(*file)));
    }
  }
  void finish(const LeaseKey& key, const std::set<std::string>& there = {}) const {
    put_artifacts(key, there);
    ASSERT_TRUE(store_->complete(key));
  }
  std::string worker_headers(const std::string& lease = "") const {
    return bearer(worker_) + (lease.empty() ? "" : "Vacuform-Lease: " + lease + "\r\n");
  }

  std::filesystem::path data_;
  std::string user_, worker_, admin_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<Access> access_;
  Workers workers_;
  std::unique_ptr<Uploads> uploads_;
  std::unique_ptr<Service> service_;
  std::unique_ptr<http::Server> server_;
  Metrics metrics_;
  std::unique_ptr<Status> status_;
  std::unique_ptr<http::Server> status_server_;
};

}  // namespace vacuform
