// vacuform-server token create|list|revoke: tokens from the command line, for whoever may read the data folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "api/base/error.hpp"

namespace CLI {
class App;
}

namespace vacuform {

// Opens the store where no server has it open, and asks the running server otherwise, with the administrator's token
// that it left in the data folder. A new token is printed once, or written into a file for its owner alone.
class TokenCommand {
 public:
  void add_to(CLI::App& app);
  bool asked() const;
  // `configured_data` is the folder of the jobs where --data names none. Errors: bad_usage, not_found, unauthorized (the
  // administrator's token is gone or was revoked), those of the store.
  Result<void> run(const std::filesystem::path& configured_data);

 private:
  Result<void> create() const;
  Result<void> list() const;
  Result<void> revoke() const;

  CLI::App *token_ = nullptr, *create_ = nullptr, *list_ = nullptr, *revoke_ = nullptr;
  std::filesystem::path data_, out_;
  std::string owner_, scopes_, id_;
  double days_ = 0;
  bool data_named_ = false;  // by --data
};

}  // namespace vacuform
