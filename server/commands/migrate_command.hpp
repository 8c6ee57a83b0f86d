// vacuform-server migrate: brings the tables of the jobs up to date without serving, as the first step of an upgrade. A
// server does the same when it starts.
#pragma once

#include <filesystem>

#include "api/base/error.hpp"
#include "server/store/store.hpp"

namespace CLI {
class App;
}

namespace vacuform {

class MigrateCommand {
 public:
  void add_to(CLI::App& app);
  bool asked() const;
  // As BackupCommand::run(). Errors: those of open_store().
  Result<void> run(const std::filesystem::path& configured_data, const StoreOptions& places) const;

 private:
  CLI::App* command_ = nullptr;
  std::filesystem::path data_;
};

}  // namespace vacuform
