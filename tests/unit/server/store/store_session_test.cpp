// Sessions of browsers: how long they are kept, and how many.
#include "tests/unit/server/store/store_fixture.hpp"

namespace vacuform {
namespace {

// The sessions of a test, each of which ends a moment later than the one before.
class Sessions {
 public:
  Sessions(std::unique_ptr<Store>& store, Millis now) : store_(store), ends_(now + 3'600'000) {}
  // Gives the hash of a new one.
  std::string add(const std::string& token) {
    if (!store_->token(token)) {
      EXPECT_TRUE(store_->add_token({token, "station-1", {Scope::read}, std::string(64, 'a'), 5, {}, {}}));
    }
    const std::string hash = text_hash(std::to_string(++ends_));
    const auto added = store_->add_session({hash, token, ends_});
    EXPECT_TRUE(added) << added.error().text();
    return hash;
  }
  bool has(const std::string& hash) const { return store_->find_session(hash).has_value(); }
  int count(const std::vector<std::string>& hashes) const {
    return static_cast<int>(
        std::count_if(hashes.begin(), hashes.end(), [this](const std::string& hash) { return has(hash); }));
  }

 private:
  std::unique_ptr<Store>& store_;
  Millis ends_;
};

TEST_P(StoreTest, KeepsSessionsWithTheirTokens) {
  Sessions sessions(store_, now_);
  const std::string first = sessions.add("0001"), second = sessions.add("0002");
  crash();
  const FoundSession found = store_->find_session(first).value();
  EXPECT_EQ(found.token.id, "0001");
  EXPECT_EQ(found.token.owner, "station-1");
  EXPECT_EQ(found.token.scopes, Scopes{Scope::read});
  EXPECT_EQ(found.token.created, 5);
  EXPECT_FALSE(found.token.expires || found.token.revoked);
  EXPECT_EQ(found.ends, now_ + 3'600'001);
  EXPECT_EQ(store_->find_session(text_hash("another")).error().code, Code::not_found);
  ASSERT_TRUE(store_->revoke_token("0002"));
  EXPECT_EQ(store_->find_session(second)->token.revoked, now_);
}

TEST_P(StoreTest, ASessionThatWasEndedDoesNotComeBack) {
  Sessions sessions(store_, now_);
  const std::string first = sessions.add("0001"), second = sessions.add("0001");
  ASSERT_TRUE(store_->end_session(first));
  EXPECT_TRUE(store_->end_session(first));  // harmless
  crash();
  EXPECT_FALSE(sessions.has(first));
  EXPECT_TRUE(sessions.has(second));
}

TEST_P(StoreTest, ANewSessionDeletesThoseThatAreOver) {
  Sessions sessions(store_, now_);
  const std::string first = sessions.add("0001"), second = sessions.add("0001");
  now_ = store_->find_session(first)->ends;
  EXPECT_TRUE(sessions.has(first));  // nothing was added since
  const std::string third = sessions.add("0001");
  EXPECT_FALSE(sessions.has(first));
  EXPECT_TRUE(sessions.has(second) && sessions.has(third));
}

TEST_P(StoreTest, ATokenWithTooManySessionsLosesItsOldest) {
  Sessions sessions(store_, now_);
  const std::string other = sessions.add("0002");
  std::vector<std::string> hashes;
  for (int i = 0; i < 52; ++i) hashes.push_back(sessions.add("0001"));
  EXPECT_FALSE(sessions.has(hashes[0]) || sessions.has(hashes[1]));
  EXPECT_EQ(sessions.count(hashes), 50);
  EXPECT_TRUE(sessions.has(other));
}

// 21 tokens fill the store: the one in the middle has 50 sessions, the others have 47 or 48.
TEST_P(StoreTest, OfTooManySessionsTheTokenWithTheMostLosesItsOldest) {
  Sessions sessions(store_, now_);
  std::vector<std::string> hashes;
  const auto add = [&](int token, int count) {
    for (int i = 0; i < count; ++i) hashes.push_back(sessions.add(std::to_string(1000 + token)));
  };
  for (int token = 0; token < 21; ++token) add(token, token == 10 ? 50 : token < 10 ? 47 : 48);
  ASSERT_EQ(hashes.size(), 1000u);
  ASSERT_EQ(sessions.count(hashes), 1000);
  add(21, 1);
  EXPECT_EQ(sessions.count(hashes), 1000);
  EXPECT_FALSE(sessions.has(hashes[10 * 47]));
}

TEST_P(StoreTest, ALinkGivesItsTokenOnce) {
  Sessions sessions(store_, now_);
  sessions.add("0001"), sessions.add("0002");
  ASSERT_TRUE(store_->add_link({"one", "0001", now_ + 10}));
  ASSERT_TRUE(store_->add_link({"two", "0002", now_ + 10}));
  crash();
  const auto token = store_->use_link("two");
  ASSERT_TRUE(token) << token.error().text();
  EXPECT_EQ(token->id, "0002");
  EXPECT_EQ(token->scopes, Scopes{Scope::read});
  crash();
  EXPECT_EQ(store_->use_link("two").error().code, Code::not_found);
  EXPECT_EQ(store_->use_link("three").error().code, Code::not_found);
  now_ += 10;
  EXPECT_EQ(store_->use_link("one").error().code, Code::not_found);
}

TEST_P(StoreTest, ATokenWithTooManyLinksLosesTheOneThatExpiresFirst) {
  Sessions sessions(store_, now_);
  sessions.add("0001"), sessions.add("0002");
  ASSERT_TRUE(store_->add_link({"other", "0002", now_ + 1}));
  for (int i = 0; i < most_links_of_token + 2; ++i)
    ASSERT_TRUE(store_->add_link({std::to_string(i), "0001", now_ + 1000 - i}));
  const int last = most_links_of_token + 1;  // the new one stays, whenever it expires
  EXPECT_TRUE(store_->use_link(std::to_string(last)));
  EXPECT_FALSE(store_->use_link(std::to_string(last - 1)) || store_->use_link(std::to_string(last - 2)));
  for (int i = 0; i < last - 2; ++i) EXPECT_TRUE(store_->use_link(std::to_string(i))) << i;
  EXPECT_TRUE(store_->use_link("other"));
}

// With sessions in it, a restore would bring back those that were signed out since.
TEST_P(StoreTest, ABackupHasNoSessions) {
  Sessions sessions(store_, now_);
  const std::string session = sessions.add("0001");
  ASSERT_TRUE(store_->add_link({"link", "0001", now_ + 1000}));
  const fs::path to = folder_ / "backup";
  fs::create_directory(to);
  fs::permissions(to, fs::perms::owner_all);
  ASSERT_TRUE(store_->backup(to, [] { return true; }));
  EXPECT_TRUE(sessions.has(session));
  open_backup(to);
  EXPECT_TRUE(store_->token("0001"));
  EXPECT_FALSE(sessions.has(session));
  EXPECT_FALSE(store_->use_link("link"));
}

}  // namespace
}  // namespace vacuform
