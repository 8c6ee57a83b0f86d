// What the scan and forming stages made, kept in a folder under the digest of what they made it from: a pattern that
// is turned, moved or changed then prints without forming the head again.
//
// A result is only used by the very program that wrote it (its own digest is part of the name), and only when its
// bytes are those that were written. A formed head identifies a person: files are made readable by their owner alone,
// and whoever gives the folder deletes it.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "api/job.hpp"
#include "worker/forming/formed_sheet.hpp"
#include "worker/scan/mold.hpp"

namespace vacuform {

class KeptStages {
 public:
  // Keeps nothing.
  KeptStages() = default;
  // In a folder, which is made when it is absent. Beyond `most_bytes` the files used longest ago are deleted.
  // `found` hears of every stage that need not be run.
  explicit KeptStages(std::filesystem::path folder, std::function<void(Stage)> found = {},
                      std::uint64_t most_bytes = 2'000'000'000);

  // `made_from` is everything that the result depends on. None: not there, or not whole.
  std::optional<Mold> mold(const nlohmann::ordered_json& made_from) const;
  std::optional<FormedSheet> sheet(const nlohmann::ordered_json& made_from) const;

  // A file is written beside its place and renamed. What cannot be written is not kept, and nothing else happens.
  void keep(const nlohmann::ordered_json& made_from, const Mold& mold) const;
  void keep(const nlohmann::ordered_json& made_from, const FormedSheet& sheet) const;

 private:
  std::filesystem::path path(const char* stage, const nlohmann::ordered_json& made_from) const;
  void make_room() const;

  std::optional<std::filesystem::path> folder_;
  std::function<void(Stage)> found_;
  std::uint64_t most_bytes_ = 0;
};

}  // namespace vacuform
