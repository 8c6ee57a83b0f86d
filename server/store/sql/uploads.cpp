#include "server/store/sql/sql_store.hpp"

namespace vacuform {

namespace {

constexpr Millis remembered = 7LL * 24 * 3600 * 1000;  // that there was one, after it has expired

tl::unexpected<Error> no_upload(const std::string& id) {
  return fail(Code::not_found, "there is no such upload", id, "begin it again");
}

}  // namespace

Result<void> SqlStore::add_upload(const StoredUpload& upload) {
  return write([&](Transaction& tx) -> Result<void> {
    VACUFORM_CHECK(room_for(upload.length));
    VACUFORM_CHECK(tx.db.take_turns("uploads of " + upload.owner));
    {
      Query held(tx.db, "SELECT count(*), coalesce(sum(length), 0) FROM upload WHERE owner=? AND collected=0",
                 upload.owner);
      VACUFORM_TRY(found, held.row());
      if (found && (held.integer(0) >= most_uploads ||
                    static_cast<std::uint64_t>(held.integer(1)) + upload.length > most_upload_bytes))
        return fail(Code::busy, "too many uploads, or too many bytes, are kept for this owner already", {},
                    "finish or delete some, or wait until they expire");
    }
    return Query(tx.db,
                 "INSERT INTO upload(id, owner, input, extension, key, length, created, expires)"
                 " VALUES(?,?,?,?,?,?,?,?)",
                 upload.id, upload.owner, upload.input, upload.extension, upload.key, upload.length,
                 upload.created, upload.expires)
        .run();
  });
}

Result<StoredUpload> SqlStore::upload_row(Database& db, const std::string& id) {
  Query query(db,
              "SELECT id, owner, input, extension, key, length, created, expires, blob, bytes, received,"
              " (SELECT count(*) FROM upload_piece WHERE upload=upload.id) FROM upload WHERE id=?",
              id);
  VACUFORM_TRY(found, query.row());
  if (!found) return no_upload(id);
  StoredUpload upload{.id = query.text(0),
                      .owner = query.text(1),
                      .input = query.text(2),
                      .extension = query.text(3),
                      .key = query.text(4),
                      .length = static_cast<std::uint64_t>(query.integer(5)),
                      .created = query.integer(6),
                      .expires = query.integer(7)};
  if (upload.expires <= options_.clock())
    return fail(Code::gone, "the upload has expired", id, "begin it again");
  if (!query.null(8)) upload.blob = Blob{query.text(8), static_cast<std::uint64_t>(query.integer(9))};
  upload.received = static_cast<std::uint64_t>(query.integer(10));
  upload.pieces = static_cast<int>(query.integer(11));
  return upload;
}

// Forgets the pieces of an upload that needs them no more.
Result<void> SqlStore::drop_pieces(Transaction& tx, const std::string& id) {
  {
    Query query(tx.db, "SELECT blob FROM upload_piece WHERE upload=?", id);
    for (;;) {
      VACUFORM_TRY(more, query.row());
      if (!more) break;
      tx.garbage.push_back(query.text(0));
    }
  }
  return Query(tx.db, "DELETE FROM upload_piece WHERE upload=?", id).run();
}

Result<void> SqlStore::add_piece(const std::string& id, int number, Upload piece, std::uint64_t received) {
  const Deletion deletion(*this);
  Stored stored(*this);
  std::variant<Upload, Blob> bytes(std::move(piece));
  VACUFORM_TRY(blob, stored.add(bytes));
  const auto added = write([&](Transaction& tx) -> Result<void> {
    VACUFORM_CHECK(tx.db.take_turns("upload " + id));
    VACUFORM_TRY(upload, upload_row(tx.db, id));
    if (upload.blob || upload.pieces != number)
      return fail(Code::locked, "another request is sending bytes of this upload", id,
                  "try again when it has ended");
    VACUFORM_CHECK(hold_objects(tx.db, {blob.sha256}));
    VACUFORM_CHECK(Query(tx.db, "INSERT INTO upload_piece(upload, number, blob, bytes) VALUES(?,?,?,?)", id,
                         number, blob.sha256, blob.bytes)
                       .run());
    return Query(tx.db, "UPDATE upload SET received=? WHERE id=?", received, id).run();
  });
  stored.written(added);
  return added;
}

Result<std::vector<Blob>> SqlStore::pieces(const std::string& id) {
  return read([&](Database& db) -> Result<std::vector<Blob>> {
    std::vector<Blob> pieces;
    Query query(db, "SELECT blob, bytes FROM upload_piece WHERE upload=? ORDER BY number", id);
    for (;;) {
      VACUFORM_TRY(more, query.row());
      if (!more) return pieces;
      pieces.push_back({query.text(0), static_cast<std::uint64_t>(query.integer(1))});
    }
  });
}

Result<StoredUpload> SqlStore::find_upload(const std::string& id) {
  return read([&](Database& db) -> Result<StoredUpload> { return upload_row(db, id); });
}

Result<StoredUpload> SqlStore::finish_upload(const std::string& id, Upload file) {
  const Deletion deletion(*this);
  Stored stored(*this);
  std::variant<Upload, Blob> bytes(std::move(file));
  VACUFORM_TRY(blob, stored.add(bytes));
  auto finished = write([&](Transaction& tx) -> Result<StoredUpload> {
    VACUFORM_CHECK(tx.db.take_turns("upload " + id));
    VACUFORM_CHECK(upload_row(tx.db, id));
    VACUFORM_CHECK(drop_pieces(tx, id));
    VACUFORM_CHECK(hold_objects(tx.db, {blob.sha256}));
    VACUFORM_CHECK(
        Query(tx.db, "UPDATE upload SET blob=?, bytes=?, key='' WHERE id=?", blob.sha256, blob.bytes, id)
            .run());
    return upload_row(tx.db, id);
  });
  stored.written(finished);
  return finished;
}

Result<void> SqlStore::remove_upload(const std::string& id) {
  const Deletion deletion(*this);
  return write([&](Transaction& tx) -> Result<void> {
    VACUFORM_TRY(upload, upload_row(tx.db, id));
    if (upload.blob) tx.garbage.push_back(upload.blob->sha256);
    VACUFORM_CHECK(drop_pieces(tx, id));
    return Query(tx.db, "DELETE FROM upload WHERE id=?", id).run();
  });
}

Result<std::vector<std::string>> SqlStore::expire_uploads() {
  const Deletion deletion(*this);
  return write([&](Transaction& tx) -> Result<std::vector<std::string>> {
    const Millis now = options_.clock();
    std::vector<std::string> ids;
    {
      Query query(tx.db, "SELECT id, blob FROM upload WHERE collected=0 AND expires<=?", now);
      for (;;) {
        VACUFORM_TRY(more, query.row());
        if (!more) break;
        ids.push_back(query.text(0));
        if (!query.null(1)) tx.garbage.push_back(query.text(1));
      }
    }
    if (ids.empty()) return ids;
    for (const std::string& id : ids) VACUFORM_CHECK(drop_pieces(tx, id));
    VACUFORM_CHECK(
        Query(tx.db, "UPDATE upload SET collected=1, blob=NULL, key='' WHERE collected=0 AND expires<=?", now)
            .run());
    VACUFORM_CHECK(Query(tx.db, "DELETE FROM upload WHERE expires<=?", now - remembered).run());
    return ids;
  });
}

}  // namespace vacuform
