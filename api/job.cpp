#include "api/job.hpp"

#include <algorithm>

namespace vacuform {

namespace {
template <class E, std::size_t N>
std::optional<E> from_name(const std::array<std::string_view, N>& names, std::string_view wanted) {
  const auto it = std::find(names.begin(), names.end(), wanted);
  if (it == names.end()) return std::nullopt;
  return static_cast<E>(it - names.begin());
}
}  // namespace

std::optional<JobKind> job_kind_from(std::string_view name) {
  return from_name<JobKind>(job_kind_names, name);
}
std::optional<Stage> stage_from(std::string_view name) { return from_name<Stage>(stage_names, name); }
std::optional<JobState> job_state_from(std::string_view name) {
  return from_name<JobState>(job_state_names, name);
}

const InputKind* input_kind(std::string_view name) {
  for (const InputKind& kind : input_kinds)
    if (kind.name == name) return &kind;
  return nullptr;
}

const ArtifactKind* artifact_kind(std::string_view name) {
  for (const ArtifactKind& kind : artifact_kinds)
    if (kind.name == name) return &kind;
  return nullptr;
}

}  // namespace vacuform
