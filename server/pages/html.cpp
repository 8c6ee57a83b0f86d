#include "server/pages/html.hpp"

#include <cstdio>

#include "api/problem.hpp"
#include "server/http/problem.hpp"

namespace vacuform {

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  return out;
}

http::Response html_response(const Page& page) {
  std::string refresh = page.refresh_seconds > 0 ? "<meta http-equiv=\"refresh\" content=\"" +
                                                       std::to_string(page.refresh_seconds) + "\">\n"
                                                 : "";
  if (page.follows)
    refresh = "<noscript>" + refresh + "</noscript>\n<script src=\"/job.js\" defer></script>\n";
  const std::string text =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n" +
      refresh + "<title>" + escaped(page.title) + " - Vacuform</title>\n" +
      "<link rel=\"stylesheet\" href=\"/style.css\">\n<link rel=\"icon\" href=\"data:,\">\n</head>\n<body>\n"
      "<a class=\"skip\" href=\"#main\">Skip to the content</a>\n"
      "<header><a href=\"/\">Vacuform</a> <span>pre-distorted prints for vacuum-formed "
      "sheets</span>" +
      std::string(page.signed_in ? "<form method=\"post\" action=\"/sign-out\"><button type=\"submit\">Sign "
                                   "out</button></form>"
                                 : "") +
      "</header>\n"
      "<main id=\"main\">\n" +
      page.main +
      "</main>\n<footer><a href=\"/api/v1/openapi.yaml\">API</a> <a href=\"/problems/\">Problems "
      "explained</a>"
      "</footer>\n</body>\n</html>\n";
  http::Response response = http::text_response("text/html; charset=utf-8", text, page.status);
  response.set(
      "Content-Security-Policy",
      std::string("default-src 'self'; script-src ") + (page.follows ? "'self'" : "'none'") +
          "; object-src 'none'; img-src 'self' data:; form-action 'self'; base-uri 'none'; frame-ancestors "
          "'none'");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("X-Frame-Options", "DENY");
  response.set("Referrer-Policy", "same-origin");  // "no-referrer" would take the Origin off our own forms
  response.set("Cross-Origin-Opener-Policy", "same-origin");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Cache-Control", "no-store");
  set_retry_after(response);
  return response;
}

http::Response see_other(const std::string& place) {
  http::Response response;
  response.status = 303;
  response.set("Location", place);
  return response;
}

std::string problem_box(const Error& error) {
  const CodeMeaning code = meaning(error.code);
  std::string box =
      "<section class=\"problem\" role=\"alert\" aria-labelledby=\"problem\">\n<h2 id=\"problem\">" +
      escaped(code.title) + "</h2>\n<p>" + escaped(error.what) + "</p>\n";
  if (!error.where.empty()) box += "<p><strong>Where:</strong> " + escaped(error.where) + "</p>\n";
  if (!error.mend.empty()) box += "<p><strong>What to do:</strong> " + escaped(error.mend) + "</p>\n";
  return box + "<p><a href=\"/problems/" + std::string(code.slug) +
         "\">More about this problem</a></p>\n</section>\n";
}

std::string readable_bytes(std::uint64_t bytes) {
  if (bytes < 1024) return std::to_string(bytes) + " B";
  char text[32];
  const double kib = static_cast<double>(bytes) / 1024;
  if (kib < 1024)
    std::snprintf(text, sizeof text, "%.0f KiB", kib);
  else
    std::snprintf(text, sizeof text, "%.1f MiB", kib / 1024);
  return text;
}

}  // namespace vacuform
