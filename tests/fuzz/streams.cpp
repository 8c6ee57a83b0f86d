// What the server reads as it streams in: requests, forms, and the names in files on their way to the store. The first
// bytes of an input choose how the rest is cut into pieces; what comes out may not hang on it.
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>

#include "api/redaction/redaction.hpp"
#include "server/http/connection.hpp"
#include "server/messages/multipart.hpp"
#include "server/messages/range.hpp"
#include "tests/fuzz/targets.hpp"

namespace vacuform::fuzz {
namespace {

// Writes down what it is told, so that two readings can be compared.
class Record : public http::PartSink {
 public:
  Result<void> begin(const std::string& name, const std::string& file_name) override {
    told += "[" + name + "|" + file_name + "|";
    const std::string extension = http::safe_extension(file_name);
    require(extension.size() <= 8 &&
                std::all_of(extension.begin(), extension.end(),
                            [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); }),
            "an extension is eight letters and digits at most");
    return {};
  }
  Result<void> data(std::string_view bytes) override {
    told += bytes;
    return {};
  }
  Result<void> end() override {
    told += "]";
    return {};
  }
  std::string told;
};

// What the sink was told, and whether the form was whole.
std::pair<std::string, bool> form(std::string_view body, std::size_t piece) {
  Record record;
  http::MultipartParser parser("XX", record);
  for (std::size_t at = 0; at < body.size(); at += piece)
    if (!parser.feed(body.substr(at, piece))) return {record.told, false};
  return {record.told, parser.finish().has_value()};
}

// Gives its bytes in pieces of so many.
class Pieces : public ByteSource {
 public:
  Pieces(std::string_view bytes, std::size_t step) : bytes_(bytes), step_(step) {}
  Result<std::uint64_t> size() const override { return bytes_.size(); }
  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const override {
    if (offset >= bytes_.size()) return 0;
    return bytes_.copy(into.data(), std::min(step_, into.size()), static_cast<std::size_t>(offset));
  }

 private:
  const std::string_view bytes_;
  const std::size_t step_;
};

// The copy, or why it is refused.
std::pair<std::string, bool> redacted(std::string_view bytes, const std::string& extension,
                                      std::size_t piece) {
  std::string out;
  const auto keep = [&](std::string_view some) -> Result<void> {
    out += some;
    return {};
  };
  const auto done = redact(Pieces(bytes, piece), extension, keep);
  if (done) return {std::move(out), true};
  require(done.error().code != Code::internal, "a bad file is no fault of Vacuform's");
  return {done.error().text(), false};
}

std::size_t piece_of(std::string_view& bytes) {
  if (bytes.empty()) return 1;
  const auto first = static_cast<unsigned char>(bytes.front());
  bytes.remove_prefix(1);
  return 1 + first % 97u;
}

}  // namespace

void read_multipart(Bytes bytes) {
  std::string_view body = text(bytes);
  const std::size_t piece = piece_of(body);
  const auto whole = form(body, body.size() + 1), in_pieces = form(body, piece);
  require(whole.second == in_pieces.second, "a form is refused or not, however it is cut");
  if (whole.second) require(whole.first == in_pieces.first, "a form is the same, however it is cut");
  const auto boundary = http::multipart_boundary(body.substr(0, 200));
  if (boundary) require(!boundary->empty() && boundary->size() <= 70, "a boundary has 1 to 70 characters");
}

void redact_file(Bytes bytes) {
  static const std::array<std::string, 8> extensions{"stl", "obj", "ply", "off", "csv", "zip", "svg", ""};
  std::string_view file = text(bytes);
  const std::size_t piece = piece_of(file);
  const std::string& extension = extensions[piece % extensions.size()];
  const auto whole = redacted(file, extension, file.size() + 1);
  require(redacted(file, extension, piece) == whole, "a copy is the same, however its file is read");
  if (whole.second)
    require(redacted(whole.first, extension, whole.first.size() + 1) == whole, "a second copy is the same");
}

// The head of a request as it comes over a socket, then its body.
void read_request(Bytes bytes) {
  std::array<int, 2> ends{};
  require(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) == 0, "a socket");
  const Bytes sent =
      bytes.first(std::min<std::size_t>(bytes.size(), 60'000));  // what the socket holds at once
  require(::write(ends[1], sent.data(), sent.size()) == static_cast<ssize_t>(sent.size()), "a write");
  ::shutdown(ends[1], SHUT_WR);
  {
    const std::atomic<bool> stopping{false};
    http::Limits limits;
    http::Connection connection(ends[0], limits, stopping);
    const auto found = connection.read_head();
    if (found && *found) {
      const http::Head& head = **found;
      for (const auto& header : head.headers)
        require(
            (header.name + header.value).find_first_of(std::string_view("\r\n\0", 3)) == std::string::npos,
            "a header is one line");
      for (const auto& header : head.headers) {
        const http::RangeAnswer range = http::byte_range(header.value, 1000);
        require(range.kind != http::RangeAnswer::part || (range.first <= range.last && range.last < 1000),
                "a range lies in the file");
        http::names_etag(header.value, "\"abc\"");
      }
      std::array<char, 1000> piece{};
      std::uint64_t body = 0;
      for (ssize_t n = 0; (n = connection.read(piece.data(), piece.size())) > 0;)
        body += static_cast<std::uint64_t>(n);
      require(body <= head.content_length, "a body is no longer than it was said to be");
    }
  }
  ::close(ends[1]);
}

}  // namespace vacuform::fuzz
