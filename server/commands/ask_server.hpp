// Requests from a vacuform-server command to the server that runs on a data folder. They use the administrator's token
// in that folder, so every user who may read the folder may send them.
#pragma once

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "api/base/error.hpp"
#include "server/store/store.hpp"

namespace vacuform {

// Where the server of a data folder listens: "http://127.0.0.1:8080". Errors: `unopened` if none has been running.
Result<std::string> server_url(const std::filesystem::path& data, const Error& unopened);

// `path` starts with /api/v1/. Errors: those that the server returns; `unopened`, which says why the command cannot open the
// store itself, if no server has been running; unavailable if none is running now.
Result<nlohmann::ordered_json> ask_server(const std::filesystem::path& data, const Error& unopened,
                                          const std::string& method, const std::string& path,
                                          const std::string& body = {},
                                          std::chrono::seconds limit = std::chrono::seconds(30));

// Does `with_store` if no server has the store open, and asks the server otherwise. Errors: those of the store and of
// ask_server().
template <class WithStore>
Result<nlohmann::ordered_json> do_or_ask(const std::filesystem::path& data, const StoreOptions& places,
                                         const WithStore& with_store, const std::string& method,
                                         const std::string& path, const std::string& body = {},
                                         std::chrono::seconds limit = std::chrono::seconds(30)) {
  const auto store = open_store(data, places);
  if (store) return with_store(**store);
  if (store.error().code != Code::unavailable) return tl::make_unexpected(store.error());
  return ask_server(data, store.error(), method, path, body, limit);
}

}  // namespace vacuform
