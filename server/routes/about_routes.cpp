// What is about the service itself: its description, its problems, its style.
#include <nlohmann/json.hpp>

#include "api/problem.hpp"
#include "api/settings.hpp"
#include "server/messages/problem.hpp"
#include "server/pages/app_files.hpp"
#include "server/pages/assets.hpp"
#include "server/pages/pages.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;

namespace {

Result<Response> text_asset(const char* media_type, std::string text) {
  Response response = http::text_response(media_type, std::move(text));
  response.set("X-Content-Type-Options", "nosniff");
  return response;
}

// The plain pages share their look with the application.
std::string style() {
  std::string text;
  for (const char* file : {"tokens.css", "base.css", "plain.css"}) text += asset(file);
  return text;
}

}  // namespace

void add_about_routes(http::Router& router) {
  add_public(router, "GET", "/api/v1/settings-schema", [](Request&) -> Result<Response> {
    Response response = json_response(settings_schema());
    response.media_type = "application/schema+json";
    return response;
  });
  add_public(router, "GET", "/api/v1/openapi.yaml", [](Request&) -> Result<Response> {
    return http::text_response("application/yaml", std::string(asset("openapi.yaml")));
  });
  add_public(router, "GET", "/healthz", [](Request&) -> Result<Response> {
    return json_response({{"status", "ok"}});
  });
  add_public(router, "GET", "/problems/",
             [](Request&) -> Result<Response> { return html_response(problems_page()); });
  add_public(router, "GET", "/problems/{slug}", [](Request& request) -> Result<Response> {
    const auto code = code_from(request.at("slug"));
    if (!code) return fail(Code::not_found, "there is no such problem type", {}, "see /problems/");
    return html_response(problem_page(*code));
  });
  // The names of these files change with their content.
  add_public(router, "GET", "/app/{name}", [](Request& request) -> Result<Response> {
    VACUFORM_TRY(response, app_file(request, request.at("name")));
    response.set("Cache-Control", "public, max-age=31536000, immutable");
    return response;
  });
  add_public(router, "GET", "/sample/head.stl",
             [](Request& request) { return app_file(request, "head.stl"); });
  add_public(router, "GET", "/sample/pattern.svg",
             [](Request& request) { return app_file(request, "pattern.svg"); });
  add_public(router, "GET", "/job.js", [](Request&) {
    return text_asset("text/javascript; charset=utf-8", std::string(asset("job.js")));
  });
  add_public(router, "GET", "/style.css",
             [](Request&) { return text_asset("text/css; charset=utf-8", style()); });
}

}  // namespace vacuform
