// The head of a request (RFC 9112): what it asks for, read strictly. Whatever two readers could understand in
// two ways is refused, so that a proxy in front and this server never disagree about where a request ends.
#pragma once

#include <chrono>
#include <cstdint>
#include <string_view>

#include "server/messages/message.hpp"

namespace vacuform::http {

struct Limits {
  std::size_t head_bytes = 32 * 1024;
  std::size_t head_lines = 100;
  std::chrono::milliseconds head_time{10'000};  // for a head
  std::chrono::milliseconds wait{
      30'000};  // for a small body; and the window in which slowest_body is measured
  std::uint64_t slowest_body = 4 * 1024;  // bytes a second that a client must send or take in each window
};

struct Head {
  std::string method;                             // as it was sent: HEAD is HEAD
  std::string path;                               // percent-decoded, without the query
  std::multimap<std::string, std::string> query;  // as sent
  std::vector<Header> headers;
  std::uint64_t content_length = 0;
  bool expects_continue = false;  // the client waits for "100 Continue" before it sends the body
};

// Reads a head without its last empty line; every line ends with CR LF. The refusal says what is wrong: 400,
// 411 (no Content-Length), 414, 417, 431, 501.
//
// The target may be a path or in absolute form, whose authority must be the one of Host. A header that only
// makes sense once (Host, Authorization, Range and the like) may occur once.
tl::expected<Head, Refusal> parse_head(std::string_view text, const Limits& limits);

// The request that has this head; its body and where it came from are not known yet.
Request request_of(Head head);

// "a%20b" -> "a b". A '%' without two hexadecimal digits stays as it is.
std::string percent_decoded(std::string_view text, bool plus_is_space = false);

}  // namespace vacuform::http
