// httplib::Server sees a request line and a Content-Length that are written here, never the client's own: a HEAD or a
// POST. head.hpp reads the head, router.hpp finds the route, and behind the announced body the stream ends. So what the
// library does with odd heads, ranges, encodings and the bytes behind a body does not matter. What it costs is said in
// docs/develop/decisions/0011-cpp-httplib.md.
#include "server/http/server.hpp"

#include <fcntl.h>
#include <httplib.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "api/base/log.hpp"
#include "api/problem.hpp"
#include "server/http/admission.hpp"
#include "server/http/connection.hpp"
#include "server/http/threads.hpp"
#include "server/messages/digest.hpp"
#include "server/messages/origin.hpp"
#include "server/messages/request_id.hpp"
#include "server/messages/source_reader.hpp"

namespace vacuform::http {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

namespace {

constexpr int backlog = 512;                 // the library's own is 5
constexpr int send_buffer = 128 << 10;       // of the kernel, per connection; it doubles the value
constexpr std::size_t most_held = 64 << 20;  // bytes of all answers in memory that wait for clients
constexpr std::size_t piece_bytes = 64 << 10;

Refusal refusal_of(const Error& error) { return {meaning(error.code).http_status, error}; }
Error internal_fault() { return {Code::internal, "the server has an internal fault", {}, "try again"}; }

// One request and its answer, as the stream that the library reads and writes.
class Exchange final : public httplib::Stream {
 public:
  Exchange(int socket, const Limits& limits, const std::atomic<bool>& stopping)
      : connection(socket, limits, stopping) {}

  void begin(tl::expected<Head, Refusal> head, std::string_view front_host) {
    started = steady_clock::now();
    if (!head) {
      refusal = std::move(head.error());
      request.id = request_id({});
      feed_ = "POST / HTTP/1.1\r\nContent-Length: 0\r\n\r\n";
      return;
    }
    request = request_of(std::move(*head));
    request.by_front = through_front(request, front_host);
    request.beyond_loopback = !is_loopback_socket(connection.socket());
    if (request.head_only)
      feed_ = "HEAD / HTTP/1.1\r\n\r\n";
    else
      feed_ = "POST / HTTP/1.1\r\nContent-Length: " + std::to_string(request.content_length) + "\r\n\r\n";
  }

  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* into, std::size_t size) override {
    if (fed_ == feed_.size()) return connection.read(into, size);
    const std::size_t n = feed_.copy(into, size, fed_);
    fed_ += n;
    return static_cast<ssize_t>(n);
  }
  ssize_t write(const char* bytes, std::size_t size) override {
    return connection.write({bytes, size}) ? static_cast<ssize_t>(size) : -1;
  }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return 0; }  // only compared with FD_SETSIZE

  Connection connection;
  Request request;
  std::optional<Refusal> refusal;  // of the head
  Router::Match match;
  steady_clock::time_point started;
  std::vector<Slot> slots;  // until the answer is sent
  bool has_ranges = false;  // the answer says what ranges it has
  std::size_t held = 0;     // bytes of the answer in memory

 private:
  std::string feed_;
  std::size_t fed_ = 0;
};

thread_local Exchange* present = nullptr;

// A body as the library receives it, in larger pieces.
class Received final : public Body {
 public:
  Received(const Connection& connection, const httplib::ContentReader* reader)
      : connection_(connection), reader_(reader) {}

  Result<void> read(const Taker& take) override {
    if (!reader_) return {};
    Result<void> taken;
    std::string pending;
    const auto pass_on = [&] {
      taken = take(pending);
      pending.clear();
      return taken.has_value();
    };
    (*reader_)([&](const char* bytes, std::size_t size) {
      pending.append(bytes, size);
      return pending.size() < piece_bytes || pass_on();
    });
    if (taken && !pending.empty()) pass_on();
    if (taken && connection_.trouble()) return tl::make_unexpected(connection_.trouble()->error);
    return taken;
  }

 private:
  const Connection& connection_;
  const httplib::ContentReader* const reader_;
};

