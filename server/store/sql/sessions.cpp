#include "server/store/sql/sql_store.hpp"

namespace vacuform {

namespace {

// The token that must lose a session before `token` gets another one; empty: there is room.
Result<std::string> token_to_lose_session(Database& db, const std::string& token) {
  {
    Query counts(db, "SELECT count(*), coalesce(sum(CASE WHEN token=? THEN 1 ELSE 0 END), 0) FROM session",
                 token);
    VACUFORM_CHECK(counts.row());
    if (counts.integer(1) >= most_sessions_of_token) return token;
    if (counts.integer(0) < most_sessions) return std::string();
  }
  Query most(db, "SELECT token FROM session GROUP BY token ORDER BY count(*) DESC, token LIMIT 1");
  VACUFORM_CHECK(most.row());
  return most.text(0);
}

}  // namespace

Result<void> SqlStore::add_session(const Session& session) {
  return write([&](Transaction& tx) -> Result<void> {
    VACUFORM_CHECK(tx.db.take_turns("sessions"));
    VACUFORM_CHECK(Query(tx.db, "DELETE FROM session WHERE ends<=?", options_.clock()).run());
    VACUFORM_TRY(loser, token_to_lose_session(tx.db, session.token));
    if (!loser.empty())
      VACUFORM_CHECK(Query(tx.db,
                           "DELETE FROM session WHERE hash="
                           "(SELECT hash FROM session WHERE token=? ORDER BY ends, hash LIMIT 1)",
                           loser)
                         .run());
    return Query(tx.db, "INSERT INTO session(hash, token, ends) VALUES(?,?,?)", session.hash, session.token,
                 session.ends)
        .run();
  });
}

Result<FoundSession> SqlStore::find_session(const std::string& hash) {
  return read([&](Database& db) -> Result<FoundSession> {
    Query query(db,
                "SELECT token.id, token.owner, token.scopes, token.hash, token.created, token.expires,"
                " token.revoked, token.file, session.ends"
                " FROM session JOIN token ON token.id=session.token WHERE session.hash=?",
                hash);
    VACUFORM_TRY(found, query.row());
    if (!found) return fail(Code::not_found, "there is no such session", {}, "sign in again");
    return FoundSession{token_in(query), query.integer(8)};
  });
}

Result<void> SqlStore::end_session(const std::string& hash) {
  return write([&](Transaction& tx) { return Query(tx.db, "DELETE FROM session WHERE hash=?", hash).run(); });
}

Result<void> SqlStore::add_link(const SignInLink& link) {
  return write([&](Transaction& tx) -> Result<void> {
    VACUFORM_CHECK(tx.db.take_turns("sessions"));
    VACUFORM_CHECK(Query(tx.db, "DELETE FROM sign_in_link WHERE expires<=?", options_.clock()).run());
    VACUFORM_CHECK(Query(tx.db,
                         "DELETE FROM sign_in_link WHERE hash IN (SELECT hash FROM sign_in_link WHERE token=?"
                         " ORDER BY expires DESC, hash LIMIT ? OFFSET ?)",
                         link.token, most_links_of_token, most_links_of_token - 1)
                       .run());
    return Query(tx.db, "INSERT INTO sign_in_link(hash, token, expires) VALUES(?,?,?)", link.hash, link.token,
                 link.expires)
        .run();
  });
}

Result<Token> SqlStore::use_link(const std::string& hash) {
  return write([&](Transaction& tx) -> Result<Token> {
    VACUFORM_CHECK(tx.db.take_turns("sessions"));
    std::string token;
    {
      Query query(tx.db, "SELECT token FROM sign_in_link WHERE hash=? AND expires>?", hash, options_.clock());
      VACUFORM_TRY(found, query.row());
      if (!found) return fail(Code::not_found, "there is no such link", {}, "ask for another one");
      token = query.text(0);
    }
    VACUFORM_CHECK(Query(tx.db, "DELETE FROM sign_in_link WHERE hash=?", hash).run());
    return token_row(tx.db, token);
  });
}

}  // namespace vacuform
