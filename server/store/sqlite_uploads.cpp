#include "server/store/sqlite_store.hpp"

namespace vacuform {

namespace {

constexpr Millis remembered = 7LL * 24 * 3600 * 1000;  // that there was one, after it has expired

tl::unexpected<Error> no_upload(const std::string& id) {
  return fail(Code::not_found, "there is no such upload", id, "begin it again");
}

}  // namespace

Result<void> SqliteStore::add_upload(const StoredUpload& upload) {
  return write([&]() -> Result<void> {
    VACUFORM_CHECK(room_for(upload.length));
    {
      Query held(db_, "SELECT count(*), coalesce(sum(length), 0) FROM upload WHERE owner=? AND collected=0",
                 upload.owner);
      VACUFORM_TRY(found, held.row());
      if (found && (held.integer(0) >= most_uploads ||
                    static_cast<std::uint64_t>(held.integer(1)) + upload.length > most_upload_bytes))
        return fail(Code::busy, "too many uploads, or too many bytes, are kept for this owner already", {},
                    "finish or delete some, or wait until they expire");
    }
    return Query(db_,
                 "INSERT INTO upload(id, owner, input, extension, length, created, expires)"
                 " VALUES(?,?,?,?,?,?,?)",
                 upload.id, upload.owner, upload.input, upload.extension, upload.length, upload.created,
                 upload.expires)
        .run();
  });
}

Result<StoredUpload> SqliteStore::upload_row(const std::string& id) {
  Query query(db_,
              "SELECT id, owner, input, extension, length, created, expires, blob, bytes FROM upload"
              " WHERE id=?",
              id);
  VACUFORM_TRY(found, query.row());
  if (!found) return no_upload(id);
  StoredUpload upload{query.text(0),
                      query.text(1),
                      query.text(2),
                      query.text(3),
                      static_cast<std::uint64_t>(query.integer(4)),
                      query.integer(5),
                      query.integer(6),
                      std::nullopt};
  if (upload.expires <= options_.clock())
    return fail(Code::gone, "the upload has expired", id, "begin it again");
  if (!query.null(7)) upload.blob = Blob{query.text(7), static_cast<std::uint64_t>(query.integer(8))};
  return upload;
}

Result<StoredUpload> SqliteStore::find_upload(const std::string& id) {
  const std::lock_guard hold(commits_.lock());
  return upload_row(id);
}

Result<StoredUpload> SqliteStore::finish_upload(const std::string& id, Upload file) {
  const Deletion deletion(*this);
  Stored stored(*this);
  std::variant<Upload, Blob> bytes(std::move(file));
  VACUFORM_TRY(blob, stored.add(bytes));
  auto finished = write([&]() -> Result<StoredUpload> {
    VACUFORM_CHECK(upload_row(id));
    VACUFORM_CHECK(
        Query(db_, "UPDATE upload SET blob=?, bytes=? WHERE id=?", blob.sha256, blob.bytes, id).run());
    return upload_row(id);
  });
  stored.named = finished.has_value();
  return finished;
}

Result<void> SqliteStore::remove_upload(const std::string& id) {
  const Deletion deletion(*this);
  return write([&]() -> Result<void> {
    VACUFORM_TRY(upload, upload_row(id));
    if (upload.blob) maybe_garbage(upload.blob->sha256);
    return Query(db_, "DELETE FROM upload WHERE id=?", id).run();
  });
}

Result<std::vector<std::string>> SqliteStore::expire_uploads() {
  const Deletion deletion(*this);
  return write([&]() -> Result<std::vector<std::string>> {
    const Millis now = options_.clock();
    std::vector<std::string> ids;
    {
      Query query(db_, "SELECT id, blob FROM upload WHERE collected=0 AND expires<=?", now);
      for (;;) {
        VACUFORM_TRY(more, query.row());
        if (!more) break;
        ids.push_back(query.text(0));
        if (!query.null(1)) maybe_garbage(query.text(1));
      }
    }
    if (ids.empty()) return ids;
    VACUFORM_CHECK(
        Query(db_, "UPDATE upload SET collected=1, blob=NULL WHERE collected=0 AND expires<=?", now).run());
    VACUFORM_CHECK(Query(db_, "DELETE FROM upload WHERE expires<=?", now - remembered).run());
    return ids;
  });
}

}  // namespace vacuform
