// Named settings: a machine, a sheet. Everybody sees them and may take one as the base of a job's settings.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/clock.hpp"
#include "api/error.hpp"

namespace vacuform {

struct Profile {
  std::string name;      // 1 to 64 of a-z, 0-9 and '-'
  std::string settings;  // JSON text: what differs from the defaults
  Millis changed = 0;
};

struct ProfilePage {
  std::vector<Profile> profiles;    // by name
  std::optional<std::string> next;  // cursor of the page after this one
};

inline constexpr int most_profiles = 1000;

class ProfileTable {
 public:
  virtual ~ProfileTable() = default;
  // Adds it or replaces one of its name; true when it is new. Errors: busy, when there are most_profiles.
  virtual Result<bool> put_profile(const Profile& profile) = 0;
  virtual Result<Profile> find_profile(const std::string& name) = 0;  // errors: not_found
  // Those whose names come after that of the cursor.
  virtual Result<ProfilePage> list_profiles(int limit, const std::string& cursor) = 0;
  virtual Result<void> remove_profile(const std::string& name) = 0;  // errors: not_found
};

}  // namespace vacuform
