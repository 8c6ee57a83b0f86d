// HTML for people: plain, complete without scripts, usable with keyboard, screen reader and phone.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "server/messages/message.hpp"

namespace vacuform {

struct Page {
  std::string title;  // plain text
  std::string main;   // HTML
  int status = 200;
  int refresh_seconds = 0;  // without scripts; 0: no refresh
  bool follows = false;     // with /job.js, the only script of any page
  bool signed_in = false;   // then the page offers to sign out
};

// The whole document with the headers that keep scripts, frames and other origins out of it.
http::Response html_response(const Page& page);

// The headers of every page, whatever loads into it.
void set_page_headers(http::Response& response);

// "See the result there" (303): after a form.
http::Response see_other(const std::string& place);

// A problem as a template shows it in a box at the top of a page; null if there is no problem.
nlohmann::ordered_json problem_values(const std::optional<Error>& error);

// "3.4 MiB"
std::string readable_bytes(std::uint64_t bytes);

}  // namespace vacuform
