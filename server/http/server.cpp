// cpp-httplib 0.11 (Debian 12) and 0.18 (Debian 13). It brings the listener, the threads, the parsing of the
// request line and the writing of responses. Its reading of heads and bodies is not used: 0.11 bounds
// neither, believes headers about the peer, and takes what a refused body leaves behind for the next request.
// Connection does that instead, and the library sees a request line and nothing else.
#include "server/http/server.hpp"

#include <httplib.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <strings.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <exception>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "api/log.hpp"
#include "api/sha256.hpp"
#include "server/http/digest.hpp"
#include "server/http/origin.hpp"
#include "server/http/places.hpp"
#include "server/http/request_id.hpp"

namespace vacuform::http {

namespace {

bool named(std::string_view name, std::string_view wanted) {
  return name.size() == wanted.size() && strncasecmp(name.data(), wanted.data(), name.size()) == 0;
}

// Lines that the library adds to heads by itself and that would be wrong in the one that this thread writes.
thread_local std::vector<std::string_view> unwanted_lines;

std::string without_lines(std::string head) {
  for (const std::string_view line : unwanted_lines)
    if (const std::size_t at = head.find(line); at != std::string::npos) head.erase(at, line.size());
  return head;
}

// The vetted request line in, the response out.
class LineStream : public httplib::Stream {
 public:
  explicit LineStream(Connection& connection) : connection_(connection) {
    text_ = connection.refusal() ? "GET / HTTP/1.1" : connection.head().request_line;
    text_ += "\r\n\r\n";
  }
  bool is_readable() const override { return at_ < text_.size(); }
  bool is_writable() const override { return true; }
  ssize_t read(char* into, std::size_t size) override {
    const std::size_t n = text_.copy(into, size, at_);
    at_ += n;
    return static_cast<ssize_t>(n);
  }
  ssize_t write(const char* bytes, std::size_t size) override {
    const bool head = !std::exchange(answered_, true);  // the library writes it in one piece
    const bool written =
        head ? connection_.write(without_lines({bytes, size})) : connection_.write({bytes, size});
    return written ? static_cast<ssize_t>(size) : -1;
  }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  // The library compares it with the limits of select(), which is not used here.
  socket_t socket() const override { return 0; }

 private:
  Connection& connection_;
  std::string text_;
  std::size_t at_ = 0;
  bool answered_ = false;
};

// The connection that this thread serves; the library's callbacks carry no context of their own.
thread_local Connection* served = nullptr;

// The two signatures that Debian's versions have.
using Setup = std::function<void(httplib::Request&)>;
template <class L>
void process(L& library, httplib::Stream& stream,
             bool (httplib::Server::*request)(httplib::Stream&, bool, bool&, const Setup&)) {
  bool closed = true;
  (library.*request)(stream, true, closed, nullptr);
}
template <class L>
void process(L& library, httplib::Stream& stream,
             bool (httplib::Server::*request)(httplib::Stream&, const std::string&, int, const std::string&,
                                              int, bool, bool&, const Setup&)) {
  bool closed = true;
  (library.*request)(stream, "", 0, "", 0, true, closed, nullptr);
}

// Gives the bytes of a file to the library; see FileBody.
class FileSender {
 public:
  explicit FileSender(FileBody body) : body_(std::move(body)) {
    if (!body_.sha256.empty()) hash_ = std::make_shared<Sha256>();
  }

  bool operator()(std::size_t offset, std::size_t length, httplib::DataSink& sink) const {
    std::array<char, 64 * 1024> piece;
    const auto n = body_.file->read_at(body_.offset + offset, {piece.data(), std::min(length, piece.size())});
    if (!n || *n == 0) return false;
    if (hash_) hash_->add(std::string_view(piece.data(), *n));
    if (hash_ && offset + *n == body_.bytes && hash_->hex() != body_.sha256) {
      log_event("blob-damaged", {{"blob", body_.sha256}});
      body_.file->doubt();
      return false;
    }
    return sink.write(piece.data(), *n);
  }

