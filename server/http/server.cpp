// All threads share one epoll instance. A thread takes one event, does the work of that connection that needs no
// waiting, and arms it again (EPOLLONESHOT). So a client that is slow to send or to read costs memory but no thread.
// Only work that a route must wait for occupies a thread, and each kind has a limit: large bodies (upload_room.hpp),
// streams and waiters (places.hpp), and the requests of each route, which gets a share of the threads and queues the
// rest. Another thread enforces the time limits.
//
// No HTTP library is used: Debian's cpp-httplib uses one thread per connection and reads the rest of a refused body as
// the next request.
#include "server/http/server.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "api/base/log.hpp"
#include "api/base/text.hpp"
#include "api/problem.hpp"
#include "server/http/connection.hpp"
#include "server/http/digest.hpp"
#include "server/http/origin.hpp"
#include "server/http/outgoing.hpp"
#include "server/http/places.hpp"
#include "server/http/request_id.hpp"
#include "server/http/response_head.hpp"

namespace vacuform::http {

using namespace std::chrono_literals;
using std::chrono::steady_clock;
using Instant = steady_clock::time_point;

namespace {

constexpr std::uint64_t listener_id = 0, wake_id = 1,
                        next_id = 2;         // of events; connections are numbered from there
constexpr int send_buffer = 128 << 10;       // of the kernel, per connection; it doubles the value
constexpr std::size_t most_held = 64 << 20;  // bytes of all answers in memory that wait for clients
constexpr auto linger_time = 2s;
constexpr auto tick = 50ms;

// One client, passed between the threads. Everything except the id is used under `turn`.
struct Client {
  enum class State { head, body, line, answer, linger };  // what an inactive client waits for

  Client(std::uint64_t number, int socket, const ServerOptions& options, UploadRoom& room,
         const std::atomic<bool>& stopping)
      : id(number), connection(socket, options.limits, room, stopping) {}

  const std::uint64_t id;
  std::mutex turn;
  Connection connection;
  bool closed = false;
  State state = State::head;
  Instant since = steady_clock::now();  // the state's beginning
  Instant deadline;
  Request request;
  Router::Match match;
  Instant request_begun;
  bool head_read = false;  // the current request has a valid head
  bool keep = false;       // the connection serves another request after this one
  bool used = false;       // it has served one
  bool admitted = false;   // it counts among the active requests of its route
  Outgoing out;
  std::size_t held = 0;            // bytes of `out` that are counted as waiting
  std::uint64_t window_bytes = 0;  // that the client had taken when the present window began

  bool idle() const { return state == State::head && !connection.started(); }
};
using Clients = std::vector<std::shared_ptr<Client>>;

}  // namespace

class Server::Loop {
 public:
  Loop(ServerOptions options, Router router) : options_(std::move(options)), router_(std::move(router)) {}

  Result<void> begin() {
    VACUFORM_CHECK(listen());
    epoll_ = ::epoll_create1(EPOLL_CLOEXEC);
    wake_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    next_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK | EFD_SEMAPHORE);
    if (epoll_ < 0 || wake_ < 0 || next_ < 0) return fail(Code::internal, "this machine provides no epoll");
    arm(listener_, listener_id, EPOLLIN | EPOLLONESHOT, EPOLL_CTL_ADD);
    arm(wake_, wake_id, EPOLLIN, EPOLL_CTL_ADD);
    arm(next_, next_id, EPOLLIN, EPOLL_CTL_ADD);
    for (int i = 0; i < options_.threads + options_.uploads + options_.streams; ++i)
      threads_.emplace_back([this] { work(); });
    threads_.emplace_back([this] { watch(); });
    return {};
  }

  void end() {
    if (!threads_.empty()) {
      ending_ = true;
      ::shutdown(listener_, SHUT_RDWR);
      for (int i = 0; i < 500 && connections() > 0; ++i) std::this_thread::sleep_for(10ms);
      stopping_ = true;
      ::eventfd_write(wake_, 1);  // no thread reads it, so all threads see it
      for (std::thread& thread : threads_) thread.join();
      threads_.clear();
      clients_.clear();
    }
    for (const int file : {listener_, epoll_, wake_, next_})
      if (file >= 0) ::close(file);
  }

  int port() const { return port_; }
  int connections() const { return open_; }
  int streams() const { return places_.taken(); }

