// A token as the API and the command line show it (the schema Token of api/openapi.yaml), and as they ask for one.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "server/access/tokens.hpp"

namespace vacuform {

nlohmann::ordered_json scopes_json(const Scopes& scopes);

// Without its secret and its hash.
nlohmann::ordered_json token_json(const Token& token);

// {"owner": "station-3", "scopes": ["submit", "read"], "days": 90}; without `days` it never expires. Errors: bad_usage
// (something is missing, unknown or of the wrong type).
Result<NewToken> new_token_from(const nlohmann::json& object, Millis now);

}  // namespace vacuform
