// The one error type of Vacuform. Bad input is a value (Result); exceptions are for bugs.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "api/base/proposal.hpp"

namespace vacuform {

// Why something was refused. Every code has one problem type, one HTTP status and one exit code (api/problem.hpp).
enum class Code {
  bad_usage,           // the command line or the request is not of the documented form
  unreadable,          // a file cannot be opened, read or written
  unsupported_format,  // a file is of a kind that Vacuform does not read
  corrupt_file,        // a file claims a format and breaks its rules
  too_large,           // a limit on bytes, triangles, pixels or components is passed
  ambiguous_units,     // no unit, or more than one, makes the scan a plausible size
  unusable_scan,       // the scan was read, but no mold can be made of it
  does_not_fit,        // the mold does not fit the sheet, the window or the draw
  bad_settings,        // a setting is unknown, of the wrong type or out of range
  unusable_pattern,    // the pattern was read, but there is nothing in it to print
  forming_failed,      // the sheet does not come to rest, or tears
  unusable_surface,    // the formed sheet holds no region that a pattern can be laid on
  cancelled,           // the caller cancelled
  out_of_time,         // a limit on seconds or memory ended the work
  not_found,           // no such job, artifact or page
  conflict,            // the job is not in a state that allows this
  locked,              // another request is writing to it; try again when that has ended
  lease_lost,          // the lease token is no longer the job's
  unauthorized,        // there is no token, or it is wrong, expired or revoked
  forbidden,           // the token is good, but not for this
  too_many_attempts,   // too many wrong tokens; try again later
  busy,                // a bound on waiting jobs, uploads or streams is reached; try again later
  wrong_digest,        // bytes do not match the digest that was sent with them
  gone,                // there was such a thing, and it has expired
  disk_full,           // the server's disk has no room for more; deleting jobs makes some
  unavailable,         // the service cannot do this now; try again later
  internal,            // internal fault
};

struct Error {
  Code code = Code::internal;
  std::string what;                                    // what is wrong, one sentence without a full stop
  std::string where;                                   // the file, line, setting or place; may be empty
  std::string fix;                                     // what the user can do about it; may be empty
  std::optional<std::array<double, 3>> place_mm = {};  // of a fault on the mold, in the mold's frame
  std::vector<Proposal> proposals = {};                // settings with which it passes; `fix` names them too

  // "what (where); fix" on one line.
  std::string text() const;
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(Code code, std::string what, std::string where = {}, std::string fix = {}) {
  return tl::make_unexpected(Error{code, std::move(what), std::move(where), std::move(fix)});
}

// The same with proposals. `fix` is then written from them: advice_with().
inline tl::unexpected<Error> fail(Code code, std::string what, std::string where, const std::string& advice,
                                  std::vector<Proposal> proposals, const std::string& otherwise = {}) {
  std::string fix = advice_with(advice, proposals, otherwise);
  return tl::make_unexpected(
      Error{code, std::move(what), std::move(where), std::move(fix), {}, std::move(proposals)});
}

}  // namespace vacuform

// Evaluates a Result; on an error returns it from the enclosing function, otherwise declares `name` as the value.
#define VACUFORM_TRY(name, expression)                                   \
  auto name##_result = (expression);                                     \
  if (!name##_result) return tl::make_unexpected(name##_result.error()); \
  auto name = std::move(*name##_result)
// The same for Result<void>.
#define VACUFORM_CHECK(expression) \
  if (auto checked_result = (expression); !checked_result) return tl::make_unexpected(checked_result.error())
