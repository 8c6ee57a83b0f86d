#include "server/messages/message.hpp"

#include <algorithm>

#include "api/base/sha256.hpp"
#include "api/base/text.hpp"
#include "server/messages/digest.hpp"
#include "server/messages/range.hpp"

namespace vacuform::http {

HeldBody::HeldBody(Body& body) {
  whole_ = body.read([&](std::string_view piece) -> Result<void> {
    text_ += piece;
    return {};
  });
}

Result<void> HeldBody::read(const Taker& take) {
  if (!text_.empty()) VACUFORM_CHECK(take(text_));
  return whole_;
}

std::string_view Request::header(std::string_view name) const {
  for (const Header& header : headers)
    if (equal_ignoring_case(header.name, name)) return header.value;
  return {};
}

bool Request::has(std::string_view name) const {
  return std::ranges::any_of(headers, [&](const Header& h) { return equal_ignoring_case(h.name, name); });
}

std::string Request::query_value(const std::string& name) const {
  const auto it = query.find(name);
  return it == query.end() ? std::string() : it->second;
}

Result<std::string> read_text(Request& request, std::uint64_t limit) {
  const auto too_large = [&] {
    return fail(Code::too_large, "the body has more than " + std::to_string(limit) + " bytes", {},
                "send less");
  };
  if (request.content_length > limit) return too_large();
  std::string text;
  VACUFORM_CHECK(request.body->read([&](std::string_view piece) -> Result<void> {
    text += piece;
    if (text.size() > limit) return too_large();
    return {};
  }));
  return text;
}

std::optional<Refusal> unmet_precondition(const Request& request, const std::string& quoted) {
  const std::string_view wanted = request.header("If-Match"), unwanted = request.header("If-None-Match");
  const auto refuse = [](const char* header, const char* fix) {
    return Refusal{
        412, {Code::conflict, "the current version is not the one that the request names", header, fix}};
  };
  const bool there = !quoted.empty();
  if (!wanted.empty() && !(there && names_strong_etag(wanted, quoted)))
    return refuse("If-Match", "read it again before you change it");
  if (request.method != "GET" && there && names_etag(unwanted, quoted))
    return refuse("If-None-Match", "leave the header out to replace what is there");
  return std::nullopt;
}

Response refused_response(Refusal refusal) {
  Response response;
  response.status = refusal.status;
  response.refusal = std::move(refusal);
  return response;
}

Response with_headers(Response response, const std::vector<Header>& more) {
  const auto own = static_cast<std::ptrdiff_t>(response.headers.size());
  for (const Header& header : more)
    if (std::none_of(response.headers.begin(), response.headers.begin() + own,
                     [&](const Header& other) { return equal_ignoring_case(header.name, other.name); }))
      response.headers.push_back(header);
  return response;
}

Response text_response(std::string media_type, std::string text, int status) {
  Response response;
  response.status = status;
  response.media_type = std::move(media_type);
  response.text = std::move(text);
  return response;
}

namespace {

constexpr std::uint64_t largest_digested_part = 16 << 20;

Result<std::string> sha256_of(const SourceBody& body) {
  Sha256 hash;
  std::vector<char> piece(64 * 1024);
  for (std::uint64_t done = 0; done < body.bytes;) {
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(piece.size(), body.bytes - done));
    VACUFORM_TRY(n, body.source->read_at(body.offset + done, {piece.data(), wanted}));
    if (n == 0) return fail(Code::unreadable, "a file is shorter than it was");
    hash.add(std::string_view(piece.data(), n));
    done += n;
  }
  return hash.hex();
}

// `sha256` is that of the whole file.
Result<void> set_digests(Response& response, const SourceBody& body, const std::string& sha256) {
  response.set("Repr-Digest", digest_field(sha256));
  if (response.status == 200) {
    response.set("Content-Digest", digest_field(sha256));
  } else if (body.bytes <= largest_digested_part) {
    VACUFORM_TRY(part, sha256_of(body));
    response.set("Content-Digest", digest_field(part));
  }
  return {};
}

}  // namespace

Result<Response> source_response(const Request& request, std::shared_ptr<const Source> source,
                                 std::uint64_t bytes, std::string media_type, const std::string& etag,
                                 const std::string& sha256) {
  const std::string quoted = "\"" + etag + "\"";
  Response response;
  response.set("ETag", quoted);
  response.set("Accept-Ranges", "bytes");
  response.set("Cache-Control", "private, no-cache");
  if (auto refusal = unmet_precondition(request, quoted)) return refused_response(std::move(*refusal));
  if (names_etag(request.header("If-None-Match"), quoted)) {
    response.status = 304;
    return response;
  }
  response.media_type = std::move(media_type);
  SourceBody body{std::move(source), 0, bytes};
  const std::string_view if_range = request.header("If-Range");
  if (if_range.empty() || if_range == quoted) {
    const RangeAnswer answer = byte_range(request.header("Range"), bytes);
    if (answer.kind == RangeAnswer::unsatisfiable) {
      Response refused = refused_response(
          {416,
           {Code::bad_usage, "the file has no such range of bytes", "Range", "ask for bytes that it has"}});
      refused.set("Content-Range", "bytes */" + std::to_string(bytes));
      return refused;
    }
    if (answer.kind == RangeAnswer::part) {
      response.status = 206;
      body.offset = answer.first;
      body.bytes = answer.last - answer.first + 1;
      response.set("Content-Range", "bytes " + std::to_string(answer.first) + "-" +
                                        std::to_string(answer.last) + "/" + std::to_string(bytes));
    }
  }
  if (response.status == 200) body.sha256 = sha256;
  if (!sha256.empty()) VACUFORM_CHECK(set_digests(response, body, sha256));
  response.file = std::move(body);
  return response;
}

}  // namespace vacuform::http
