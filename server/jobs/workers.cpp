#include "server/jobs/workers.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "api/sandbox_measures.hpp"

namespace vacuform {

namespace {

constexpr std::size_t most = 256;
constexpr Millis lately_ms = 10 * 60 * 1000;

}  // namespace

nlohmann::ordered_json sandbox_json(const SeenWorker& worker) {
  nlohmann::ordered_json lacks = nlohmann::ordered_json::array();
  for (const std::string_view measure : sandbox_measures)
    if (std::find(worker.sandbox.begin(), worker.sandbox.end(), measure) == worker.sandbox.end())
      lacks.push_back(measure);
  return {{"sandbox", worker.sandbox}, {"lacks", std::move(lacks)}};
}

void Workers::seen(const std::string& name, const std::vector<std::string>& sandbox, Millis now) {
  Entry entry{{}, now};
  for (const std::string_view measure : sandbox_measures)
    if (std::find(sandbox.begin(), sandbox.end(), measure) != sandbox.end())
      entry.sandbox.emplace_back(measure);
  const std::lock_guard hold(mutex_);
  workers_[name] = std::move(entry);
  if (workers_.size() > most)
    workers_.erase(std::min_element(workers_.begin(), workers_.end(),
                                    [](const auto& a, const auto& b) { return a.second.at < b.second.at; }));
}

std::vector<SeenWorker> Workers::lately(Millis now) const {
  const std::lock_guard hold(mutex_);
  std::vector<SeenWorker> found;
  for (const auto& [name, entry] : workers_)
    if (now - entry.at < lately_ms) found.push_back({name, entry.sandbox, entry.at});
  return found;
}

}  // namespace vacuform
