#include "server/messages/head.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#include "api/base/text.hpp"
#include "server/messages/request_id.hpp"

namespace vacuform::http {

namespace {

constexpr std::size_t longest_request_line = 4096;

// Those that the server acts on and that carry one value. Two of them, and a proxy may act on one and the
// server on the other. Lists (Accept, If-Match, Connection) may come in several lines.
constexpr std::array<std::string_view, 22> single_headers{"Authorization",
                                                          "Content-Digest",
                                                          "Content-Encoding",
                                                          "Content-Length",
                                                          "Content-Type",
                                                          "Cookie",
                                                          "Expect",
                                                          "Host",
                                                          "Idempotency-Key",
                                                          "If-Range",
                                                          "Last-Event-ID",
                                                          "Origin",
                                                          "Range",
                                                          "Repr-Digest",
                                                          "Tus-Resumable",
                                                          "Upload-Checksum",
                                                          "Upload-Defer-Length",
                                                          "Upload-Length",
                                                          "Upload-Metadata",
                                                          "Upload-Offset",
                                                          "Vacuform-Lease",
                                                          "X-HTTP-Method-Override"};

tl::unexpected<Refusal> refuse(int status, std::string what, std::string fix) {
  Code code = Code::bad_usage;
  if (status == 413 || status == 414 || status == 431) code = Code::too_large;
  return tl::make_unexpected(Refusal{status, {code, std::move(what), "request head", std::move(fix)}});
}

tl::unexpected<Refusal> malformed_line() {
  return refuse(400, "the request line is malformed", "send HTTP/1.1");
}

bool is_token(std::string_view text) {
  static constexpr std::string_view others = "!#$%&'*+-.^_`|~";
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           others.find(c) != std::string_view::npos;
  });
}

bool printable(std::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return static_cast<unsigned char>(c) >= 32 || c == '\t'; });
}

// Takes the text up to the separator, and the separator.
std::string_view take_until(std::string_view& text, char separator) {
  const std::size_t at = text.find(separator);
  const std::string_view piece = text.substr(0, at);
  text.remove_prefix(at == std::string_view::npos ? text.size() : at + 1);
  return piece;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

bool known_method(std::string_view method) {
  for (const char* known : {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "CONNECT"})
    if (method == known) return true;
  return false;
}

// "http://host:port/path" -> "/path", and the authority. A path of its own stays; its authority is empty.
struct Target {
  std::string_view authority, path;
};
Target split_target(std::string_view target) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (target.size() < scheme.size() || !equal_ignoring_case(target.substr(0, scheme.size()), scheme))
      continue;
    target.remove_prefix(scheme.size());
    const std::size_t end = std::min(target.find_first_of("/?"), target.size());
    return {target.substr(0, end), target.substr(end)};
  }
  return {{}, target};
}

void parse_query(std::string_view text, std::multimap<std::string, std::string>& query) {
  while (!text.empty()) {
    std::string_view pair = take_until(text, '&');
    if (pair.empty()) continue;
    std::string name = percent_decoded(take_until(pair, '='), true);
    query.emplace(std::move(name), percent_decoded(pair, true));
  }
}

struct RequestLine {
  std::string_view method, target;
};

tl::expected<RequestLine, Refusal> parse_request_line(std::string_view line) {
  if (!printable(line) || line.find('\t') != std::string_view::npos) return malformed_line();
  if (line.size() > longest_request_line) return refuse(414, "the address is too long", "send a shorter one");
  RequestLine parsed;
  std::string_view rest = line;
  parsed.method = take_until(rest, ' ');
  parsed.target = take_until(rest, ' ');
  if (!is_token(parsed.method) || parsed.target.empty() || (rest != "HTTP/1.1" && rest != "HTTP/1.0"))
    return malformed_line();
  return parsed;
}

// What a header means for the framing of the request.
tl::expected<void, Refusal> take_framing(Head& head, std::string_view name, std::string_view value) {
  if (equal_ignoring_case(name, "Transfer-Encoding"))
    return refuse(411, "a body without Content-Length is not accepted",
                  "send Content-Length instead of chunks");
  if (equal_ignoring_case(name, "Content-Encoding") && !equal_ignoring_case(value, "identity"))
    return refuse(501, "an encoded body is not accepted", "send the body as it is, without Content-Encoding");
  if (equal_ignoring_case(name, "Content-Length")) {
    const auto [stop, error] =
        std::from_chars(value.data(), value.data() + value.size(), head.content_length);
    if (value.empty() || error != std::errc() || stop != value.data() + value.size())
      return refuse(400, "Content-Length is not one whole number", "send the number of bytes of the body");
  }
  if (equal_ignoring_case(name, "Expect")) {
    if (!equal_ignoring_case(value, "100-continue"))
      return refuse(417, "an unknown expectation", "send no Expect header");
    head.expects_continue = true;
  }
  return {};
}

