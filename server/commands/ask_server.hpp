// What a command of vacuform-server asks of the server that runs on a data folder: with the administrator's token that
// lies there, whoever may read the folder may ask.
#pragma once

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "api/base/error.hpp"

namespace vacuform {

// `path` begins with /api/v1/. Errors: those that the server states; unavailable when none runs.
Result<nlohmann::ordered_json> ask_server(const std::filesystem::path& data, const std::string& method,
                                          const std::string& path, const std::string& body = {},
                                          std::chrono::seconds limit = std::chrono::seconds(30));

}  // namespace vacuform
