// The web application and the files of the bundled sample, built into the program.
#pragma once

#include <string_view>

#include "server/messages/message.hpp"

namespace vacuform {

// A built-in file by its name: compressed if the client takes gzip, otherwise as it is. Errors: not_found.
Result<http::Response> app_file(const http::Request& request, std::string_view name);

// The page that loads the application, with the headers that let it load only files of this server and run no other code.
Result<http::Response> app_page(const http::Request& request);

}  // namespace vacuform
