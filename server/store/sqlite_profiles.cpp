#include <algorithm>

#include "server/store/sqlite_store.hpp"

namespace vacuform {

namespace {

Profile profile_of(Query& query) {
  return {query.text(0), query.text(1), query.integer(2), query.integer(3) != 0};
}

}  // namespace

Result<Profile> SqliteStore::profile_row(const std::string& name) {
  Query query(db_, "SELECT name, settings, changed, is_default FROM profile WHERE name=?", name);
  VACUFORM_TRY(found, query.row());
  if (!found) return fail(Code::not_found, "there is no such profile", name, "see the list of profiles");
  return profile_of(query);
}

Result<std::optional<Profile>> SqliteStore::allowed_profile(const std::string& name,
                                                            const ProfileGuard& allowed) {
  auto row = profile_row(name);
  if (!row && row.error().code != Code::not_found) return tl::make_unexpected(row.error());
  const std::optional<Profile> now = row ? std::optional(std::move(*row)) : std::nullopt;
  if (allowed && !allowed(now))
    return fail(Code::conflict, "the profile has changed", name, "look at it again");
  return now;
}

Result<bool> SqliteStore::put_profile(const Profile& profile, const ProfileGuard& allowed) {
  return write([&]() -> Result<bool> {
    VACUFORM_TRY(old, allowed_profile(profile.name, allowed));
    VACUFORM_CHECK(room_for(profile.settings.size()));
    Query count(db_, "SELECT count(*) FROM profile");
    VACUFORM_TRY(found, count.row());
    if (!old && found && count.integer(0) >= most_profiles)
      return fail(Code::busy, "there are " + std::to_string(most_profiles) + " profiles already",
                  profile.name, "delete some");
    VACUFORM_CHECK(
        Query(db_,
              "INSERT INTO profile(name, settings, changed) VALUES(?,?,?)"
              " ON CONFLICT(name) DO UPDATE SET settings=excluded.settings, changed=excluded.changed",
              profile.name, profile.settings, profile.changed)
            .run());
    return !old;
  });
}

Result<Profile> SqliteStore::find_profile(const std::string& name) {
  const std::lock_guard hold(commits_.lock());
  return profile_row(name);
}

Result<ProfilePage> SqliteStore::list_profiles(int limit, const std::string& cursor) {
  const std::lock_guard hold(commits_.lock());
  limit = std::clamp(limit, 1, 100);
  ProfilePage page;
  Query query(db_,
              "SELECT name, settings, changed, is_default FROM profile WHERE name>? ORDER BY name LIMIT ?",
              cursor, limit + 1);
  for (;;) {
    VACUFORM_TRY(more, query.row());
    if (!more) break;
    page.profiles.push_back(profile_of(query));
  }
  if (page.profiles.size() > static_cast<std::size_t>(limit)) {
    page.profiles.pop_back();
    page.next = page.profiles.back().name;
  }
  return page;
}

Result<void> SqliteStore::remove_profile(const std::string& name, const ProfileGuard& allowed) {
  return write([&]() -> Result<void> {
    VACUFORM_CHECK(allowed_profile(name, allowed));
    VACUFORM_CHECK(profile_row(name));
    return Query(db_, "DELETE FROM profile WHERE name=?", name).run();
  });
}

Result<void> SqliteStore::set_default_profile(const std::string& name, bool is_default) {
  return write([&]() -> Result<void> {
    VACUFORM_TRY(profile, profile_row(name));
    if (profile.is_default == is_default) return {};
    return Query(db_, "UPDATE profile SET is_default=(name=? AND ?) WHERE is_default=1 OR name=?", name,
                 is_default ? 1 : 0, name)
        .run();
  });
}

}  // namespace vacuform
