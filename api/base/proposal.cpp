#include "api/base/proposal.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/base/decimal.hpp"

namespace vacuform {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

ordered_json value_json(const ProposedSetting& setting) {
  if (!setting.number) return setting.word;
  const double number = *setting.number;
  if (number == std::floor(number) && std::abs(number) < 1e9) return static_cast<std::int64_t>(number);
  return number;
}

bool is_key(const std::string& name) {
  return !name.empty() && name.size() <= proposal_limits.name && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

std::optional<ProposedSetting> setting_from(std::string name, const json& value) {
  if (value.is_number()) {
    const double number = value.get<double>();
    if (std::isfinite(number)) return ProposedSetting(std::move(name), number);
  } else if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    if (text.size() <= proposal_limits.value) return ProposedSetting(std::move(name), text);
  }
  return std::nullopt;
}

std::optional<Proposal> proposal_from(const json& object) {
  if (!object.is_object()) return std::nullopt;
  Proposal proposal;
  const auto text = object.find("text"), set = object.find("set");
  if (text != object.end()) {
    if (!text->is_string() || text->get_ref<const std::string&>().size() > proposal_limits.text)
      return std::nullopt;
    proposal.text = text->get<std::string>();
  }
  if (set == object.end() || !set->is_object() || set->empty()) return std::nullopt;
  for (const auto& [group, settings] : set->items()) {
    if (!is_key(group) || !settings.is_object()) return std::nullopt;
    for (const auto& [key, value] : settings.items()) {
      auto setting = setting_from(group + "." + key, value);
      if (!is_key(key) || !setting || proposal.set.size() == proposal_limits.settings) return std::nullopt;
      proposal.set.push_back(std::move(*setting));
    }
  }
  if (proposal.set.empty()) return std::nullopt;
  return proposal;
}

}  // namespace

std::string options_of(const Proposal& proposal) {
  std::string text;
  for (const ProposedSetting& setting : proposal.set)
    text += (text.empty() ? "--set " : " --set ") + setting.name + "=" +
            (setting.number ? short_decimal(*setting.number, 10) : setting.word);
  return text;
}

std::string advice_with(const std::string& advice, std::span<const Proposal> proposals,
                        const std::string& otherwise) {
  std::string all;
  for (std::size_t i = 0; i < proposals.size(); ++i) {
    all += i == 0 ? "" : i + 1 == proposals.size() ? " or " : ", ";
    all += options_of(proposals[i]) + (proposals[i].text.empty() ? "" : " (" + proposals[i].text + ")");
  }
  std::string text = advice;
  if (!all.empty()) text += (text.empty() ? "" : ": ") + all;
  if (!otherwise.empty()) text += (text.empty() ? "" : "; or ") + otherwise;
  return text;
}

ordered_json proposals_json(std::span<const Proposal> proposals) {
  ordered_json list = ordered_json::array();
  for (const Proposal& proposal : proposals) {
    ordered_json set = ordered_json::object();
    for (const ProposedSetting& setting : proposal.set) {
      const std::size_t dot = setting.name.find('.');
      set[setting.name.substr(0, dot)][setting.name.substr(dot + 1)] = value_json(setting);
    }
    list.push_back({{"set", std::move(set)}, {"text", proposal.text}});
  }
  return list;
}

std::optional<std::vector<Proposal>> proposals_from(const json& list) {
  std::vector<Proposal> proposals;
  if (list.is_null()) return proposals;
  if (!list.is_array() || list.size() > proposal_limits.proposals) return std::nullopt;
  for (const json& object : list) {
    auto proposal = proposal_from(object);
    if (!proposal) return std::nullopt;
    proposals.push_back(std::move(*proposal));
  }
  return proposals;
}

}  // namespace vacuform
