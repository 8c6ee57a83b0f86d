// Scans that are uploaded once and used in many jobs.
#include <nlohmann/json.hpp>
#include <optional>

#include "api/base/log.hpp"
#include "server/jobs/form_file.hpp"
#include "server/jobs/json_artifact.hpp"
#include "server/jobs/submission.hpp"
#include "server/messages/multipart.hpp"
#include "server/messages/problem.hpp"
#include "server/routes/guard.hpp"
#include "server/routes/lists.hpp"
#include "server/routes/routes.hpp"

namespace vacuform {

using http::Request;
using http::Response;
using nlohmann::ordered_json;

namespace {

ordered_json inspection_json(const Job& job) {
  return {{"job", job.id},
          {"state", name(job.state)},
          {"problem", job.error ? problem_json(*job.error) : ordered_json()},
          {"href", "/api/v1/jobs/" + job.id}};
}

// Includes the results of its newest inspection.
Result<ordered_json> scan_json(Service& service, const StoredScan& scan, bool with_findings = false) {
  VACUFORM_TRY(newest, service.store.newest_inspection(scan));
  ordered_json inspection;
  if (newest) {
    inspection = inspection_json(*newest);
    if (with_findings) inspection["findings"] = json_artifact(service.store, *newest, "findings.json");
  }
  return ordered_json{{"id", scan.id},
                      {"created", rfc3339(scan.created)},
                      {"bytes", scan.blob.bytes},
                      {"sha256", scan.blob.sha256},
                      {"extension", scan.extension},
                      {"inspection", std::move(inspection)}};
}

// The part scan, a file, or the part scan_upload, the id of a complete upload.
class ScanForm : public http::PartSink {
 public:
  explicit ScanForm(Store& store) : store_(store) {}

  Result<void> begin(const std::string& name, const std::string& file_name) override {
    in_file_ = name == "scan";
    if ((in_file_ && file) || (name == "scan_upload" && !upload.empty()) ||
        (!in_file_ && name != "scan_upload"))
      return fail(Code::bad_usage, "an unknown or repeated part of the form: " + name.substr(0, 64),
                  "request body", "send scan, or scan_upload");
    if (!in_file_) return {};
    VACUFORM_TRY(started, FormFile::begin(store_, *input_kind("scan"), http::safe_extension(file_name)));
    file.emplace(std::move(started));
    return {};
  }

  Result<void> data(std::string_view bytes) override {
    if (in_file_) return file->write(bytes);
    if (upload.size() + bytes.size() > 64)
      return fail(Code::not_found, "there is no such upload", "scan_upload");
    upload += bytes;
    return {};
  }

  Result<void> end() override { return in_file_ ? file->end() : Result<void>(); }

  std::optional<FormFile> file;
  std::string upload;

 private:
  Store& store_;
  bool in_file_ = false;
};

Result<StoredScan> scan_from(Service& service, ScanForm& form, const Caller& caller) {
  if (!form.upload.empty() && !form.file) {
    VACUFORM_TRY(started, upload_for(service, form.upload, caller));
    VACUFORM_TRY(upload, service.uploads.whole(started));
    if (upload.input != "scan")
      return fail(Code::bad_usage, "the upload is a " + upload.input, "scan_upload", "upload a scan");
    return service.store.add_scan(caller.owner, *upload.blob, upload.extension);
  }
  if (!form.file || !form.file->given() || !form.upload.empty())
    return fail(Code::bad_usage, "the form needs one scan", "scan",
                "send either the part scan or scan_upload");
  return service.store.add_scan(caller.owner, std::move(*form.file->upload), form.file->extension);
}

Result<Response> create_scan(Service& service, Request& request, const Caller& caller) {
  VACUFORM_CHECK(service.store.room_for(request.content_length));  // before its bytes
  ScanForm form(service.store);
  VACUFORM_CHECK(http::read_multipart(request, form));
  VACUFORM_TRY(scan, scan_from(service, form, caller));
  log_event("scan-kept", {{"scan", scan.id}, {"token", caller.token}});
  VACUFORM_TRY(shown, scan_json(service, scan));
  Response response = json_response(shown, 201);
  response.set("Location", "/api/v1/scans/" + scan.id);
  return response;
}

Result<Response> list_scans(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(asked, page_asked(request));
  VACUFORM_TRY(page, service.store.list_scans(asked.limit, asked.cursor, caller.only()));
  ordered_json scans = ordered_json::array();
  for (const StoredScan& scan : page.scans) {
    VACUFORM_TRY(shown, scan_json(service, scan));
    scans.push_back(std::move(shown));
  }
  return page_response("scans", std::move(scans), page.next);
}

Result<Response> show_scan(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(scan, scan_for(service, request.at("id"), caller));
  VACUFORM_TRY(shown, scan_json(service, scan, true));
  return json_response(shown);
}

Result<Response> delete_scan(Service& service, const Request& request, const Caller& caller) {
  VACUFORM_TRY(scan, scan_for(service, request.at("id"), caller));
  VACUFORM_CHECK(service.store.remove_scan(scan.id));
  log_event("scan-deleted", {{"scan", scan.id}, {"token", caller.token}});
  return no_content();
}

}  // namespace

void add_scan_routes(http::Router& router, Service& service) {
  add_guarded(router, service, Scope::submit, "POST", "/api/v1/scans", create_scan, largest_form("scan"));
  add_guarded(router, service, Scope::read, "GET", "/api/v1/scans?limit&cursor", list_scans);
  add_guarded(router, service, Scope::read, "GET", "/api/v1/scans/{id}", show_scan);
  add_guarded(router, service, Scope::submit, "DELETE", "/api/v1/scans/{id}", delete_scan);
}

}  // namespace vacuform
