// Named settings: a machine, a sheet. Every user sees them and may use one as the base of a job's settings.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "api/base/clock.hpp"
#include "api/base/error.hpp"

namespace vacuform {

struct Profile {
  std::string name;      // 1 to 64 of a-z, 0-9 and '-'
  std::string settings;  // JSON text: the differences from the defaults
  Millis changed = 0;
  bool is_default = false;  // new prints begin with it; at most one
};

struct ProfilePage {
  std::vector<Profile> profiles;    // by name
  std::optional<std::string> next;  // cursor of the page after this one
};

inline constexpr int most_profiles = 1000;

// Gets the profile in its state at the change, nullopt if it does not exist, and may refuse with false. May be called
// twice.
using ProfileGuard = std::function<bool(const std::optional<Profile>& now)>;

class ProfileTable {
 public:
  virtual ~ProfileTable() = default;
  // Adds it or replaces the one of its name, which stays the default if it was; true if it is new. Errors: busy, if
  // there are most_profiles; conflict, if the guard refused; disk_full.
  virtual Result<bool> put_profile(const Profile& profile, const ProfileGuard& allowed = {}) = 0;
  virtual Result<Profile> find_profile(const std::string& name) = 0;  // errors: not_found
  // Profiles whose names come after that of the cursor.
  virtual Result<ProfilePage> list_profiles(int limit, const std::string& cursor) = 0;
  // Errors: not_found; conflict, if the guard refused.
  virtual Result<void> remove_profile(const std::string& name, const ProfileGuard& allowed = {}) = 0;
  // Makes it the default instead of any other, or no longer the default. Errors: not_found.
  virtual Result<void> set_default_profile(const std::string& name, bool is_default) = 0;
};

}  // namespace vacuform
