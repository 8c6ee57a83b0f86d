#include <algorithm>

#include "server/store/sql/sql_store.hpp"

namespace vacuform {

namespace {

const std::string all_profiles = "profiles";

Profile profile_of(Query& query) {
  return {query.text(0), query.text(1), query.integer(2), query.integer(3) != 0};
}

}  // namespace

Result<Profile> SqlStore::profile_row(Database& db, const std::string& name) {
  Query query(db, "SELECT name, settings, changed, is_default FROM profile WHERE name=?", name);
  VACUFORM_TRY(found, query.row());
  if (!found) return fail(Code::not_found, "there is no such profile", name, "see the list of profiles");
  return profile_of(query);
}

Result<std::optional<Profile>> SqlStore::allowed_profile(Database& db, const std::string& name,
                                                         const ProfileGuard& allowed) {
  auto row = profile_row(db, name);
  if (!row && row.error().code != Code::not_found) return tl::make_unexpected(row.error());
  const std::optional<Profile> now = row ? std::optional(std::move(*row)) : std::nullopt;
  if (allowed && !allowed(now))
    return fail(Code::conflict, "the profile has changed", name, "look at it again");
  return now;
}

Result<bool> SqlStore::put_profile(const Profile& profile, const ProfileGuard& allowed) {
  return write([&](Transaction& tx) -> Result<bool> {
    VACUFORM_CHECK(tx.db.take_turns(all_profiles));
    VACUFORM_TRY(old, allowed_profile(tx.db, profile.name, allowed));
    VACUFORM_CHECK(room_for(profile.settings.size()));
    Query count(tx.db, "SELECT count(*) FROM profile");
    VACUFORM_TRY(found, count.row());
    if (!old && found && count.integer(0) >= most_profiles)
      return fail(Code::busy, "there are " + std::to_string(most_profiles) + " profiles already",
                  profile.name, "delete some");
    VACUFORM_CHECK(
        Query(tx.db,
              "INSERT INTO profile(name, settings, changed) VALUES(?,?,?)"
              " ON CONFLICT(name) DO UPDATE SET settings=excluded.settings, changed=excluded.changed",
              profile.name, profile.settings, profile.changed)
            .run());
    return !old;
  });
}

Result<Profile> SqlStore::find_profile(const std::string& name) {
  return read([&](Database& db) -> Result<Profile> { return profile_row(db, name); });
}

Result<ProfilePage> SqlStore::list_profiles(int limit, const std::string& cursor) {
  return read([&](Database& db) -> Result<ProfilePage> {
    limit = std::clamp(limit, 1, 100);
    ProfilePage page;
    Query query(db,
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
  });
}

Result<void> SqlStore::remove_profile(const std::string& name, const ProfileGuard& allowed) {
  return write([&](Transaction& tx) -> Result<void> {
    VACUFORM_CHECK(tx.db.take_turns(all_profiles));
    VACUFORM_CHECK(allowed_profile(tx.db, name, allowed));
    VACUFORM_CHECK(profile_row(tx.db, name));
    return Query(tx.db, "DELETE FROM profile WHERE name=?", name).run();
  });
}

Result<void> SqlStore::set_default_profile(const std::string& name, bool is_default) {
  return write([&](Transaction& tx) -> Result<void> {
    VACUFORM_CHECK(tx.db.take_turns(all_profiles));
    VACUFORM_TRY(profile, profile_row(tx.db, name));
    if (profile.is_default == is_default) return {};
    return Query(tx.db,
                 "UPDATE profile SET is_default=CASE WHEN name=? THEN ? ELSE 0 END WHERE is_default=1 OR "
                 "name=?",
                 name, is_default ? 1 : 0, name)
        .run();
  });
}

}  // namespace vacuform
