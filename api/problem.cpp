#include "api/problem.hpp"

#include <cstdlib>

namespace vacuform {

CodeMeaning meaning(Code code) {
  switch (code) {
    case Code::bad_usage:
      return {"bad-usage", "The request is malformed", 400, 2};
    case Code::unreadable:
      return {"unreadable", "A file cannot be read or written", 422, 2};
    case Code::unsupported_format:
      return {"unsupported-format", "The file's format is not supported", 415, 2};
    case Code::corrupt_file:
      return {"corrupt-file", "The file is damaged", 422, 2};
    case Code::too_large:
      return {"too-large", "A limit is exceeded", 413, 2};
    case Code::ambiguous_units:
      return {"ambiguous-units", "The scan's unit is not clear", 422, 2};
    case Code::unusable_scan:
      return {"unusable-scan", "No mold can be made of the scan", 422, 2};
    case Code::does_not_fit:
      return {"does-not-fit", "The mold does not fit the sheet or the machine", 422, 2};
    case Code::bad_settings:
      return {"bad-settings", "A setting is unknown or out of range", 422, 2};
    case Code::unusable_pattern:
      return {"unusable-pattern", "The pattern cannot be printed", 422, 2};
    case Code::forming_failed:
      return {"forming-failed", "The sheet cannot be formed like this", 422, 2};
    case Code::unusable_surface:
      return {"unusable-surface", "No pattern can be laid on the formed sheet", 422, 2};
    case Code::cancelled:
      return {"cancelled", "Cancelled", 409, 130};
    case Code::out_of_time:
      return {"out-of-time", "A limit on time or memory ended the work", 422, 2};
    case Code::not_found:
      return {"not-found", "Not found", 404, 2};
    case Code::conflict:
      return {"conflict", "The current state does not allow this", 409, 2};
    case Code::locked:
      return {"locked", "Another request is writing to this", 423, 1};
    case Code::lease_lost:
      return {"lease-lost", "The lease is no longer held", 409, 1};
    case Code::unauthorized:
      return {"unauthorized", "A valid token is needed", 401, 2};
    case Code::forbidden:
      return {"forbidden", "The token does not allow this", 403, 2};
    case Code::too_many_attempts:
      return {"too-many-attempts", "There were too many wrong tokens", 429, 1};
    case Code::busy:
      return {"busy", "The service is busy", 429, 1};
    case Code::wrong_digest:
      return {"wrong-digest", "The bytes do not match their digest", 400, 1};
    case Code::gone:
      return {"gone", "This has expired", 410, 2};
    case Code::disk_full:
      return {"disk-full", "The server's disk is full", 507, 1};
    case Code::unavailable:
      return {"unavailable", "The service cannot do this now", 503, 1};
    case Code::internal:
      return {"internal", "An internal fault of Vacuform", 500, 1};
  }
  std::abort();  // a code outside the enumeration is a bug
}

std::optional<Code> code_from(std::string_view slug) {
  for (int i = 0; i <= static_cast<int>(Code::internal); ++i)
    if (meaning(static_cast<Code>(i)).slug == slug) return static_cast<Code>(i);
  return std::nullopt;
}

}  // namespace vacuform
