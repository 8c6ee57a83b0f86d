// The rows of objects in an object store.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/base/log.hpp"
#include "server/store/sql/sql_store.hpp"

namespace vacuform {

namespace {

constexpr std::string_view bucket_number = "bucket";

#define VACUFORM_UNNAMED                                          \
  " AND NOT EXISTS(SELECT 1 FROM input WHERE blob=sha256)"        \
  " AND NOT EXISTS(SELECT 1 FROM artifact WHERE blob=sha256)"     \
  " AND NOT EXISTS(SELECT 1 FROM upload WHERE blob=sha256)"       \
  " AND NOT EXISTS(SELECT 1 FROM upload_piece WHERE blob=sha256)" \
  " AND NOT EXISTS(SELECT 1 FROM scan WHERE blob=sha256)"

constexpr const char* unnamed_of_five =
    "SELECT sha256 FROM (SELECT ?1 AS sha256 UNION ALL SELECT ?2 UNION ALL SELECT ?3 UNION ALL SELECT ?4"
    " UNION ALL SELECT ?5) AS asked WHERE sha256<>''" VACUFORM_UNNAMED;

std::string shared_hash(std::span<const NewInput> inputs, std::size_t i) {
  const Blob* blob = i < inputs.size() ? std::get_if<Blob>(&inputs[i].file) : nullptr;
  return blob ? blob->sha256 : std::string();
}

}  // namespace

SqlStore::SharedBlobs::SharedBlobs(Database& db, std::span<const NewInput> inputs)
    : inputs_(inputs),
      unnamed_(db, unnamed_of_five, shared_hash(inputs, 0), shared_hash(inputs, 1), shared_hash(inputs, 2),
               shared_hash(inputs, 3), shared_hash(inputs, 4)) {
  static_assert(input_kinds.size() == 5);
  unnamed_.send();
}

Result<void> SqlStore::SharedBlobs::check() {
  VACUFORM_TRY(some, unnamed_.row());
  if (!some) return {};
  const auto gone = std::find_if(inputs_.begin(), inputs_.end(), [&](const NewInput& input) {
    const Blob* blob = std::get_if<Blob>(&input.file);
    return blob && blob->sha256 == unnamed_.text(0);
  });
  return fail(Code::gone, "the file was deleted in the meantime",
              gone == inputs_.end() ? std::string() : gone->name, "send it again");
}

Result<std::optional<StoredObject>> SqlStore::live_object(const std::string& sha256) {
  return read([&](Database& db) -> Result<std::optional<StoredObject>> {
    Query query(db, "SELECT generation, bytes FROM stored_object WHERE sha256=? AND state='live'", sha256);
    VACUFORM_TRY(found, query.row());
    if (!found) return std::nullopt;
    return StoredObject{sha256, query.text(0), static_cast<std::uint64_t>(query.integer(1))};
  });
}

Result<void> SqlStore::add_uploading(const StoredObject& object) {
  return write([&](Transaction& tx) {
    return Query(tx.db,
                 "INSERT INTO stored_object(sha256, generation, bytes, state, since)"
                 " VALUES(?,?,?,'uploading',?)",
                 object.sha256, object.generation, object.bytes, options_.clock())
        .run();
  });
}

Result<void> SqlStore::object_arrived(const StoredObject& object) {
  return write([&](Transaction& tx) -> Result<void> {
    VACUFORM_CHECK(tx.db.take_turns("object " + object.sha256));
    VACUFORM_CHECK(Query(tx.db,
                         "UPDATE stored_object SET state='deleting', since=? WHERE sha256=? AND state='live'",
                         options_.clock(), object.sha256)
                       .run());
    return Query(tx.db,
                 "UPDATE stored_object SET state='live', since=? WHERE sha256=? AND generation=?"
                 " AND state='uploading'",
                 options_.clock(), object.sha256, object.generation)
        .run();
  });
}

Result<void> SqlStore::mark_for_deletion(const StoredObject& object) {
  return write([&](Transaction& tx) {
    return Query(tx.db, "UPDATE stored_object SET state='deleting', since=? WHERE sha256=? AND generation=?",
                 options_.clock(), object.sha256, object.generation)
        .run();
  });
}

Result<void> SqlStore::mark_if_unnamed(const std::string& sha256) {
  return write([&](Transaction& tx) -> Result<void> {
    VACUFORM_CHECK(tx.db.take_turns("object " + sha256));
    return Query(tx.db,
                 "UPDATE stored_object SET state='deleting', since=? WHERE sha256=? AND "
                 "state='live'" VACUFORM_UNNAMED,
                 options_.clock(), sha256)
        .run();
  });
}

// One at a time: a transaction that takes turns for many objects would wait for all requests.
Result<void> SqlStore::mark_unnamed(Millis age) {
  const Millis until = options_.clock() - age;
  auto unnamed = read([&](Database& db) -> Result<std::vector<std::string>> {
    std::vector<std::string> hashes;
    Query query(db, "SELECT sha256 FROM stored_object WHERE state='live' AND since<=?" VACUFORM_UNNAMED,
                until);
    for (;;) {
      VACUFORM_TRY(more, query.row());
      if (!more) return hashes;
      hashes.push_back(query.text(0));
    }
  });
  if (!unnamed) return tl::make_unexpected(std::move(unnamed.error()));
  auto live = read([](Database& db) -> Result<std::int64_t> {
    Query query(db, "SELECT count(*) FROM stored_object WHERE state='live'");
    VACUFORM_CHECK(query.row());
    return query.integer(0);
  });
  if (!live) return tl::make_unexpected(std::move(live.error()));
  if (!BlobStore::left_by_a_crash(unnamed->size(), static_cast<std::size_t>(*live)))
    log_event("files-without-job", {{"files", unnamed->size()}, {"too_many_to_move", true}});
  else
    for (const std::string& sha256 : *unnamed) VACUFORM_CHECK(mark_if_unnamed(sha256));
  return write([&](Transaction& tx) {
    return Query(tx.db,
                 "UPDATE stored_object SET state='deleting', since=? WHERE state='uploading' AND since<=?",
                 options_.clock(), until)
        .run();
  });
}

Result<void> SqlStore::hold_objects(Database& db, std::vector<std::string> hashes) {
  if (!blobs_->shared()) return {};
  std::sort(hashes.begin(), hashes.end());  // in one order, so that no two transactions wait for each other
  for (const std::string& sha256 : hashes) {
    VACUFORM_CHECK(db.take_turns("object " + sha256));
    Query query(db, "SELECT 1 FROM stored_object WHERE sha256=? AND state='live'", sha256);
    VACUFORM_TRY(live, query.row());
    if (!live)
      return fail(Code::unavailable, "another server has just deleted a file of this request", {},
                  "send the request again");
  }
  return {};
}

Result<std::vector<StoredObject>> SqlStore::marked_until(Millis time, int limit) {
  return read([&](Database& db) -> Result<std::vector<StoredObject>> {
    std::vector<StoredObject> objects;
    Query query(db,
                "SELECT sha256, generation, bytes FROM stored_object WHERE state='deleting' AND since<=?"
                " ORDER BY since LIMIT ?",
                time, limit);
    for (;;) {
      VACUFORM_TRY(more, query.row());
      if (!more) return objects;
      objects.push_back({query.text(0), query.text(1), static_cast<std::uint64_t>(query.integer(2))});
    }
  });
}

Result<void> SqlStore::forget(const StoredObject& object) {
  return write([&](Transaction& tx) {
    return Query(tx.db, "DELETE FROM stored_object WHERE sha256=? AND generation=?", object.sha256,
                 object.generation)
        .run();
  });
}

Result<ObjectTable::Bucket> SqlStore::bucket() {
  return read([&](Database& db) -> Result<Bucket> {
    Bucket bucket;
    Query number(db, "SELECT value FROM remembered WHERE name=?", bucket_number);
    VACUFORM_TRY(found, number.row());
    if (found) bucket.number = number.integer(0);
    Query rows(db,
               "SELECT CASE WHEN EXISTS(SELECT 1 FROM input) OR EXISTS(SELECT 1 FROM artifact)"
               " OR EXISTS(SELECT 1 FROM scan) OR EXISTS(SELECT 1 FROM upload WHERE blob IS NOT NULL)"
               " THEN 1 ELSE 0 END, CASE WHEN EXISTS(SELECT 1 FROM stored_object) THEN 1 ELSE 0 END");
    VACUFORM_CHECK(rows.row());
    bucket.named_blobs = rows.integer(0) != 0;
    bucket.objects = rows.integer(1) != 0;
    return bucket;
  });
}

Result<void> SqlStore::remember_bucket(std::int64_t number) {
  return write([&](Transaction& tx) {
    return Query(tx.db, "INSERT INTO remembered(name, value) VALUES(?,?)", bucket_number, number).run();
  });
}

#undef VACUFORM_UNNAMED

}  // namespace vacuform
