// A change of settings that a refusal or a warning proposes, for people and for programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vacuform {

// A name such as "scan.units" and its value: a number, or else a word.
struct ProposedSetting {
  std::string name;
  std::optional<double> number = {};
  std::string word = {};

  ProposedSetting() = default;
  ProposedSetting(std::string setting, double value) : name(std::move(setting)), number(value) {}
  ProposedSetting(std::string setting, std::string_view value) : name(std::move(setting)), word(value) {}
};

struct Proposal {
  std::vector<ProposedSetting> set;  // applied together
  std::string text;  // what they lead to, a clause for people such as "254 mm, a child's head"; may be empty
};

// Numbers and lengths that proposals_from() accepts.
struct ProposalLimits {
  std::size_t proposals = 16, settings = 8, name = 64, value = 64, text = 300;
};
inline constexpr ProposalLimits proposal_limits;

// The options of the command line: "--set scan.units=cm".
std::string options_of(const Proposal& proposal);

// The advice, the proposals as options with their texts, and what else can be done:
// "say which: --set scan.units=cm (100 mm) or --set scan.units=in (254 mm); or ...". Each part may be empty.
std::string advice_with(const std::string& advice, std::span<const Proposal> proposals,
                        const std::string& otherwise = {});

// [{"set": {"scan": {"units": "cm"}}, "text": "100 mm"}]: `set` can be merged into settings.
nlohmann::ordered_json proposals_json(std::span<const Proposal> proposals);

// The inverse, from untrusted JSON. Nothing unless it is a list of this form within proposal_limits; null is an empty
// list.
std::optional<std::vector<Proposal>> proposals_from(const nlohmann::json& json);

}  // namespace vacuform
