// Lists in pages and other small answers that several routes give.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "server/messages/message.hpp"

namespace vacuform {

// A number of the query, or the one that stands for none. Errors: bad_usage.
Result<std::int64_t> query_number(const http::Request& request, const std::string& name,
                                  std::int64_t fallback, std::int64_t least, std::int64_t most);

// Which page of a list the query asks for, with `limit` (1 to 100, 20 where it says nothing) and `cursor` (empty: the
// first page). Errors: bad_usage, also for a cursor that no list can have given.
struct PageAsked {
  int limit = 20;
  std::string cursor;
};
Result<PageAsked> page_asked(const http::Request& request);

// {NAME: [...], "next": the cursor of the page after this one, or null}.
http::Response page_response(const char* name, nlohmann::ordered_json items,
                             const std::optional<std::string>& next);

// 204.
http::Response no_content();

}  // namespace vacuform
