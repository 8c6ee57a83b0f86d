// Profiles: settings under a name, for everybody to begin with, made by administrators.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "api/base/secrets.hpp"
#include "api/base/strict_json.hpp"
#include "api/settings.hpp"
#include "server/jobs/submission.hpp"
#include "server/jobs/submission_form.hpp"
#include "server/messages/problem.hpp"
#include "server/messages/range.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/lists.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;
using nlohmann::ordered_json;

namespace {

ordered_json profile_json(const Profile& profile) {
  return {{"name", profile.name},
          {"changed", rfc3339(profile.changed)},
          {"default", profile.is_default},
          {"settings", ordered_json::parse(profile.settings)}};
}

bool plain_name(const std::string& name) {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
}

// Of the text that is kept: the settings alone decide.
std::string etag_of(const Profile& profile) {
  std::string tag("\"");
  return tag.append(text_hash(profile.settings)).append("\"");
}

// The check of If-Match and If-None-Match, for the transaction that changes the profile.
ProfileGuard precondition(const Request& request, std::optional<http::Refusal>& refusal) {
  return [&request, &refusal](const std::optional<Profile>& now) {
    refusal = http::unmet_precondition(request, now ? etag_of(*now) : std::string());
    return !refusal;
  };
}

Response profile_response(const Profile& profile, int status) {
  Response response = json_response(profile_json(profile), status);
  response.set("ETag", etag_of(profile));
  return response;
}

Result<Response> list_profiles(Service& service, Request& request, const Caller&) {
  VACUFORM_TRY(asked, page_asked(request));
  VACUFORM_TRY(page, service.store.list_profiles(asked.limit, asked.cursor));
  ordered_json profiles = ordered_json::array();
  for (const Profile& profile : page.profiles) profiles.push_back(profile_json(profile));
  return page_response("profiles", std::move(profiles), page.next);
}

Result<Response> show_profile(Service& service, Request& request, const Caller&) {
  VACUFORM_TRY(profile, service.store.find_profile(request.at("name")));
  if (auto refusal = http::unmet_precondition(request, etag_of(profile)))
    return http::refused_response(std::move(*refusal));
  Response response = profile_response(profile, 200);
  if (http::names_etag(request.header("If-None-Match"), etag_of(profile))) {
    response.status = 304;
    response.text.clear();
    response.media_type.clear();
  }
  return response;
}

Result<Response> put_profile(Service& service, Request& request, const Caller& caller) {
  const std::string& name = request.at("name");
  if (!plain_name(name))
    return fail(Code::bad_usage, "not a name for a profile", "name", "give 1 to 64 of a-z, 0-9 and '-'");
  VACUFORM_TRY(text, read_json_text(request, largest_settings));
  VACUFORM_CHECK(settings_from_text(text));  // settings that no job accepts are refused here
  const auto object = strict_json<ordered_json>(text);
  if (!object || !object->is_object())
    return fail(Code::bad_usage, "the body is not a JSON object of settings", "request body",
                R"(send {"machine": {"window_width_mm": 280}})");
  const Profile profile{name, object->dump(), wall_clock()};
  std::optional<http::Refusal> refusal;
  const auto put = service.store.put_profile(profile, precondition(request, refusal));
  if (refusal) return http::refused_response(std::move(*refusal));
  VACUFORM_TRY(made, put);
  log_event("profile-put", {{"profile", name}, {"by", caller.token}});
  return profile_response(profile, made ? 201 : 200);
}

template <bool is_default>
Result<Response> set_default(Service& service, Request& request, const Caller& caller) {
  const std::string& name = request.at("name");
  VACUFORM_CHECK(service.store.set_default_profile(name, is_default));
  log_event("profile-default", {{"profile", name}, {"default", is_default}, {"by", caller.token}});
  return no_content();
}

Result<Response> delete_profile(Service& service, Request& request, const Caller& caller) {
  std::optional<http::Refusal> refusal;
  const auto removed = service.store.remove_profile(request.at("name"), precondition(request, refusal));
  if (refusal) return http::refused_response(std::move(*refusal));
  VACUFORM_CHECK(removed);
  log_event("profile-deleted", {{"profile", request.at("name")}, {"by", caller.token}});
  return no_content();
}

}  // namespace

void add_profile_routes(http::Router& router, Service& service) {
  const std::string all = "/api/v1/profiles", one = all + "/{name}";
  add_guarded(router, service, Scope::read, "GET", all + "?limit&cursor", list_profiles);
  add_guarded(router, service, Scope::read, "GET", one, show_profile);
  add_guarded(router, service, Scope::admin, "PUT", one, put_profile);
  add_guarded(router, service, Scope::admin, "DELETE", one, delete_profile);
  add_guarded(router, service, Scope::admin, "PUT", one + "/default", set_default<true>);
  add_guarded(router, service, Scope::admin, "DELETE", one + "/default", set_default<false>);
}

}  // namespace vacuform
