// How vacuform-worker is to run. api/base/configuration.hpp says where its settings come from.
#pragma once

#include <filesystem>
#include <string>

#include "api/base/configuration.hpp"
#include "api/base/error.hpp"
#include "worker/agent/lease_loop.hpp"

namespace vacuform {

struct WorkerConfiguration {
  std::string server;                // its address
  std::filesystem::path token_file;  // empty: as find_token() looks for one
  std::string name;                  // empty until add_to(): the machine's and the process's
  std::filesystem::path work;        // empty until add_to(): a folder of this user's own for temporary files
  double poll_seconds = 1;
  double drain = 0;             // seconds for the running job after a signal
  int max_jobs = 0;             // 0: no limit
  double idle_exit = 0;         // seconds; 0: never
  std::filesystem::path cache;  // empty: cache/ in `work`
  int cache_days = 7;
  bool no_cache = false;
  std::string sandbox = "required";  // or "best-effort", "off"
  std::string user;                  // whom to become; empty: who it is

  void add_to(ConfigurationSources& sources);
  // The loop that it asks for, with the token and the program open, but without its sandbox and its folders, which are not
  // looked at. Errors: bad_usage (no address, no token), unreadable (the file of the token; `vacuform` is not beside this
  // program).
  Result<LeaseLoop> loop() const;
};

}  // namespace vacuform
