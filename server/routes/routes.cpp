// What all routes have in common.
#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "api/problem.hpp"
#include "api/settings.hpp"
#include "server/http/problem.hpp"
#include "server/pages/assets.hpp"
#include "server/pages/pages.hpp"
#include "server/routes/service.hpp"

namespace vacuform {

using http::Request;
using http::Response;

void add_guarded(http::Router& router, Service& service, Scope scope, std::string method, std::string pattern,
                 GuardedHandler handler, std::uint64_t most_body) {
  Service* const s = &service;
  router.add({std::move(method), std::move(pattern),
              [s, scope, handler = std::move(handler)](Request& request) -> Result<Response> {
                VACUFORM_TRY(caller, s->access.check(request, scope));
                return handler(*s, request, caller);
              },
              most_body,
              [s, scope](const Request& request) -> Result<void> {
                VACUFORM_CHECK(s->access.check(request, scope));
                return {};
              }});
}

Result<Job> job_for(Service& service, const Request& request, const Caller& caller) {
  auto job = service.store.job(request.at("id"));
  if (job && !caller.sees(*job))
    return fail(Code::not_found, "there is no such job", request.at("id"), "see the list of jobs");
  return job;
}

Result<std::int64_t> query_number(const Request& request, const std::string& name, std::int64_t fallback,
                                  std::int64_t least, std::int64_t most) {
  const std::string text = request.query_value(name);
  if (text.empty()) return fallback;
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < least || number > most)
    return fail(
        Code::bad_usage,
        name + " is not a number from " + std::to_string(least) + " to " + std::to_string(most) + ": " + text,
        name, "give for example " + std::to_string(fallback));
  return number;
}

Result<std::string> page_cursor(const Request& request) {
  const std::string cursor = request.query_value("cursor");
  const bool plain = std::all_of(cursor.begin(), cursor.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
  if (!plain || cursor.size() > 64)
    return fail(Code::bad_usage, "no list gave this cursor", "cursor", "give the next of the page before");
  return cursor;
}

void add_public_routes(http::Router& router, Service&) {
  router.add("GET", "/api/v1/settings-schema", [](Request&) -> Result<Response> {
    Response response = json_response(settings_schema());
    response.media_type = "application/schema+json";
    return response;
  });
  router.add("GET", "/api/v1/openapi.yaml", [](Request&) -> Result<Response> {
    return http::text_response("application/yaml", std::string(openapi_yaml()));
  });
  router.add("GET", "/healthz", [](Request&) -> Result<Response> {
    return json_response({{"status", "ok"}});
  });
  router.add("GET", "/problems/",
             [](Request&) -> Result<Response> { return html_response(problems_page()); });
  router.add("GET", "/problems/{slug}", [](Request& request) -> Result<Response> {
    const auto code = code_from(request.at("slug"));
    if (!code) return fail(Code::not_found, "there is no such problem type", {}, "see /problems/");
    return html_response(problem_page(*code));
  });
  router.add("GET", "/job.js", [](Request&) -> Result<Response> {
    Response response = http::text_response("text/javascript; charset=utf-8", std::string(job_js()));
    response.set("X-Content-Type-Options", "nosniff");
    return response;
  });
  router.add("GET", "/style.css", [](Request&) -> Result<Response> {
    Response response = http::text_response("text/css; charset=utf-8", std::string(style_css()));
    response.set("X-Content-Type-Options", "nosniff");
    return response;
  });
}

http::Router all_routes(Service& service) {
  http::Router router;
  add_job_routes(router, service);
  add_worker_routes(router, service);
  add_event_routes(router, service);
  add_upload_routes(router, service);
  add_scan_routes(router, service);
  add_profile_routes(router, service);
  add_token_routes(router, service);
  add_limits_routes(router, service);
  add_backup_routes(router, service);
  add_page_routes(router, service);
  add_sign_in_routes(router, service);
  add_public_routes(router, service);
  return router;
}

Response refuse(const Request& request, const http::Refusal& refusal) {
  const bool page =
      !request.path.starts_with("/api/") && request.header("Accept").find("text/html") != std::string::npos;
  if (!page) return problem_response(refusal.error, refusal.status);
  if (refusal.error.code == Code::unauthorized && request.method == "GET") return see_other("/sign-in");
  Page shown;
  shown.title = std::string(meaning(refusal.error.code).title);
  shown.status = refusal.status;
  shown.main =
      "<h1>This did not work</h1>\n" + problem_box(refusal.error) + "<p><a href=\"/\">To the start</a></p>\n";
  return html_response(shown);
}

}  // namespace vacuform
