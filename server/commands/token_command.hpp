// vacuform-server token create|list|revoke: tokens from the command line, for users who may read the data folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "api/base/error.hpp"
#include "server/store/store.hpp"

namespace CLI {
class App;
}

namespace vacuform {

// Opens the store if no server has it open. Otherwise asks the running server, with the administrator's token that the
// server stored in the data folder. A new token is printed once, or written to a file that only its owner can read.
class TokenCommand {
 public:
  void add_to(CLI::App& app);
  bool asked() const;
  // `configured_data` is the data folder if --data is absent, `places` says what is kept elsewhere. Errors: bad_usage,
  // not_found, unauthorized (the administrator's token is missing or was revoked), those of the store.
  Result<void> run(const std::filesystem::path& configured_data, const StoreOptions& places);

 private:
  Result<void> create() const;
  Result<void> list() const;
  Result<void> revoke() const;

  CLI::App *token_ = nullptr, *create_ = nullptr, *list_ = nullptr, *revoke_ = nullptr;
  std::filesystem::path data_, out_;
  StoreOptions places_;
  std::string owner_, scopes_, id_;
  double days_ = 0;
  bool data_named_ = false;  // by --data
};

}  // namespace vacuform
