#include "server/pages/html.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "api/problem.hpp"
#include "server/messages/problem.hpp"
#include "server/pages/template.hpp"

namespace vacuform {

using nlohmann::ordered_json;

void set_page_headers(http::Response& response) {
  response.set("X-Frame-Options", "DENY");
  response.set("Referrer-Policy", "same-origin");  // "no-referrer" would take the Origin off our own forms
  response.set("Cross-Origin-Opener-Policy", "same-origin");
  response.set("Cache-Control", "no-store");
}

http::Response html_response(const Page& page) {
  const std::string text =
      rendered("document",
               {{"title", page.title},
                {"main", page.main},
                {"refresh", page.refresh_seconds > 0 ? std::to_string(page.refresh_seconds) : std::string()},
                {"follows", page.follows},
                {"signed_in", page.signed_in}});
  http::Response response = http::text_response("text/html; charset=utf-8", text, page.status);
  response.set(
      "Content-Security-Policy",
      std::string("default-src 'self'; script-src ") + (page.follows ? "'self'" : "'none'") +
          "; object-src 'none'; img-src 'self' data:; form-action 'self'; base-uri 'none'; frame-ancestors "
          "'none'");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  set_page_headers(response);
  set_retry_after(response);
  return response;
}

http::Response see_other(const std::string& place) {
  http::Response response;
  response.status = 303;
  response.set("Location", place);
  return response;
}

ordered_json problem_values(const std::optional<Error>& error) {
  if (!error) return nullptr;
  const CodeMeaning code = meaning(error->code);
  return {{"title", code.title},
          {"slug", code.slug},
          {"what", error->what},
          {"where", error->where},
          {"fix", error->fix}};
}

std::string readable_bytes(std::uint64_t bytes) {
  if (bytes < 1024) return std::to_string(bytes) + " B";
  char text[32];
  const double kib = static_cast<double>(bytes) / 1024, mib = kib / 1024;
  if (kib < 1023.5)  // 1024 is written as 1.0 of the next unit
    std::snprintf(text, sizeof text, "%.0f KiB", kib);
  else if (mib < 1023.95)
    std::snprintf(text, sizeof text, "%.1f MiB", mib);
  else
    std::snprintf(text, sizeof text, "%.1f GiB", mib / 1024);
  return text;
}

}  // namespace vacuform