void set_options(socket_t listener) {
  const int yes = 1;
  ::fcntl(listener, F_SETFD, FD_CLOEXEC);
  ::setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  // The connections inherit both. Without the limit the kernel would buffer megabytes for a client that does not read,
  // and count them as read.
  ::setsockopt(listener, SOL_SOCKET, SO_SNDBUF, &send_buffer, sizeof send_buffer);
  ::setsockopt(listener, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
}

}  // namespace

class Server::Adapter final : private httplib::Server {
 public:
  Adapter(ServerOptions options, Router router) : options_(std::move(options)), router_(std::move(router)) {
    for (const Route& route : router_.routes()) queues_.try_emplace(&route, options_.turns);
    Get("/", [this](const httplib::Request&, httplib::Response& out) { serve(*present, nullptr, out); });
    Post("/", [this](const httplib::Request&, httplib::Response& out, const httplib::ContentReader& reader) {
      serve(*present, &reader, out);
    });
    set_post_routing_handler([](const httplib::Request&, httplib::Response& out) {
      out.headers.erase("Keep-Alive");
      if (!present->has_ranges) out.headers.erase("Accept-Ranges");  // which the library adds for HEAD
      if (out.status == 204 || out.status == 304) out.headers.erase("Content-Length");
    });
    set_socket_options(set_options);
    new_task_queue = [this] {
      return new Threads(options_.connections, [this](std::size_t waiting) { make_room(waiting); });
    };
  }
  ~Adapter() override { end(); }

  Result<void> begin() {
    const bool any = options_.port == 0;
    port_ = any                                          ? bind_to_any_port(options_.host)
            : bind_to_port(options_.host, options_.port) ? options_.port
                                                         : -1;
    if (port_ <= 0 || ::listen(svr_sock_, backlog) != 0)
      return fail(Code::bad_usage, "cannot listen on " + options_.host + ":" + std::to_string(options_.port),
                  {}, "check whether another program listens there, or give another port (0: any free one)");
    acceptor_ = std::thread([this] { listen_after_bind(); });
    return {};
  }

  int port() const { return port_; }
  int connections() const {
    const std::lock_guard hold(open_mutex_);
    return static_cast<int>(open_.size());
  }
  int streams() const { return streams_.taken(); }

 private:
  void end() {
    ending_ = true;
    if (!acceptor_.joinable()) return;
    // accept() fails then. stop() would break off the answers that are being sent.
    ::shutdown(svr_sock_, SHUT_RDWR);
    for (int i = 0; i < 500 && connections() > 0; ++i) {
      evict_idle();
      std::this_thread::sleep_for(10ms);
    }
    stopping_ = true;
    acceptor_.join();
  }

  // Of each connection, on a thread of its own.
  bool process_and_close_socket(socket_t socket) override {
    ::fcntl(socket, F_SETFD, FD_CLOEXEC);
    Exchange exchange(socket, options_.limits, stopping_);
    if (ending_) return false;
    const Slot open = opened(exchange.connection);
    try {
      auto head = exchange.connection.read_head();
      if (!head) return false;
      exchange.begin(std::move(*head), options_.front_host);
      exchange.connection.enter(Connection::Phase::work);
      present = &exchange;
      process(exchange);
      exchange.slots.clear();
      exchange.connection.finish();
    } catch (const std::exception& fault) {
      log_event("connection-failed", {{"fault", fault.what()}});
    }
    held_ -= exchange.held;
    return true;
  }

  // Later versions of the library want the addresses, too, which nobody here believes.
  template <typename Stream>
  void process(Stream& stream) {
    bool closed = false;
    if constexpr (requires { this->process_request(stream, true, closed, nullptr); })
      process_request(stream, true, closed, nullptr);
    else
      process_request(stream, {}, 0, {}, 0, true, closed, nullptr);
  }

