#include "server/store/job.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

namespace vacuform {

const Input* Job::input(std::string_view name) const {
  const auto found =
      std::find_if(inputs.begin(), inputs.end(), [&](const Input& i) { return i.name == name; });
  return found == inputs.end() ? nullptr : &*found;
}

std::string reference_at(const Job& job, Millis time) {
  if (job.reference_changes.empty()) return job.reference;
  for (const auto& change : nlohmann::json::parse(job.reference_changes))
    if (change["time"].get<Millis>() >= time) return change["old"];
  return job.reference;
}

std::string first_reference(const Job& job) { return reference_at(job, std::numeric_limits<Millis>::min()); }

void sort_inputs(std::vector<Input>& inputs) {
  std::sort(inputs.begin(), inputs.end(), [](const Input& a, const Input& b) {
    return input_kind(a.name) < input_kind(b.name);  // index in one table
  });
}

void NewJob::add(std::string name, std::variant<Upload, Blob> file, std::string extension) {
  inputs.push_back({std::move(name), std::move(file), std::move(extension)});
}

}  // namespace vacuform
