// vacuform-server backup: a copy of a data folder, from which a server can start, while its server runs or not.
//
// The copy is made by the process that owns the store, for none but it may touch the database: the running server is asked
// over HTTP with the administrator's token; where none runs, this process opens the store itself.
#pragma once

#include <filesystem>

#include "api/base/error.hpp"
#include "server/store/store.hpp"

namespace CLI {
class App;
}

namespace vacuform {

class BackupCommand {
 public:
  void add_to(CLI::App& app);
  bool asked() const;
  // `configured_data` is the folder of the jobs where --data names none, `places` says what is kept elsewhere. Errors:
  // bad_usage (the folder is not empty), unavailable, internal (something was left out, being damaged).
  Result<void> run(const std::filesystem::path& configured_data, const StoreOptions& places) const;

 private:
  CLI::App* command_ = nullptr;
  std::filesystem::path data_, to_;
};

}  // namespace vacuform