  void serve(Exchange& exchange, const httplib::ContentReader* reader, httplib::Response& out) {
    Request& request = exchange.request;
    const LoggedRequest logged(request.id);
    Answered answered;
    Response response;
    try {
      response = respond(exchange, reader);
    } catch (const std::exception& fault) {
      answered.fault = fault.what();
      response = options_.refuse(request, refusal_of(internal_fault()));
    }
    if (response.refusal) {
      const std::vector<Header> more = std::move(response.headers);
      response = with_headers(options_.refuse(request, *response.refusal), more);
    }
    if (const auto& trouble = exchange.connection.trouble(); trouble && response.status >= 400)
      response = with_headers(options_.refuse(request, *trouble), response.headers);
    if (exchange.match.route) answered.route = exchange.match.route->pattern;
    answered.method = request.method;
    answered.status = response.status;
    answered.seconds = std::chrono::duration<double>(steady_clock::now() - exchange.started).count();
    if (options_.observe) options_.observe(answered);
    give(exchange, std::move(response), out);
  }

  Response respond(Exchange& exchange, const httplib::ContentReader* reader) {
    Request& request = exchange.request;
    const auto refused = [&](const Refusal& refusal) { return options_.refuse(request, refusal); };
    if (exchange.refusal) return refused(*exchange.refusal);
    if (const auto refusal = check_origin(request, options_.front_host)) return refused(*refusal);
    exchange.match = router_.match(request.method, request.path);
    if (const auto refusal = unserved(exchange.match, request)) {
      Response response = refused(*refusal);
      if (refusal->status == 405) response.set("Allow", exchange.match.allowed);
      return response;
    }
    const Route& route = *exchange.match.route;
    const auto admitted = route.admission(request);
    if (!admitted) return refused(refusal_of(admitted.error()));
    const std::string& client = admitted->client;
    const auto take = [&](Slots& slots) -> std::optional<Refusal> {
      auto slot = slots.take(client);
      if (!slot) return slot.error();
      exchange.slots.push_back(std::move(*slot));
      return std::nullopt;
    };
    if (!client.empty())
      if (const auto refusal = take(requests_)) return refused(*refusal);

    Received received(exchange.connection, reader);
    std::optional<HeldBody> held;
    Slot turn;
    if (request.content_length > small_body) {
      if (const auto refusal = take(bodies_)) return refused(*refusal);
      exchange.connection.enter(Connection::Phase::body);
      request.body = &received;
    } else {
      exchange.connection.enter(Connection::Phase::body);
      request.body = &held.emplace(received);
      exchange.connection.enter(Connection::Phase::work);
      turn = queues_.at(&route).take(client, options_.limits.wait);
      if (!turn) return refused({503, {Code::busy, "too many requests of this kind wait", {}, "try again"}});
    }
    request.captures = std::move(exchange.match.captures);
    auto result = handled(admitted->handler, request);
    turn.reset();
    exchange.connection.enter(Connection::Phase::work);
    if (!result) return refused(refusal_of(result.error()));
    if (result->waiter || (result->stream && !request.head_only))
      if (const auto refusal = take(streams_)) return refused(*refusal);
    if (!result->waiter) return std::move(*result);
    auto awaited = result->waiter([&] { return going(exchange); });
    return awaited ? std::move(*awaited) : refused(refusal_of(awaited.error()));
  }

  static Result<Response> handled(const http::Handler& handler, Request& request) {
    VACUFORM_TRY(digest, stated_digest(request, "Content-Digest"));
    const auto checked = digest.empty() ? nullptr : checked_body(*request.body, digest);
    if (checked) request.body = checked.get();
    auto result = handler(request);
    request.body = nullptr;
    return result;
  }

  bool going(const Exchange& exchange) const { return !ending_ && !exchange.connection.gone(); }

