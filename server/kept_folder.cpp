#include "server/kept_folder.hpp"

#include <vector>

namespace vacuform {

namespace fs = std::filesystem;

void KeptFolder::forget(const std::string& sha256) const {
  std::error_code ignored;
  fs::remove_all(path_ / sha256, ignored);
}

void KeptFolder::sweep(Store& store) const {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(path_, error), end; !error && it != end; it.increment(error))
    names.push_back(it->path().filename().string());
  for (const std::string& name : names)
    if (!store.holds(name).value_or(true)) forget(name);
}

}  // namespace vacuform
