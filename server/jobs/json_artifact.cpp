#include "server/jobs/json_artifact.hpp"

#include <nlohmann/json.hpp>

#include "api/base/json_text.hpp"

namespace vacuform {

using nlohmann::ordered_json;

namespace {

constexpr std::uint64_t largest = 4 << 20;

}  // namespace

ordered_json json_artifact(Store& store, const Job& job, std::string_view name) {
  for (const auto& artifact : job.artifacts) {
    if (artifact.name != name || artifact.blob.bytes > largest) continue;
    const auto reader = store.open(artifact.blob);
    std::string text(artifact.blob.bytes, '\0');
    if (!reader || (*reader)->read_at(0, text).value_or(0) != text.size()) return nullptr;
    if (!within(text, {})) return nullptr;
    auto value = ordered_json::parse(text, nullptr, false);
    return value.is_object() ? value : ordered_json();
  }
  return nullptr;
}

}  // namespace vacuform
