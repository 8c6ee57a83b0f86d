// The workers that have asked for a job lately, and the sandbox that their jobs run in, as they say it.
#pragma once

#include <map>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "api/base/clock.hpp"

namespace vacuform {

struct SeenWorker {
  std::string name;
  std::vector<std::string> sandbox;  // measures that are taken
  Millis at = 0;                     // when it asked last
};

// {sandbox: the measures that are taken, lacks: the others}.
nlohmann::ordered_json sandbox_json(const SeenWorker& worker);

// From any thread. Holds 256 names at most: those that were heard of last.
class Workers {
 public:
  // Only measures that we know are noted.
  void seen(const std::string& name, const std::vector<std::string>& sandbox, Millis now);
  // Those of the last ten minutes, by name.
  std::vector<SeenWorker> lately(Millis now) const;

 private:
  struct Entry {
    std::vector<std::string> sandbox;
    Millis at = 0;
  };
  mutable std::mutex mutex_;
  std::map<std::string, Entry> workers_;
};

}  // namespace vacuform