  // Hands the answer to the library, which sends it.
  void give(Exchange& exchange, Response response, httplib::Response& out) {
    out.status = response.status;
    // A digest is about what is sent, and that is nothing after HEAD.
    for (const Header& header : response.headers)
      if (!exchange.request.head_only || header.name != "Content-Digest")
        out.set_header(header.name, header.value);
    out.set_header("X-Request-Id", exchange.request.id);
    exchange.has_ranges = out.has_header("Accept-Ranges");
    if (response.status == 204 || response.status == 304) return;
    if (response.stream) {
      out.set_content_provider(response.media_type, [this, &exchange, next = std::move(response.stream)](
                                                        std::size_t, httplib::DataSink& sink) {
        return pass_on(exchange, next, sink);
      });
      return;
    }
    exchange.connection.enter(Connection::Phase::answer);
    if (response.file && response.file->bytes > 0) {
      const auto bytes = static_cast<std::size_t>(response.file->bytes);
      out.set_content_provider(bytes, response.media_type,
                               [reader = std::make_shared<SourceReader>(std::move(*response.file))](
                                   std::size_t, std::size_t, httplib::DataSink& sink) {
                                 const auto piece = reader->next(piece_bytes);
                                 return !piece.empty() && sink.write(piece.data(), piece.size());
                               });
      return;
    }
    if (!response.media_type.empty()) out.set_header("Content-Type", response.media_type);
    out.body = std::move(response.text);
    exchange.held = out.body.size();
    if ((held_ += exchange.held) > most_held) make_room(1);
  }

  // The next piece of a stream. It has no length, so the end of the connection marks its end.
  bool pass_on(const Exchange& exchange, const Producer& next, httplib::DataSink& sink) const {
    try {
      if (!going(exchange)) return false;
      const std::optional<std::string> bytes = next();
      if (!bytes) sink.done();
      return !bytes || bytes->empty() || sink.write(bytes->data(), bytes->size());
    } catch (const std::exception& fault) {
      log_event("stream-failed", {{"fault", fault.what()}});
      return false;
    }
  }

  // Counts the connection, and lets it make room, until the result goes.
  Slot opened(Connection& connection) {
    const std::lock_guard hold(open_mutex_);
    open_.insert(&connection);
    return Slot(&connection, [this](Connection* closed) {
      const std::lock_guard hold_again(open_mutex_);
      open_.erase(closed);
    });
  }

  void evict_idle() {
    const std::lock_guard hold(open_mutex_);
    for (Connection* connection : open_)
      if (connection->idle()) connection->evict();
  }

  // Ends so many connections, or a twentieth of all, so that the search is rare: first those whose answer is sent, then
  // those that have been sending a head for long, then those that send a body or take an answer slowest.
  void make_room(std::size_t wanted) {
    std::vector<std::pair<Connection::Rank, Connection*>> candidates;
    const auto now = steady_clock::now();
    const std::lock_guard hold(open_mutex_);
    for (Connection* connection : open_)
      if (const auto rank = connection->rank(now)) candidates.emplace_back(*rank, connection);
    const auto enough =
        std::min(candidates.size(), std::max(wanted, static_cast<std::size_t>(options_.connections) / 20));
    std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(enough),
                      candidates.end());
    for (std::size_t i = 0; i < enough; ++i) candidates[i].second->evict();
  }

  const ServerOptions options_;
  const Router router_;
  std::atomic<bool> ending_ = false;    // no new requests, and streams end
  std::atomic<bool> stopping_ = false;  // every wait ends
  std::atomic<std::size_t> held_ = 0;   // bytes of answers that wait for their clients
  Slots requests_{"requests", options_.connections, options_.requests_of_one};
  Slots bodies_{"large bodies", options_.bodies, options_.bodies_of_one};
  Slots streams_{"clients that follow jobs", options_.streams, options_.streams_of_one};
  std::map<const Route*, FairQueue> queues_;
  mutable std::mutex open_mutex_;
  std::set<Connection*> open_;
  std::thread acceptor_;
  int port_ = 0;
};

Server::Server(std::unique_ptr<Adapter> adapter) : adapter_(std::move(adapter)) {}
Server::~Server() = default;
int Server::port() const { return adapter_->port(); }
int Server::connections() const { return adapter_->connections(); }
int Server::streams() const { return adapter_->streams(); }

Result<std::unique_ptr<Server>> Server::start(ServerOptions options, Router router) {
  auto adapter = std::make_unique<Adapter>(std::move(options), std::move(router));
  VACUFORM_CHECK(adapter->begin());
  return std::unique_ptr<Server>(new Server(std::move(adapter)));
}

}  // namespace vacuform::http
