#include "server/store/sql/sql_store.hpp"

namespace vacuform {

Token SqlStore::token_in(const Query& row) {
  Token token{row.text(0),  row.text(1),    Scopes::from(row.text(2)).value_or(Scopes()),
              row.text(3),  row.integer(4), std::nullopt,
              std::nullopt, row.text(7)};
  if (!row.null(5)) token.expires = row.integer(5);
  if (!row.null(6)) token.revoked = row.integer(6);
  return token;
}

Result<Token> SqlStore::token_row(Database& db, const std::string& id) {
  Query query(db, "SELECT id, owner, scopes, hash, created, expires, revoked, file FROM token WHERE id=?",
              id);
  VACUFORM_TRY(found, query.row());
  if (!found) return fail(Code::not_found, "there is no such token", id, "see the list of tokens");
  return token_in(query);
}

Result<void> SqlStore::add_token(const Token& token) {
  return write([&](Transaction& tx) -> Result<void> {
    if (token_row(tx.db, token.id)) return fail(Code::conflict, "there is a token of this id", token.id);
    return Query(tx.db,
                 "INSERT INTO token(id, owner, scopes, hash, created, expires, revoked, file)"
                 " VALUES(?,?,?,?,?,?,?,?)",
                 token.id, token.owner, token.scopes.text(), token.hash, token.created, token.expires,
                 token.revoked, token.file.empty() ? std::nullopt : std::optional(token.file))
        .run();
  });
}

Result<Token> SqlStore::token(const std::string& id) {
  return read([&](Database& db) -> Result<Token> { return token_row(db, id); });
}

Result<std::vector<Token>> SqlStore::tokens() {
  return read([&](Database& db) -> Result<std::vector<Token>> {
    std::vector<std::string> ids;
    {
      Query query(db, "SELECT id FROM token ORDER BY created, id");
      for (;;) {
        VACUFORM_TRY(more, query.row());
        if (!more) break;
        ids.push_back(query.text(0));
      }
    }
    std::vector<Token> found;
    for (const auto& id : ids) {
      VACUFORM_TRY(token, token_row(db, id));
      found.push_back(std::move(token));
    }
    return found;
  });
}

Result<void> SqlStore::revoke_token(const std::string& id) {
  return write([&](Transaction& tx) -> Result<void> {
    VACUFORM_CHECK(token_row(tx.db, id));
    return Query(tx.db, "UPDATE token SET revoked=coalesce(revoked, ?) WHERE id=?", options_.clock(), id)
        .run();
  });
}

}  // namespace vacuform
