#include "server/store/sqlite_store.hpp"

namespace vacuform {

Result<Token> SqliteStore::find_token(const std::string& id) {
  Query query(db_, "SELECT id, owner, scopes, hash, created, expires, revoked, file FROM token WHERE id=?",
              id);
  VACUFORM_TRY(found, query.row());
  if (!found) return fail(Code::not_found, "there is no such token", id, "see the list of tokens");
  Token token{query.text(0), query.text(1),    Scopes::from(query.text(2)).value_or(Scopes()),
              query.text(3), query.integer(4), std::nullopt,
              std::nullopt,  query.text(7)};
  if (!query.null(5)) token.expires = query.integer(5);
  if (!query.null(6)) token.revoked = query.integer(6);
  return token;
}

Result<void> SqliteStore::add_token(const Token& token) {
  return write([&]() -> Result<void> {
    if (find_token(token.id)) return fail(Code::conflict, "there is a token of this id", token.id);
    return Query(db_,
                 "INSERT INTO token(id, owner, scopes, hash, created, expires, revoked, file)"
                 " VALUES(?,?,?,?,?,?,?,?)",
                 token.id, token.owner, token.scopes.text(), token.hash, token.created, token.expires,
                 token.revoked, token.file.empty() ? std::nullopt : std::optional(token.file))
        .run();
  });
}

Result<Token> SqliteStore::token(const std::string& id) {
  const std::lock_guard hold(commits_.lock());
  return find_token(id);
}

Result<std::vector<Token>> SqliteStore::tokens() {
  const std::lock_guard hold(commits_.lock());
  std::vector<std::string> ids;
  {
    Query query(db_, "SELECT id FROM token ORDER BY created, id");
    for (;;) {
      VACUFORM_TRY(more, query.row());
      if (!more) break;
      ids.push_back(query.text(0));
    }
  }
  std::vector<Token> found;
  for (const auto& id : ids) {
    VACUFORM_TRY(token, find_token(id));
    found.push_back(std::move(token));
  }
  return found;
}

Result<void> SqliteStore::revoke_token(const std::string& id) {
  return write([&]() -> Result<void> {
    VACUFORM_CHECK(find_token(id));
    return Query(db_, "UPDATE token SET revoked=coalesce(revoked, ?) WHERE id=?", options_.clock(), id).run();
  });
}

}  // namespace vacuform
