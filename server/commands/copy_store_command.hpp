// vacuform-server copy-store: moves all that a stopped service keeps to another place, such as from SQLite and files to
// PostgreSQL and an object store. It shows its progress on standard error; SIGINT and SIGTERM cancel it.
#pragma once

#include <filesystem>

#include "api/base/error.hpp"
#include "server/store/store.hpp"

namespace CLI {
class App;
}

namespace vacuform {

class CopyStoreCommand {
 public:
  void add_to(CLI::App& app);
  bool asked() const;
  // `configured_data` is the folder to copy where --data names none, `places` says what is kept elsewhere. Errors: those of
  // copy_store(); internal (something was left out, being damaged).
  Result<void> run(const std::filesystem::path& configured_data, const StoreOptions& places) const;

 private:
  CLI::App* command_ = nullptr;
  std::filesystem::path data_, to_;
  StoreOptions target_;
};

}  // namespace vacuform