tl::expected<void, Refusal> parse_headers(std::string_view text, const Limits& limits, Head& head) {
  std::array<bool, single_headers.size()> seen{};
  while (!text.empty()) {
    const std::size_t end = text.find("\r\n");
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 2);
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || !is_token(line.substr(0, colon)) || !printable(line))
      return refuse(400, "a header line is malformed", "send name: value");
    const std::string_view name = line.substr(0, colon), value = trimmed(line.substr(colon + 1), " \t");
    if (head.headers.size() >= limits.head_lines)
      return refuse(431, "the request has more than " + std::to_string(limits.head_lines) + " header lines",
                    "send fewer");
    for (std::size_t i = 0; i < single_headers.size(); ++i)
      if (equal_ignoring_case(name, single_headers[i])) {
        if (seen[i]) {
          if (equal_ignoring_case(name, "Content-Length"))
            return refuse(400, "Content-Length is not one whole number",
                          "send the number of bytes of the body");
          return refuse(400, "there is more than one " + std::string(single_headers[i]), "send one");
        }
        seen[i] = true;
      }
    if (auto taken = take_framing(head, name, value); !taken) return taken;
    head.headers.push_back({std::string(name), std::string(value)});
  }
  return {};
}

std::string_view host_of(const Head& head) {
  for (const Header& header : head.headers)
    if (equal_ignoring_case(header.name, "Host")) return header.value;
  return {};
}

}  // namespace

std::string percent_decoded(std::string_view text, bool plus_is_space) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int high = text[i] == '%' && i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
    const int low = high < 0 ? -1 : hex_digit(text[i + 2]);
    if (low >= 0) {
      out += static_cast<char>(high * 16 + low);
      i += 2;
    } else {
      out += plus_is_space && text[i] == '+' ? ' ' : text[i];
    }
  }
  return out;
}

// A proxy and this server would see different paths.
bool hides_a_separator(std::string_view path) {
  for (std::size_t at = 0; (at = path.find('%', at)) != std::string_view::npos; ++at)
    if (const auto code = lower(path.substr(at + 1, 2)); code == "2f" || code == "5c" || code == "00")
      return true;
  return false;
}

tl::expected<Head, Refusal> parse_head(std::string_view text, const Limits& limits) {
  const std::size_t first = text.find("\r\n");
  const auto line = parse_request_line(text.substr(0, first));
  Head head;
  text.remove_prefix(first + 2);
  if (!line && line.error().status != 400) return tl::make_unexpected(line.error());
  if (auto parsed = parse_headers(text, limits, head); !parsed) return tl::make_unexpected(parsed.error());
  const std::string_view host = host_of(head);
  if (host.data() == nullptr) return refuse(400, "there is no Host", "send HTTP/1.1 with a Host");
  if (!line) return tl::make_unexpected(line.error());
  if (!known_method(line->method))
    return refuse(501, "there is no such method here", "send GET, HEAD, POST, PUT, PATCH, DELETE or OPTIONS");
  head.method = line->method;
  Target target = split_target(line->target);
  if (target.authority.data() != nullptr && !equal_ignoring_case(target.authority, host))
    return refuse(400, "the address and Host name two different hosts", "send the same in both");
  const std::string_view path = take_until(target.path, '?');
  if (hides_a_separator(path))
    return refuse(400, "the path has an encoded separator", "send / and \\ as they are, and never a zero");
  head.path = percent_decoded(path);
  if (head.path.empty()) head.path = "/";  // "http://host" and "http://host?query"
  parse_query(target.path, head.query);
  return head;
}

Request request_of(Head head) {
  Request request;
  request.head_only = head.method == "HEAD";
  request.method = request.head_only ? "GET" : std::move(head.method);
  request.path = std::move(head.path);
  request.query = std::move(head.query);
  request.id = request_id(head.headers);
  request.headers = std::move(head.headers);
  if (request.head_only)  // ranges are for GET (RFC 9110, 14.2)
    std::erase_if(request.headers,
                  [](const Header& header) { return equal_ignoring_case(header.name, "Range"); });
  request.content_length = head.content_length;
  return request;
}

}  // namespace vacuform::http
