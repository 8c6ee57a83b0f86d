// What the local workers keep of scans, in one subfolder a scan, as the server sees it: it goes with the scan itself.
#pragma once

#include <filesystem>
#include <string>

#include "server/store/store.hpp"

namespace vacuform {

class KeptFolder {
 public:
  explicit KeptFolder(const std::filesystem::path& data) : path_(std::filesystem::absolute(data / "kept")) {}

  const std::filesystem::path& path() const { return path_; }
  void forget(const std::string& sha256) const;
  // Forgets all that the store no longer holds: a crash may have come between a scan's end and that of what was kept of it.
  void sweep(Store& store) const;

 private:
  std::filesystem::path path_;
};

}  // namespace vacuform
