// The results of the scan and forming stages, kept in a folder under the digest of their inputs: a pattern that is
// turned, moved or changed can then be printed without forming the head again.
//
// A result is only used by the same program that wrote it (the digest of the program is part of the name), and only if
// its bytes are unchanged. A formed head identifies a person: only the owner can read the files, and the caller that
// provides the folder deletes it.
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

class StageCache {
 public:
  // Keeps nothing.
  StageCache() = default;
  // In a folder, which is created if it is absent. Above `most_bytes` the least recently used files are deleted.
  // `found` is called for every stage that need not run.
  explicit StageCache(std::filesystem::path folder, std::function<void(Stage)> found = {},
                      std::uint64_t most_bytes = 2'000'000'000);

  // `made_from` is everything that the result depends on. Returns nothing if the result is missing or damaged.
  std::optional<Mold> mold(const nlohmann::ordered_json& made_from) const;
  std::optional<FormedSheet> sheet(const nlohmann::ordered_json& made_from) const;

  // Writes a file next to its final path and renames it. A result that cannot be written is not kept; this is no error.
  void store(const nlohmann::ordered_json& made_from, const Mold& mold) const;
  void store(const nlohmann::ordered_json& made_from, const FormedSheet& sheet) const;

 private:
  std::filesystem::path path(const char* stage, const nlohmann::ordered_json& made_from) const;
  void make_room() const;

  std::optional<std::filesystem::path> folder_;
  std::function<void(Stage)> found_;
  std::uint64_t most_bytes_ = 0;
};

}  // namespace vacuform
