// Explains each problem type to people: the page behind every "type" of the API's problems.
#include <nlohmann/json.hpp>

#include "api/problem.hpp"
#include "server/pages/pages.hpp"
#include "server/pages/template.hpp"

namespace vacuform {

using nlohmann::ordered_json;

namespace {

struct Explanation {
  std::string_view why, help;
};

Explanation explanation(Code code) {
  switch (code) {
    case Code::bad_usage:
      return {
          "The command line or the request has a form that Vacuform does not know: a missing file, an "
          "unknown option, "
          "a header that is not accepted.",
          "Compare it with the API description or the program's --help."};
    case Code::unreadable:
      return {"A file could not be opened, read or written.",
              "Check that the file exists and that the program may use it."};
    case Code::unsupported_format:
      return {
          "The file is of a kind that Vacuform does not read. Scans are STL, OBJ, PLY, OFF, GLB or a zip of "
          "a model; patterns "
          "are SVG, "
          "PNG or JPEG.",
          "Export the file again in one of these formats."};
    case Code::corrupt_file:
      return {
          "The file says that it is of a known format and then breaks that format's rules. Often a transfer "
          "was cut.",
          "Copy or export the file again, and compare its size with the original."};
    case Code::too_large:
      return {"The file exceeds a limit on bytes, triangles, pixels or components.",
              "Reduce the scan to about a million triangles, or the pattern to the resolution that will be "
              "printed."};
    case Code::ambiguous_units:
      return {
          "Most scan formats do not say their unit. Vacuform guesses only when exactly one unit makes a "
          "plausible size.",
          "Set scan.units, or measure the longest side of the head and give it as scan.size_mm."};
    case Code::unusable_scan:
      return {
          "The scan was read, but no mold can be made of it: it is empty, flat, contains two heads, or "
          "nothing "
          "is left above the trim height.",
          "Look at the scan in a mesh viewer; set scan.up and scan.trim_mm, or scan.body for one of two "
          "heads."};
    case Code::does_not_fit:
      return {"The mold does not fit the sheet, the clamp frame's window or the draw.",
              "Give a larger sheet and window, raise scan.trim_mm, or turn the scan with scan.yaw_deg."};
    case Code::bad_settings:
      return {
          "A setting is unknown, of the wrong type or out of its range. The message names it and the range.",
          "Correct it; the settings schema lists all of them with their defaults."};
    case Code::unusable_pattern:
      return {"The pattern was read, but there is nothing in it to print, or its size is unknown.",
              "Check that it is not empty, and set pattern.width_mm."};
    case Code::forming_failed:
      return {
          "The simulated sheet does not come to rest, or it tears.",
          "Trim the mold higher (scan.trim_mm), use a larger window, or leave forming.law at its default."};
    case Code::unusable_surface:
      return {"The formed sheet holds no region that a pattern can be laid on.",
              "Lower scan.trim_mm, or check that the scan stands upright."};
    case Code::cancelled:
      return {"Somebody cancelled the job.", "Submit it again."};
    case Code::out_of_time:
      return {"A limit on time or memory ended the work.",
              "Use a coarser sheet.resolution_mm or a lower print.dpi."};
    case Code::not_found:
      return {"There is no such job, file or page. Deleted jobs are gone with their files.",
              "See the list of jobs."};
    case Code::conflict:
      return {
          "The current state does not allow this: only jobs that have ended can be deleted, only others "
          "can be "
          "cancelled; an upload continues at its offset; an Idempotency-Key is for one submission.",
          "Look first at the job or the upload, or take another key."};
    case Code::locked:
      return {"Another request is sending bytes of the same upload.",
              "Wait until that request has ended, ask for the offset, and send the rest."};
    case Code::lease_lost:
      return {
          "A worker did not report in time, and another worker got its job.",
          "Nothing is lost. If it happens often, the worker's machine is overloaded or its network is slow."};
    case Code::unauthorized:
      return {"The service needs a token. There was none, or it is wrong, expired or revoked.",
              "Sign in with your token; programs read it from --token-file or VACUFORM_TOKEN. The "
              "administrator makes tokens with vacuform-server token create."};
    case Code::forbidden:
      return {"The token is valid, but it lacks the scope that this needs: submit, read, work or admin.",
              "Use a token that has the scope, or ask the administrator for one."};
    case Code::too_many_attempts:
      return {"Too many wrong tokens came in a short time. The service refuses further ones for a while.",
              "Wait a minute, and check that none of your programs still uses a revoked token. Valid tokens "
              "work all "
              "the time."};
    case Code::busy:
      return {"The service has as many waiting jobs, uploads or listeners as it takes at a time.",
              "Try again after the time in Retry-After. The service kept nothing of this request."};
    case Code::wrong_digest:
      return {"The bytes do not match the digest that came with them. They were changed or cut on the way.",
              "Send them again. If it happens twice, compute the digest of the file again."};
    case Code::gone:
      return {"What was asked for has expired: an unfinished upload is kept for a day after its last byte.",
              "Begin the upload again."};
    case Code::disk_full:
      return {
          "The disk of the service has no room for more files. Jobs can still be read, cancelled and "
          "deleted, and "
          "nothing that was accepted is lost.",
          "Delete jobs, scans and uploads that you no longer need, then try again. Ask the operator for a "
          "larger "
          "disk if this happens often."};
    case Code::unavailable:
      return {"The service cannot do this now, for example because it is just stopping.",
              "Try again a little later."};
    case Code::internal:
      return {"An internal fault of Vacuform.",
              "Try again. If it happens again, report it with the job's settings and the log."};
  }
  return {};
}

}  // namespace

Page problem_page(Code code) {
  const Explanation text = explanation(code);
  Page page;
  page.title = std::string(meaning(code).title);
  page.main = rendered("problem", {{"title", page.title},
                                   {"why", text.why},
                                   {"help", text.help},
                                   {"slug", meaning(code).slug},
                                   {"status", std::to_string(meaning(code).http_status)},
                                   {"exit_code", std::to_string(meaning(code).exit_code)}});
  return page;
}

Page problems_page() {
  ordered_json problems = ordered_json::array();
  for (int i = 0; i <= static_cast<int>(Code::internal); ++i) {
    const CodeMeaning code = meaning(static_cast<Code>(i));
    problems.push_back({{"slug", code.slug}, {"title", code.title}});
  }
  Page page;
  page.title = "Problems explained";
  page.main = rendered("problems", {{"problems", std::move(problems)}});
  return page;
}

Page refused_page(const http::Refusal& refusal) {
  Page page;
  page.title = std::string(meaning(refusal.error.code).title);
  page.status = refusal.status;
  page.main = rendered("refused", {{"problem", problem_values(refusal.error)}});
  return page;
}

}  // namespace vacuform