 private:
  FileBody body_;
  std::shared_ptr<Sha256> hash_;  // of what was sent; the library copies this object
};

void give(const Response& from, httplib::Response& to) {
  to.status = from.status;
  for (const Header& header : from.headers) to.set_header(header.name, header.value);
  if (!from.file || from.file->bytes == 0) {
    to.body = from.text;
    if (!from.media_type.empty()) to.set_header("Content-Type", from.media_type);
    return;
  }
  to.set_content_provider(from.file->bytes, from.media_type, FileSender(*from.file));
}

// Without a length: the end of the connection is the end of the body.
void give_stream(const Response& from, const Going& going, Places::Place place, httplib::Response& to) {
  to.status = from.status;
  for (const Header& header : from.headers) to.set_header(header.name, header.value);
  to.set_content_provider(from.media_type, [going, place = std::move(place), producer = from.stream](
                                               std::size_t, httplib::DataSink& sink) {
    try {
      const std::optional<std::string> bytes = going() ? producer() : std::nullopt;
      if (!bytes) return sink.done(), true;
      return bytes->empty() || sink.write(bytes->data(), bytes->size());
    } catch (const std::exception& fault) {  // the library would let it end the process
      log_event("stream-failed", {{"fault", fault.what()}});
      return false;
    }
  });
}

}  // namespace

class Server::Library : public httplib::Server {
 public:
  Library(ServerOptions options, Router router) : options_(std::move(options)), router_(std::move(router)) {
    new_task_queue = [threads = options_.threads + options_.streams] {
      return new httplib::ThreadPool(static_cast<std::size_t>(threads));
    };
    set_tcp_nodelay(true);
    // Not the library's SO_REUSEPORT, with which two servers would share a port without a word.
    set_socket_options([](socket_t socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
      // A browser opens connections before it needs them: none takes a thread before its first byte.
      const int seconds = 10;
      ::setsockopt(socket, IPPROTO_TCP, TCP_DEFER_ACCEPT, &seconds, sizeof seconds);
    });
    set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      answer(request, response);
      return HandlerResponse::Handled;
    });
    // What the library itself refuses: a request line that it cannot read.
    set_error_handler([this](const httplib::Request&, httplib::Response& response) {
      if (response.has_header("Content-Type")) return;
      const Refusal refusal{response.status,
                            {Code::bad_usage, "the request line is malformed", {}, "send HTTP/1.1"}};
      give(options_.refuse({}, refusal), response);
    });
  }

  Result<void> begin() {
    if (options_.port == 0)
      port_ = bind_to_any_port(options_.host);
    else
      port_ = bind_to_port(options_.host, options_.port) ? options_.port : -1;
    if (port_ <= 0)
      return fail(Code::bad_usage, "cannot listen on " + options_.host + ":" + std::to_string(options_.port),
                  {}, "see whether another program listens there, or give another port (0: any free one)");
    ::listen(svr_sock_, 256);  // the library's backlog of 5 turns bursts of clients away
    listener_ = std::thread([this] { listen_after_bind(); });
    return {};
  }

  void end() {
    using namespace std::chrono_literals;
    if (!listener_.joinable()) return;
    while (!is_running()) std::this_thread::sleep_for(1ms);
    ending_ = true;
    stop();
    for (int i = 0; i < 500 && active_ > 0; ++i) std::this_thread::sleep_for(10ms);
    stopping_ = true;
    listener_.join();
  }

  int port() const { return port_; }
  int connections() const { return active_; }
  int streams() const { return places_.taken(); }

 private:
  bool process_and_close_socket(socket_t socket) override {
    Limits limits = options_.limits;
    // Clients that are slow to say what they want must not take the last threads from the others.
    if (++active_ - streams() > options_.threads * 3 / 4)
      limits.head_time = std::min(limits.head_time, limits.crowded_head_time);
    {
      Connection connection(socket, limits, stopping_);
      if (connection.read_head()) {
        served = &connection;
        unwanted_lines.clear();
        LineStream stream(connection);
        process(*this, stream, &Library::process_request);
        served = nullptr;
        connection.finish();
      }
    }
    --active_;
    return true;
  }

  void answer(const httplib::Request& from, httplib::Response& to) {
    const auto begun = std::chrono::steady_clock::now();
    Answered answered;
    Request request;
    request.id = request_id(served->head().headers);
    const LoggedRequest logged(request.id);
    Response response;
    const bool head_only = from.method == "HEAD";
    Places::Place place;
    try {
      response = respond(from, request, answered);
      if (response.waiter || (response.stream && !head_only)) {
        auto taken = places_.take(response.party);
        if (taken) place = std::move(*taken);
        response = taken ? waited(request, std::move(response)) : options_.refuse(request, taken.error());
      }
      if (response.refusal)
        response = with_headers(options_.refuse(request, *response.refusal), response.headers);
    } catch (const std::exception& fault) {
      answered.fault = fault.what();
      response = options_.refuse(
          request, {500, {Code::internal, "the server met a fault of its own", {}, "try again"}});
    }
    response.set("X-Request-Id", request.id);
    if (head_only) unwanted_lines.push_back(library_ranges(response));
    if (response.status == 204 || response.status == 304 || (head_only && response.stream))
      unwanted_lines.push_back("\r\nContent-Length: 0");
    // It is about what is sent, and that is nothing here.
    if (head_only)
      std::erase_if(response.headers, [](const Header& header) { return header.name == "Content-Digest"; });
    if (response.stream && place)
      give_stream(response, going(), std::move(place), to);
    else
      give(response, to);
    answered.method = request.method;
    answered.status = response.status;
    answered.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    if (options_.observe) options_.observe(answered);
  }

  // For the thread that serves the connection.
  Going going() const {
    return [this] { return !ending_ && !served->gone(); };
  }

  Response waited(const Request& request, Response response) {
    if (!response.waiter) return response;
    auto result = response.waiter(going());
    if (result) return std::move(*result);
    return options_.refuse(request, {meaning(result.error().code).http_status, result.error()});
  }

  static Response with_headers(Response response, const std::vector<Header>& more) {
    response.headers.insert(response.headers.end(), more.begin(), more.end());
    return response;
  }

  // What the library says of every answer to HEAD; empty where it is right.
  static std::string_view library_ranges(const Response& response) {
    const bool ours = std::any_of(response.headers.begin(), response.headers.end(),
                                  [](const Header& header) { return header.name == "Accept-Ranges"; });
    return ours ? "" : "\r\nAccept-Ranges: bytes";
  }

  static Result<Response> handled(const Route& route, Request& request) {
    VACUFORM_TRY(digest, stated_digest(request, "Content-Digest"));
    std::unique_ptr<Body> checked;
    if (!digest.empty()) {
      checked = checked_body(*request.body, digest);
      request.body = checked.get();
    }
    return route.handler(request);
  }

  Response respond(const httplib::Request& from, Request& request, Answered& answered) {
    if (served->refusal()) return options_.refuse(request, *served->refusal());
    request.method = from.method == "HEAD" ? "GET" : from.method;
    request.path = from.path;
    for (const auto& [name, value] : from.params) request.query.emplace(name, value);
    request.headers = served->head().headers;
    if (from.method == "HEAD")  // ranges are for GET (RFC 9110, 14.2)
      std::erase_if(request.headers, [](const Header& header) { return named(header.name, "Range"); });
    request.content_length = served->head().content_length;
    request.body = served;
    if (const auto refusal = check_origin(request, options_.front_host))
      return options_.refuse(request, *refusal);
    Router::Match match = router_.match(request.method, request.path);
    if (!match.route && !match.allowed.empty()) {
      Response response = options_.refuse(
          request,
          {405,
           {Code::bad_usage, "this address does not answer to that method", {}, "use " + match.allowed}});
      response.set("Allow", match.allowed);
      return response;
    }
    if (!match.route)
      return options_.refuse(request,
                             {404, {Code::not_found, "there is nothing at this address", {}, "see /"}});
    answered.route = match.route->pattern;
    if (const auto refusal = query_refusal(*match.route, from.params))
      return options_.refuse(request, *refusal);
    request.captures = std::move(match.captures);
    auto result = handled(*match.route, request);
    if (result) return std::move(*result);
    return options_.refuse(request, {meaning(result.error().code).http_status, result.error()});
  }

  ServerOptions options_;
  Router router_;
  std::atomic<bool> ending_ = false;    // streams end
  std::atomic<bool> stopping_ = false;  // every wait ends
  std::atomic<int> active_ = 0;
  Places places_{options_.streams, options_.streams_of_one};
  int port_ = 0;
  std::thread listener_;
};

Server::Server(std::unique_ptr<Library> library) : library_(std::move(library)) {}
Server::~Server() { library_->end(); }
int Server::port() const { return library_->port(); }
int Server::connections() const { return library_->connections(); }
int Server::streams() const { return library_->streams(); }

Result<std::unique_ptr<Server>> Server::start(ServerOptions options, Router router) {
  auto library = std::make_unique<Library>(std::move(options), std::move(router));
  VACUFORM_CHECK(library->begin());
  return std::unique_ptr<Server>(new Server(std::move(library)));
}

}  // namespace vacuform::http