 private:
  Result<void> listen() {
    const auto refuse = [&] {
      return fail(Code::bad_usage, "cannot listen on " + options_.host + ":" + std::to_string(options_.port),
                  {}, "check whether another program listens there, or give another port (0: any free one)");
    };
    addrinfo wanted{};
    wanted.ai_family = AF_UNSPEC;
    wanted.ai_socktype = SOCK_STREAM;
    wanted.ai_flags = AI_PASSIVE;
    addrinfo* found = nullptr;
    if (::getaddrinfo(options_.host.c_str(), std::to_string(options_.port).c_str(), &wanted, &found) != 0)
      return refuse();
    const std::unique_ptr<addrinfo, void (*)(addrinfo*)> addresses(found, ::freeaddrinfo);
    for (const addrinfo* address = found; address && listener_ < 0; address = address->ai_next) {
      listener_ = ::socket(address->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
      if (listener_ < 0) continue;
      const int yes = 1;
      ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
      // The connections inherit both. Without the limit the kernel would buffer megabytes for a client that does not
      // read, and count them as read.
      ::setsockopt(listener_, SOL_SOCKET, SO_SNDBUF, &send_buffer, sizeof send_buffer);
      ::setsockopt(listener_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
      if (::bind(listener_, address->ai_addr, address->ai_addrlen) == 0 && ::listen(listener_, 512) == 0)
        break;
      ::close(std::exchange(listener_, -1));
    }
    sockaddr_storage bound{};
    socklen_t size = sizeof bound;
    if (listener_ < 0 || ::getsockname(listener_, reinterpret_cast<sockaddr*>(&bound), &size) != 0)
      return refuse();
    port_ = ntohs(bound.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(bound).sin6_port
                                              : reinterpret_cast<const sockaddr_in&>(bound).sin_port);
    return {};
  }

  bool arm(int file, std::uint64_t id, std::uint32_t events, int how) const {
    epoll_event event{};
    event.events = events;
    event.data.u64 = id;
    return ::epoll_ctl(epoll_, how, file, &event) == 0;
  }

  void work() {
    while (!stopping_) {
      epoll_event event{};  // one at a time: a blocked thread must not hold others' events
      if (::epoll_wait(epoll_, &event, 1, -1) <= 0) continue;
      if (event.data.u64 == wake_id) return;
      if (event.data.u64 == next_id) {
        work_on_next();
        continue;
      }
      if (event.data.u64 == listener_id) {
        if (!ending_) accept_some();
        continue;
      }
      if (const std::shared_ptr<Client> client = find(event.data.u64)) {
        const std::lock_guard hold(client->turn);
        if (!client->closed) turn(*client);
      }
    }
  }

  std::shared_ptr<Client> find(std::uint64_t id) {
    const std::lock_guard hold(clients_mutex_);
    const auto found = clients_.find(id);
    return found == clients_.end() ? nullptr : found->second;
  }

  Clients all_clients() {
    Clients all;
    const std::lock_guard hold(clients_mutex_);
    all.reserve(clients_.size());
    for (const auto& [id, client] : clients_) all.push_back(client);
    return all;
  }

  void accept_some() {
    for (int i = 0; i < 64; ++i) {
      const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
      const int why = errno;
      if (socket < 0 && (why == EMFILE || why == ENFILE || why == ENOMEM || why == ENOBUFS)) {
        if (!make_room()) std::this_thread::sleep_for(tick);
        break;
      }
      if (socket < 0 && (why == EINTR || why == ECONNABORTED)) continue;
      if (socket < 0) break;
      if (open_ >= options_.connections && !make_room()) {
        ::close(socket);
        continue;
      }
      std::uint64_t id = 0;
      std::shared_ptr<Client> client;
      {
        const std::lock_guard hold(clients_mutex_);
        id = ++last_id_;
        client = std::make_shared<Client>(id, socket, options_, room_, stopping_);
        client->deadline = client->since + options_.limits.head_time;
        clients_.emplace(id, client);
        ++open_;
      }
      const std::lock_guard hold(client->turn);
      if (!arm(socket, id, EPOLLIN | EPOLLRDHUP | EPOLLONESHOT, EPOLL_CTL_ADD)) drop(*client);
    }
    arm(listener_, listener_id, EPOLLIN | EPOLLONESHOT, EPOLL_CTL_MOD);
  }

  // The functions from here on need the client's turn.

  void drop(Client& client) {
    if (std::exchange(client.closed, true)) return;
    leave_line(client);
    release(client);
    client.connection.close();
    --open_;
    const std::lock_guard hold(clients_mutex_);
    clients_.erase(client.id);  // the caller holds the client
  }

  void release(Client& client) {
    held_ -= std::exchange(client.held, 0);
    client.out = Outgoing();
  }

  void rest(Client& client, std::uint32_t events) {
    if (!arm(client.connection.socket(), client.id, events | EPOLLONESHOT, EPOLL_CTL_MOD)) drop(client);
  }

  void enter(Client& client, Client::State state, std::chrono::milliseconds time) {
    client.state = state;
    client.since = steady_clock::now();
    client.deadline = client.since + time;
  }

  // Does everything that needs no waiting for the client.
  void turn(Client& client) {
    while (!client.closed) {
      switch (client.state) {
        case Client::State::head:
          if (auto head = client.connection.take_head()) {
            begin_request(client, std::move(*head));
          } else if (!take_in(client)) {
            return;
          }
          break;
        case Client::State::body:
          if (client.connection.body_arrived()) {
            handle(client);
          } else if (!take_in(client)) {
            return;
          }
          break;
        case Client::State::line:
          if (!client.admitted) return;
          answer(client, std::nullopt);
          break;
        case Client::State::answer:
          if (!send_answer(client)) return;
          break;
        case Client::State::linger:
          return linger(client);
      }
    }
  }

  // False if no progress is possible: the client becomes inactive, or is dropped.
  bool take_in(Client& client) {
    const bool idle = client.idle();
    switch (client.connection.receive()) {
      case Connection::Got::bytes:
        if (idle) enter(client, Client::State::head, options_.limits.head_time);
        return true;
      case Connection::Got::nothing:
        if (idle && ending_)
          drop(client);
        else
          rest(client, EPOLLIN | EPOLLRDHUP);
        return false;
      case Connection::Got::end:
        if (client.state != Client::State::body) return drop(client), false;
        handle(client);  // what came of a resumable upload counts; the route meets the end of the rest
        return true;
    }
    return false;
  }

  void begin_request(Client& client, tl::expected<Head, Refusal> head) {
    client.request = Request();
    client.match = {};
    client.request_begun = steady_clock::now();
    client.head_read = head.has_value();
    client.keep = head && head->keep_alive;
    if (!head) return answer(client, std::move(head.error()));
    Request& request = client.request;
    request.head_only = head->method == "HEAD";
    request.method = request.head_only ? "GET" : head->method;
    request.path = std::move(head->path);
    request.query = std::move(head->query);
    request.headers = std::move(head->headers);
    request.id = request_id(request.headers);
    request.content_length = head->content_length;
    request.body = &client.connection;
    request.by_front = through_front(request, options_.front_host);
    request.beyond_loopback = !is_loopback_socket(client.connection.socket());
    if (const auto refusal = inadmissible(client)) return answer(client, refusal);
    if (client.connection.body_arrived()) return handle(client);
    if (const auto admitted = admit(client); !admitted)
      return answer(client, Refusal{meaning(admitted.error().code).http_status, admitted.error()});
    if (request.content_length > small_body) return handle(client);
    client.connection.send_continue();
    enter(client, Client::State::body, options_.limits.wait);
  }

  // Decisions that need only the head and the table of the routes.
  std::optional<Refusal> inadmissible(Client& client) {
    const Request& request = client.request;
    if (auto refusal = check_origin(request, options_.front_host)) return refusal;
    client.match = router_.match(request.method, request.path);
    const Route* route = client.match.route;
    if (!route && !client.match.allowed.empty())
      return Refusal{405,
                     {Code::bad_usage,
                      "this address does not answer to that method",
                      {},
                      "use " + client.match.allowed}};
    if (!route) return Refusal{404, {Code::not_found, "there is nothing at this address", {}, "see /"}};
    if (auto refusal = query_refusal(*route, request.query)) return refusal;
    if (request.content_length > route->most_body) {
      const std::uint64_t most = route->most_body;
      return Refusal{413,
                     {Code::too_large,
                      "the body is larger than " + (most >= 1 << 20 ? std::to_string(most >> 20) + " MiB"
                                                                    : std::to_string(most) + " bytes"),
                      "request body", "send less"}};
    }
    return std::nullopt;
  }

  // Before waiting for the body of a request. A request that is already complete is checked by its route alone.
  Result<void> admit(Client& client) {
    const Route& route = *client.match.route;
    if (!route.admission) return {};
    const LoggedRequest logged(client.request.id);
    try {
      return route.admission(client.request);
    } catch (const std::exception& fault) {
      log_event("admission-failed", {{"fault", fault.what()}});
      return fail(Code::internal, "the server has an internal fault", {}, "try again");
    }
  }

  void handle(Client& client) {
    // The route waits for a large body, under a separate limit.
    if (client.request.content_length <= small_body && !join_line(client))
      return enter(client, Client::State::line, options_.limits.wait);
    answer(client, std::nullopt);
  }

  // The active requests of one route, and those that wait for one of them to end.
  struct Line {
    int at_work = 0;
    std::deque<std::uint64_t> waiting;
  };

  bool join_line(Client& client) {
    const std::lock_guard hold(lines_mutex_);
    Line& line = lines_[client.match.route];
    client.admitted = line.at_work < std::max(1, options_.threads / 4);
    if (client.admitted)
      ++line.at_work;
    else
      line.waiting.push_back(client.id);
    return client.admitted;
  }

  void leave_line(Client& client) {
    if (std::exchange(client.admitted, false)) leave_line(client.match.route);
  }

  // Gives the slot to the next waiting request; any thread runs it.
  void leave_line(const Route* route) {
    const std::lock_guard hold(lines_mutex_);
    Line& line = lines_[route];
    if (line.waiting.empty()) {
      --line.at_work;
      return;
    }
    ready_.emplace_back(line.waiting.front(), route);
    line.waiting.pop_front();
    ::eventfd_write(next_, 1);
  }

  void work_on_next() {
    eventfd_t one = 0;
    if (::eventfd_read(next_, &one) != 0) return;  // another thread took it
    std::pair<std::uint64_t, const Route*> next;
    {
      const std::lock_guard hold(lines_mutex_);
      next = ready_.front();
      ready_.pop_front();
    }
    if (const std::shared_ptr<Client> client = find(next.first)) {
      const std::lock_guard hold(client->turn);
      if (!client->closed && client->state == Client::State::line) {
        client->admitted = true;
        return turn(*client);
      }
    }
    leave_line(next.second);
  }

  // By the route, unless there is a refusal already.
  void answer(Client& client, const std::optional<Refusal>& refusal) {
    Answered answered;
    Request& request = client.request;
    if (request.id.empty()) request.id = request_id({});  // without a head
    const LoggedRequest logged(request.id);
    Response response;
    Places::Place place;
    try {
      response = refusal ? refused(client, *refusal) : respond(client);
      if (response.waiter || (response.stream && !request.head_only)) {
        leave_line(client);
        auto taken = places_.take(response.party);
        if (taken) place = std::move(*taken);
        response = taken ? waited(client, std::move(response)) : options_.refuse(request, taken.error());
      }
      if (response.refusal) {
        const std::vector<Header> more = std::move(response.headers);
        response = with_headers(options_.refuse(request, *response.refusal), more);
      }
    } catch (const std::exception& fault) {
      answered.fault = fault.what();
      response = options_.refuse(
          request, {500, {Code::internal, "the server has an internal fault", {}, "try again"}});
    }
    if (const auto& trouble = client.connection.trouble(); trouble && response.status >= 400)
      response = with_headers(options_.refuse(request, *trouble), response.headers);
    leave_line(client);
    if (client.match.route) answered.route = client.match.route->pattern;
    answered.method = request.method;
    answered.status = response.status;
    answered.seconds = std::chrono::duration<double>(steady_clock::now() - client.request_begun).count();
    if (options_.observe) options_.observe(answered);
    if (response.stream && !request.head_only)
      stream(client, response);
    else
      give(client, std::move(response));
  }

  Response refused(Client& client, const Refusal& refusal) {
    Response response = options_.refuse(client.request, refusal);
    if (refusal.status == 405) response.set("Allow", client.match.allowed);
    return response;
  }

  Response respond(Client& client) {
    Request& request = client.request;
    if (request.head_only)  // ranges are for GET (RFC 9110, 14.2)
      std::erase_if(request.headers,
                    [](const Header& header) { return equal_ignoring_case(header.name, "Range"); });
    request.captures = std::move(client.match.captures);
    auto result = handled(*client.match.route, request);
    if (result) return std::move(*result);
    return options_.refuse(request, {meaning(result.error().code).http_status, result.error()});
  }

  static Result<Response> handled(const Route& route, Request& request) {
    VACUFORM_TRY(digest, stated_digest(request, "Content-Digest"));
    std::unique_ptr<Body> checked;
    if (!digest.empty()) {
      checked = checked_body(*request.body, digest);
    }
    Body* const body = std::exchange(request.body, checked ? checked.get() : request.body);
    auto result = route.handler(request);
    request.body = body;
    return result;
  }

  Going going(Client& client) const {
    return [this, &connection = client.connection] { return !ending_ && !connection.gone(); };
  }

  Response waited(Client& client, Response response) {
    if (!response.waiter) return response;
    auto result = response.waiter(going(client));
    if (result) return std::move(*result);
    return options_.refuse(client.request, {meaning(result.error().code).http_status, result.error()});
  }

  // Adds those of `more` whose names are missing.
  static Response with_headers(Response response, const std::vector<Header>& more) {
    const std::size_t own = response.headers.size();
    for (const Header& header : more)
      if (std::none_of(response.headers.begin(), response.headers.begin() + static_cast<std::ptrdiff_t>(own),
                       [&](const Header& other) { return equal_ignoring_case(header.name, other.name); }))
        response.headers.push_back(header);
    return response;
  }

  // Sends what the socket accepts; the rest follows as the client reads.
  void give(Client& client, Response response) {
    // Bytes that arrived before the answer was sent are not a request of a client that waits for answers; they may be
    // smuggled.
    client.keep =
        client.keep && !ending_ && client.connection.body_arrived() && !client.connection.more_arrived();
    std::string text = response_head(client.request, response, client.keep);
    const bool body = !client.request.head_only && response.status != 204 && response.status != 304;
    if (body && !response.file) text += response.text;
    client.out =
        Outgoing(std::move(text),
                 body && response.file && response.file->bytes > 0 ? std::move(response.file) : std::nullopt);
    client.window_bytes = 0;
    enter(client, Client::State::answer, options_.limits.wait);
  }

  // Occupies its thread; sends no length, so the end of the connection marks the end of the body.
  void stream(Client& client, const Response& response) {
    client.keep = false;
    bool sent = client.connection.write(response_head(client.request, response, false));
    const Going on = going(client);
    try {
      while (sent && on()) {
        const std::optional<std::string> bytes = response.stream();
        if (!bytes) break;
        sent = bytes->empty() || client.connection.write(*bytes);
      }
    } catch (const std::exception& fault) {
      log_event("stream-failed", {{"fault", fault.what()}});
    }
    end_answer(client);
  }

  // False if the client becomes inactive, or is disconnected.
  bool send_answer(Client& client) {
    switch (client.out.send(client.connection.socket())) {
      case Outgoing::Sent::all:
        return end_answer(client);
      case Outgoing::Sent::blocked:
        held_ += client.out.memory() - client.held;
        client.held = client.out.memory();
        [[fallthrough]];
      case Outgoing::Sent::paused:
        rest(client, EPOLLOUT);
        return false;
      case Outgoing::Sent::broken:
        drop(client);
        return false;
    }
    return false;
  }

  bool end_answer(Client& client) {
    release(client);
    if (client.keep) {
      client.used = true;
      client.connection.end_request();
      enter(client, Client::State::head, options_.limits.idle_time);
      rest(client, EPOLLIN | EPOLLRDHUP);
      return false;
    }
    ::shutdown(client.connection.socket(), SHUT_WR);
    const bool all_read =
        client.head_read && client.connection.body_arrived() && !client.connection.more_arrived();
    if (all_read) return drop(client), false;
    // Closing with unread bytes would reset the connection and lose the answer in transit.
    enter(client, Client::State::linger, linger_time);
    return true;
  }

  void linger(Client& client) {
    std::array<char, 64 * 1024> piece;
    for (int i = 0; i < 16; ++i) {
      const ssize_t n = ::recv(client.connection.socket(), piece.data(), piece.size(), MSG_DONTWAIT);
      if (n < 0 && errno == EAGAIN) break;
      if (n == 0 || (n < 0 && errno != EINTR)) return drop(client);
    }
    rest(client, EPOLLIN);
  }

  // The functions from here on do not hold the turn of any client.

  // Enforces the time limits. Never waits for a client: a client whose turn is taken is active.
  void watch() {
    while (!stopping_) {
      std::this_thread::sleep_for(tick);
      const Instant now = steady_clock::now();
      for (const auto& client : all_clients()) {
        const std::unique_lock hold(client->turn, std::try_to_lock);
        if (!hold || client->closed) continue;
        if (ending_ && client->idle())
          drop(*client);
        else if (now >= client->deadline)
          too_late(*client);
      }
      if (held_ > most_held) make_room(Client::State::answer);
    }
  }

  void too_late(Client& client) {
    switch (client.state) {
      case Client::State::head:
        if (client.idle()) return drop(client);
        begin_request(client,
                      tl::make_unexpected(Refusal{408,
                                                  {Code::out_of_time, "the head of the request took too long",
                                                   "request head", "try again"}}));
        return turn(client);
      case Client::State::body:
        answer(client, client.connection.too_slow());
        return turn(client);
      case Client::State::line:
        answer(client, Refusal{503, {Code::busy, "too many requests of this kind wait", {}, "try again"}});
        return turn(client);
      case Client::State::answer: {
        const std::uint64_t taken = client.out.bytes();
        const double least = static_cast<double>(options_.limits.slowest_body) *
                             std::chrono::duration<double>(options_.limits.wait).count();
        if (static_cast<double>(taken - client.window_bytes) < least) return drop(client);
        client.window_bytes = taken;
        client.deadline = steady_clock::now() + options_.limits.wait;
        return;
      }
      case Client::State::linger:
        return drop(client);
    }
  }

  // Closes connections in this order: first idle ones, then those that have been sending a request for long, then those
  // that read their answers slowest. Closes a twentieth of all, so that the search is rare.
  bool make_room(std::optional<Client::State> only = std::nullopt) {
    struct Candidate {
      int order;
      double worth;
      std::shared_ptr<Client> client;
    };
    std::vector<Candidate> candidates;
    const Instant now = steady_clock::now();
    for (auto& client : all_clients()) {
      const std::unique_lock hold(client->turn, std::try_to_lock);
      if (!hold || client->closed || (only && client->state != *only)) continue;
      const double seconds = std::chrono::duration<double>(now - client->since).count();
      switch (client->state) {
        case Client::State::linger:
          candidates.push_back({0, -seconds, client});
          break;
        case Client::State::head:
          candidates.push_back({client->idle() && client->used ? 1 : 2, -seconds, client});
          break;
        case Client::State::body:
        case Client::State::line:
          candidates.push_back({2, -seconds, client});
          break;
        case Client::State::answer:
          candidates.push_back({3, static_cast<double>(client->out.bytes()) / (seconds + 1), client});
          break;
      }
    }
    const std::size_t enough =
        std::min(candidates.size(), static_cast<std::size_t>(options_.connections) / 20 + 1);
    std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(enough),
                      candidates.end(), [](const Candidate& a, const Candidate& b) {
                        return std::pair(a.order, a.worth) < std::pair(b.order, b.worth);
                      });
    bool made = false;
    for (std::size_t i = 0; i < enough; ++i) {
      Client& client = *candidates[i].client;
      const std::unique_lock hold(client.turn, std::try_to_lock);
      if (!hold || client.closed) continue;
      drop(client);
      made = true;
    }
    return made;
  }

  const ServerOptions options_;
  const Router router_;
  std::atomic<bool> ending_ = false;    // streams end, and connections after their answers
  std::atomic<bool> stopping_ = false;  // every wait ends
  std::atomic<int> open_ = 0;
  std::atomic<std::size_t> held_ = 0;  // bytes of answers that wait for their clients
  Places places_{options_.streams, options_.streams_of_one};
  UploadRoom room_{options_.uploads};
  int listener_ = -1, epoll_ = -1, wake_ = -1, next_ = -1, port_ = 0;
  std::mutex lines_mutex_;
  std::map<const Route*, Line> lines_;
  std::deque<std::pair<std::uint64_t, const Route*>>
      ready_;  // requests whose wait is over; next_ counts them
  std::mutex clients_mutex_;
  std::unordered_map<std::uint64_t, std::shared_ptr<Client>> clients_;
  std::uint64_t last_id_ = next_id;
  std::vector<std::thread> threads_;
};

Server::Server(std::unique_ptr<Loop> loop) : loop_(std::move(loop)) {}
Server::~Server() { loop_->end(); }
int Server::port() const { return loop_->port(); }
int Server::connections() const { return loop_->connections(); }
int Server::streams() const { return loop_->streams(); }

Result<std::unique_ptr<Server>> Server::start(ServerOptions options, Router router) {
  auto loop = std::make_unique<Loop>(std::move(options), std::move(router));
  if (auto started = loop->begin(); !started) {
    loop->end();
    return tl::make_unexpected(started.error());
  }
  return std::unique_ptr<Server>(new Server(std::move(loop)));
}

}  // namespace vacuform::http
