#include "server/pages/app_files.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "server/pages/assets.hpp"
#include "server/pages/html.hpp"

namespace vacuform {

using http::Request;
using http::Response;

namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 5> media_types{{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".stl", "model/stl"},
}};

std::string media_type_of(std::string_view name) {
  const auto* const found = std::find_if(media_types.begin(), media_types.end(),
                                         [&](const auto& type) { return name.ends_with(type.first); });
  if (found == media_types.end())
    throw std::logic_error("a built-in file has no media type: " + std::string(name));
  return std::string(found->second);
}

// "gzip", "*" or neither, of which none has the quality 0 (RFC 9110, section 12.5.3).
bool takes_gzip(const Request& request) {
  std::string_view all = request.header("Accept-Encoding");
  while (!all.empty()) {
    const std::size_t end = all.find(',');
    std::string entry(all.substr(0, end));
    all.remove_prefix(end == std::string_view::npos ? all.size() : end + 1);
    std::erase(entry, ' ');
    const std::string_view coding = std::string_view(entry).substr(0, entry.find(';'));
    const std::size_t quality = entry.find("q=");
    const bool refused =
        quality != std::string::npos && entry.find_first_not_of("0.", quality + 2) == std::string::npos;
    if (coding == "gzip" || coding == "*") return !refused;
  }
  return false;
}

std::string inflated(std::string_view compressed) {
  z_stream stream{};
  if (inflateInit2(&stream, 16 + MAX_WBITS) != Z_OK) throw std::bad_alloc();
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(compressed.data()));
  stream.avail_in = static_cast<uInt>(compressed.size());
  std::string text;
  std::array<char, 1 << 14> piece;
  int state = Z_OK;
  while (state == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = piece.size();
    state = inflate(&stream, Z_NO_FLUSH);
    text.append(piece.data(), piece.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  if (state != Z_STREAM_END) throw std::logic_error("a built-in file is not what gzip wrote");
  return text;
}

}  // namespace

Result<Response> app_file(const Request& request, std::string_view name) {
  const auto all = app_files();
  const std::string stored = std::string(name) + ".gz";
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Asset& file) { return file.name == stored; });
  if (found == all.end())
    return fail(Code::not_found, "the application has no such file", {}, "load the page again");
  const bool packed = takes_gzip(request);
  Response response =
      http::text_response(media_type_of(name), packed ? std::string(found->bytes) : inflated(found->bytes));
  if (packed) response.set("Content-Encoding", "gzip");
  response.set("Vary", "Accept-Encoding");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  return response;
}

Result<Response> app_page(const Request& request) {
  VACUFORM_TRY(response, app_file(request, "index.html"));
  response.set(
      "Content-Security-Policy",
      "default-src 'none'; script-src 'self'; worker-src 'self'; style-src 'self'; img-src 'self' blob: "
      "data:; connect-src 'self'; font-src 'self'; form-action 'self'; base-uri 'none'; "
      "frame-ancestors 'none'; require-trusted-types-for 'script'; trusted-types vacuform");
  set_page_headers(response);
  return response;
}

}  // namespace vacuform
