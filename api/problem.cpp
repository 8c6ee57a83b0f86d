#include "api/problem.hpp"

#include <array>
#include <cstddef>

namespace vacuform {

namespace {

// In the order of Code.
constexpr std::array<CodeMeaning, static_cast<std::size_t>(Code::internal) + 1> meanings{{
    {"bad-usage", "The request is malformed", 400, 2,
     "The command line or the request has a form that Vacuform does not know: a missing file, an "
     "unknown option, a header that is not accepted.",
     "Compare it with the API description or the program's --help."},
    {"unreadable", "A file cannot be read or written", 422, 2, "A file could not be opened, read or written.",
     "Check that the file exists and that the program may use it."},
    {"unsupported-format", "The file's format is not supported", 415, 2,
     "The file is of a kind that Vacuform does not read. Scans are STL, OBJ, PLY, OFF, GLB or a zip of "
     "a model; patterns are SVG, PNG or JPEG.",
     "Export the file again in one of these formats."},
    {"corrupt-file", "The file is damaged", 422, 2,
     "The file says that it is of a known format and then breaks that format's rules. Often a transfer "
     "was cut.",
     "Copy or export the file again, and compare its size with the original."},
    {"too-large", "A limit is exceeded", 413, 2,
     "The file exceeds a limit on bytes, triangles, pixels or components.",
     "Reduce the scan to about a million triangles, or the pattern to the resolution that will be "
     "printed."},
    {"ambiguous-units", "The scan's unit is not clear", 422, 2,
     "Most scan formats do not say their unit. Vacuform guesses only when exactly one unit makes a "
     "plausible size.",
     "Set scan.units, or measure the longest side of the head and give it as scan.size_mm."},
    {"unusable-scan", "No mold can be made of the scan", 422, 2,
     "The scan was read, but no mold can be made of it: it is empty, flat, contains two heads, or "
     "nothing is left above the trim height.",
     "Look at the scan in a mesh viewer; set scan.up and scan.trim_mm, or scan.body for one of two "
     "heads."},
    {"does-not-fit", "The mold does not fit the sheet or the machine", 422, 2,
     "The mold does not fit the sheet, the clamp frame's window or the draw.",
     "Give a larger sheet and window, raise scan.trim_mm, or turn the scan with scan.yaw_deg."},
    {"bad-settings", "A setting is unknown or out of range", 422, 2,
     "A setting is unknown, of the wrong type or out of its range. The message names it and the range.",
     "Correct it; the settings schema lists all of them with their defaults."},
    {"unusable-pattern", "The pattern cannot be printed", 422, 2,
     "The pattern was read, but there is nothing in it to print, or its size is unknown.",
     "Check that it is not empty, and set pattern.width_mm."},
    {"forming-failed", "The sheet cannot be formed like this", 422, 2,
     "The simulated sheet does not come to rest, or it tears.",
     "Trim the mold higher (scan.trim_mm), use a larger window, or leave forming.law at its default."},
    {"unusable-surface", "No pattern can be laid on the formed sheet", 422, 2,
     "The formed sheet holds no region that a pattern can be laid on.",
     "Lower scan.trim_mm, or check that the scan stands upright."},
    {"cancelled", "Cancelled", 409, 130, "Somebody cancelled the job.", "Submit it again."},
    {"out-of-time", "A limit on time or memory ended the work", 422, 2,
     "A limit on time or memory ended the work.", "Use a coarser sheet.resolution_mm or a lower print.dpi."},
    {"not-found", "Not found", 404, 2,
     "There is no such job, file or page. Deleted jobs are gone with their files.", "See the list of jobs."},
    {"conflict", "The current state does not allow this", 409, 2,
     "The current state does not allow this: only jobs that have ended can be deleted, only others can "
     "be cancelled; an upload continues at its offset; an Idempotency-Key is for one submission.",
     "Look first at the job or the upload, or take another key."},
    {"locked", "Another request is writing to this", 423, 1,
     "Another request is sending bytes of the same upload.",
     "Wait until that request has ended, ask for the offset, and send the rest."},
    {"lease-lost", "The lease is no longer held", 409, 1,
     "A worker did not report in time, and another worker got its job.",
     "Nothing is lost. If it happens often, the worker's machine is overloaded or its network is slow."},
    {"unauthorized", "A valid token is needed", 401, 2,
     "The service needs a token. There was none, or it is wrong, expired or revoked.",
     "Sign in with your token; programs read it from --token-file or VACUFORM_TOKEN. The administrator "
     "makes tokens with vacuform-server token create."},
    {"forbidden", "The token does not allow this", 403, 2,
     "The token is valid, but it lacks the scope that this needs: submit, read, work or admin.",
     "Use a token that has the scope, or ask the administrator for one."},
    {"too-many-attempts", "There were too many wrong tokens", 429, 1,
     "Too many wrong tokens came in a short time. The service refuses further ones for a while.",
     "Wait a minute, and check that none of your programs still uses a revoked token. Valid tokens work "
     "all the time."},
    {"busy", "The service is busy", 429, 1,
     "The service has as many waiting jobs, uploads or listeners as it takes at a time.",
     "Try again after the time in Retry-After. The service kept nothing of this request."},
    {"wrong-digest", "The bytes do not match their digest", 400, 1,
     "The bytes do not match the digest that came with them. They were changed or cut on the way.",
     "Send them again. If it happens twice, compute the digest of the file again."},
    {"gone", "This has expired", 410, 2,
     "What was asked for has expired: an unfinished upload is kept for a day after its last byte.",
     "Begin the upload again."},
    {"disk-full", "The server's disk is full", 507, 1,
     "The disk of the service has no room for more files. Jobs can still be read, cancelled and "
     "deleted, and nothing that was accepted is lost.",
     "Delete jobs, scans and uploads that you no longer need, then try again. Ask the operator for a "
     "larger disk if this happens often."},
    {"unavailable", "The service cannot do this now", 503, 1,
     "The service cannot do this now, for example because it is just stopping.", "Try again a little later."},
    {"internal", "An internal fault of Vacuform", 500, 1, "An internal fault of Vacuform.",
     "Try again. If it happens again, report it with the job's settings and the log."},
}};

}  // namespace

const CodeMeaning& meaning(Code code) { return meanings.at(static_cast<std::size_t>(code)); }

std::optional<Code> code_from(std::string_view slug) {
  for (std::size_t i = 0; i < meanings.size(); ++i)
    if (meanings[i].slug == slug) return static_cast<Code>(i);
  return std::nullopt;
}

}  // namespace vacuform
