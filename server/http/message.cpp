#include "server/http/message.hpp"

#include <strings.h>

#include <algorithm>
#include <array>

#include "server/http/range.hpp"

namespace vacuform::http {

std::string_view Request::header(std::string_view name) const {
  for (const Header& header : headers)
    if (header.name.size() == name.size() && strncasecmp(header.name.data(), name.data(), name.size()) == 0)
      return header.value;
  return {};
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
  std::array<char, 8192> piece;
  for (;;) {
    VACUFORM_TRY(n, request.body->read(piece));
    if (n == 0) return text;
    text.append(piece.data(), n);
    if (text.size() > limit) return too_large();
  }
}

Response text_response(std::string media_type, std::string text, int status) {
  Response response;
  response.status = status;
  response.media_type = std::move(media_type);
  response.text = std::move(text);
  return response;
}

Result<Response> file_response(const Request& request, File file, std::string media_type,
                               const std::string& etag) {
  VACUFORM_TRY(bytes, file.size());
  const std::string quoted = "\"" + etag + "\"";
  Response response;
  response.set("ETag", quoted);
  response.set("Accept-Ranges", "bytes");
  response.set("Cache-Control", "private, no-cache");
  if (names_etag(request.header("If-None-Match"), quoted)) {
    response.status = 304;
    return response;
  }
  response.media_type = std::move(media_type);
  FileBody body{std::make_shared<const File>(std::move(file)), 0, bytes};
  const std::string_view if_range = request.header("If-Range");
  if (if_range.empty() || if_range == quoted) {
    const RangeAnswer answer = byte_range(request.header("Range"), bytes);
    if (answer.kind == RangeAnswer::unsatisfiable) {
      response.status = 416;
      response.media_type.clear();
      response.set("Content-Range", "bytes */" + std::to_string(bytes));
      return response;
    }
    if (answer.kind == RangeAnswer::part) {
      response.status = 206;
      body.offset = answer.first;
      body.bytes = answer.last - answer.first + 1;
      response.set("Content-Range", "bytes " + std::to_string(answer.first) + "-" +
                                        std::to_string(answer.last) + "/" + std::to_string(bytes));
    }
  }
  response.file = std::move(body);
  return response;
}

}  // namespace vacuform::http
