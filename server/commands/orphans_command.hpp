// vacuform-server orphans: lists or deletes the objects in the bucket that no row knows, while the server runs or not. Like
// backup, it asks a running server, and opens the store itself if no server runs.
#pragma once

#include <filesystem>

#include "api/base/error.hpp"
#include "server/store/store.hpp"

namespace CLI {
class App;
}

namespace vacuform {

class OrphansCommand {
 public:
  void add_to(CLI::App& app);
  bool asked() const;
  // As BackupCommand::run(). Errors: those of Store::orphans().
  Result<void> run(const std::filesystem::path& configured_data, const StoreOptions& places) const;

 private:
  CLI::App* command_ = nullptr;
  std::filesystem::path data_;
  OrphanSearch search_;
  double hours_ = 48;
};

}  // namespace vacuform
