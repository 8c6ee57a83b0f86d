// vacuform-server backup: a copy of a data folder, from which a server can start, while its server runs or not.
//
// The copy is made by the process that owns the store, for none but it may touch the database: the running server is asked
// over HTTP with the administrator's token; where none runs, this process opens the store itself.
#pragma once

#include <filesystem>

#include "api/error.hpp"

namespace CLI {
class App;
}

namespace vacuform {

class BackupCommand {
 public:
  void add_to(CLI::App& app);
  bool asked() const;
  // Errors: bad_usage (the folder is not empty), unavailable, internal (something was left out, being damaged).
  Result<void> run() const;

 private:
  CLI::App* command_ = nullptr;
  std::filesystem::path data_ = "vacuform-data", to_;
};

}  // namespace vacuform
