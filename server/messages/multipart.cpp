#include "server/messages/multipart.hpp"

#include <algorithm>
#include <vector>

#include "api/base/text.hpp"

namespace vacuform::http {

namespace {

constexpr std::size_t longest_head = 8192;
constexpr int most_parts = 128;
constexpr std::uint64_t most_outside =
    8192;  // bytes before the first part and behind the last, which are not used

tl::unexpected<Error> malformed(std::string what) {
  return fail(Code::bad_usage, std::move(what), "request body",
              "send the form as multipart/form-data (curl -F)");
}

// The value of a parameter after the first ';' of a header's value: token or quoted string.
bool parameter(std::string_view value, std::string_view wanted, std::string& out) {
  std::size_t at = value.find(';');
  while (at != std::string_view::npos && at < value.size()) {
    const std::size_t equals = value.find('=', ++at);
    if (equals == std::string_view::npos) return false;
    const std::string_view name = trimmed(value.substr(at, equals - at));
    std::string text;
    at = equals + 1;
    if (at < value.size() && value[at] == '"') {
      for (++at; at < value.size() && value[at] != '"'; ++at) {
        if (value[at] == '\\' && at + 1 < value.size() && (value[at + 1] == '"' || value[at + 1] == '\\'))
          ++at;
        text += value[at];
      }
      if (at >= value.size()) return false;  // the quote never ends
      at = value.find(';', at);
    } else {
      const std::size_t end = std::min(value.find(';', at), value.size());
      text = trimmed(value.substr(at, end - at));
      at = end;
    }
    if (equal_ignoring_case(name, wanted)) {
      out = std::move(text);
      return true;
    }
  }
  return false;
}

}  // namespace

// The first delimiter may open the body without the line end that belongs to it: pretend that it was there.
MultipartParser::MultipartParser(std::string_view boundary, PartSink& sink)
    : delimiter_("\r\n--" + std::string(boundary)), pending_("\r\n"), sink_(sink) {}

Result<void> MultipartParser::feed(std::string_view bytes) {
  if (place_ == Place::epilogue) return count_outside(bytes.size());
  pending_.append(bytes);
  std::size_t at = 0;  // all before it is done
  const auto keep_rest = [&] { pending_.erase(0, at); };
  for (;;) {
    const std::string_view rest = std::string_view(pending_).substr(at);
    switch (place_) {
      case Place::preamble:
      case Place::data: {
        const std::size_t found = rest.find(delimiter_);
        // Without the whole delimiter its beginning may still hide at the end.
        const std::size_t sure = found != std::string_view::npos   ? found
                                 : rest.size() < delimiter_.size() ? 0
                                                                   : rest.size() - delimiter_.size() + 1;
        if (place_ == Place::data && sure > 0) VACUFORM_CHECK(sink_.data(rest.substr(0, sure)));
        if (place_ == Place::preamble) VACUFORM_CHECK(count_outside(sure));
        at += sure;
        if (found == std::string_view::npos) return keep_rest(), Result<void>();
        if (place_ == Place::data) VACUFORM_CHECK(sink_.end());
        at += delimiter_.size();
        place_ = Place::after_delimiter;
        break;
      }
      case Place::after_delimiter:
        if (rest.size() < 2) return keep_rest(), Result<void>();
        at += 2;
        if (rest.starts_with("--")) {
          const std::size_t behind = rest.size() - 2;
          place_ = Place::epilogue;
          pending_.clear();
          return count_outside(behind);
        }
        if (!rest.starts_with("\r\n"))
          return malformed("a boundary is followed by neither a line end nor \"--\"");
        place_ = Place::head;
        break;
      case Place::head: {
        const std::size_t end = rest.find("\r\n\r\n");
        if (end > longest_head && rest.size() > longest_head)
          return malformed("the head of a part is too long");
        if (end == std::string_view::npos) return keep_rest(), Result<void>();
        VACUFORM_CHECK(read_head(rest.substr(0, end)));
        at += end + 4;
        place_ = Place::data;
        break;
      }
      case Place::epilogue:
        return {};
    }
  }
}

Result<void> MultipartParser::count_outside(std::size_t bytes) {
  outside_ += bytes;
  if (outside_ > most_outside) return malformed("there is too much before the first part or behind the last");
  return {};
}

Result<void> MultipartParser::finish() const {
  if (place_ != Place::epilogue) return malformed("the form ends before its last boundary");
  return {};
}

Result<void> MultipartParser::read_head(std::string_view head) {
  if (++parts_ > most_parts)
    return malformed("the form has more than " + std::to_string(most_parts) + " parts");
  std::string name, file_name;
  while (!head.empty()) {
    const std::size_t end = std::min(head.find("\r\n"), head.size());
    const std::string_view line = head.substr(0, end);
    head.remove_prefix(std::min(end + 2, head.size()));
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) return malformed("a line in the head of a part has no colon");
    const std::string_view key = trimmed(line.substr(0, colon), " \t"),
                           value = trimmed(line.substr(colon + 1), " \t");
    if (equal_ignoring_case(key, "Content-Disposition")) {
      parameter(value, "name", name);
      parameter(value, "filename", file_name);
    } else if (equal_ignoring_case(key, "Content-Transfer-Encoding") &&
               !equal_ignoring_case(value, "binary") && !equal_ignoring_case(value, "8bit") &&
               !equal_ignoring_case(value, "7bit")) {
      return malformed("a part has a transfer encoding");
    }
  }
  if (name.empty()) return malformed("a part has no name");
  return sink_.begin(name, file_name);
}

Result<std::string> multipart_boundary(std::string_view content_type) {
  const std::string_view kind = trimmed(content_type.substr(0, content_type.find(';')));
  std::string boundary;
  if (!equal_ignoring_case(kind, "multipart/form-data") || !parameter(content_type, "boundary", boundary) ||
      boundary.empty() || boundary.size() > 70)
    return fail(Code::unsupported_format, "the body is not multipart/form-data with a boundary",
                "Content-Type", "send the form as multipart/form-data (curl -F)");
  return boundary;
}

Result<void> read_multipart(Request& request, PartSink& sink) {
  VACUFORM_TRY(boundary, multipart_boundary(request.header("Content-Type")));
  MultipartParser parser(boundary, sink);
  VACUFORM_CHECK(request.body->read([&](std::string_view piece) { return parser.feed(piece); }));
  return parser.finish();
}

std::string safe_extension(std::string_view file_name) {
  const std::size_t dot = file_name.rfind('.');
  if (dot == std::string_view::npos) return {};
  const std::string extension = lower(file_name.substr(dot + 1));
  const bool plain = std::all_of(extension.begin(), extension.end(),
                                 [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); });
  return plain && extension.size() <= 8 ? extension : std::string();
}

}  // namespace vacuform::http
