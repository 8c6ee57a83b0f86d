// What vacuform-server does for the data folder of a stopped server: verify looks at all that is stored, restore puts a
// backup in its place, adopt binds a folder and a database to each other.
#pragma once

#include <filesystem>

#include "api/base/error.hpp"
#include "server/store/store.hpp"

namespace CLI {
class App;
}

namespace vacuform {

class VerifyCommand {
 public:
  void add_to(CLI::App& app);
  bool asked() const;
  // As BackupCommand::run(). Errors: those of open_store(); internal, if something is damaged.
  Result<void> run(const std::filesystem::path& configured_data, const StoreOptions& places) const;

 private:
  CLI::App* command_ = nullptr;
  std::filesystem::path data_;
  bool read_ = false, repair_ = false;
};

class RestoreCommand {
 public:
  void add_to(CLI::App& app);
  bool asked() const;
  // Errors: those of restore_backup(); bad_usage, if the jobs or their files are not in the folder.
  Result<void> run(const std::filesystem::path& configured_data, const StoreOptions& places) const;

 private:
  CLI::App* command_ = nullptr;
  std::filesystem::path data_, from_;
};

class AdoptCommand {
 public:
  void add_to(CLI::App& app);
  bool asked() const;
  // Errors: those of open_store().
  Result<void> run(const std::filesystem::path& configured_data, const StoreOptions& places) const;

 private:
  CLI::App* command_ = nullptr;
  std::filesystem::path data_;
};

}  // namespace vacuform
