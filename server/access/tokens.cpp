#include "server/access/tokens.hpp"

#include <algorithm>

#include "api/base/file.hpp"
#include "api/base/secrets.hpp"

namespace vacuform {

namespace {

constexpr std::string_view prefix = "vft_";
constexpr std::size_t id_size = 16, secret_size = 64;

bool plain_name(std::string_view name) {
  return !name.empty() && name.size() <= 32 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
}

}  // namespace

Result<MadeToken> make_token(TokenTable& store, const NewToken& wanted, const Clock& clock) {
  if (!plain_name(wanted.owner))
    return fail(Code::bad_usage, "not the name of an owner: " + wanted.owner.substr(0, 64), "owner",
                "give 1 to 32 of a-z, 0-9 and '-', for example station-3; never the name of a person");
  if (wanted.scopes == Scopes())
    return fail(Code::bad_usage, "the token has no scope", "scopes",
                "give some of submit, read, work, admin");
  if (wanted.scopes.has(Scope::work) && wanted.scopes != Scopes{Scope::work})
    return fail(Code::bad_usage, "a worker's token has the scope work alone", "scopes",
                "make one token with work and another one with the other scopes");
  const Millis now = clock();
  if (wanted.expires && *wanted.expires <= now)
    return fail(Code::bad_usage, "the token would have expired already", "days", "give a number above 0");
  const std::string id = random_hex(id_size / 2), secret = random_hex(secret_size / 2);
  Token token{id,  wanted.owner,   wanted.scopes, text_hash(secret),
              now, wanted.expires, std::nullopt,  wanted.file};
  VACUFORM_CHECK(store.add_token(token));
  return MadeToken{std::move(token), std::string(prefix) + id + "_" + secret};
}

bool usable(const Token& token, Millis now) {
  return !token.revoked && (!token.expires || now < *token.expires);
}

Result<Token> usable_token(TokenTable& store, std::string_view text, const Clock& clock) {
  const auto refuse = [](const char* what) {
    return fail(Code::unauthorized, what, "token", "ask the administrator for a new one");
  };
  constexpr std::size_t underscore = prefix.size() + id_size;
  if (text.size() != underscore + 1 + secret_size || !text.starts_with(prefix) || text[underscore] != '_')
    return refuse("this is not a token of Vacuform");
  const auto token = store.token(std::string(text.substr(prefix.size(), id_size)));
  if (!token && token.error().code != Code::not_found) return token;
  const std::string hash = text_hash(text.substr(underscore + 1));
  // The same text for an unknown id and a wrong secret, so that ids cannot be discovered by trying.
  if (!token || !equal_secrets(hash, token->hash)) return refuse("the token is wrong");
  if (token->revoked) return refuse("the token was revoked");
  if (!usable(*token, clock())) return refuse("the token has expired");
  return token;
}

std::optional<std::string> token_of_file(TokenTable& store, const std::filesystem::path& file,
                                         const Scopes& scopes) {
  auto text = read_text_file(file, 4096);
  if (!text) return std::nullopt;
  while (!text->empty() && text->back() == '\n') text->pop_back();
  const auto token = usable_token(store, *text);
  return token && token->scopes == scopes ? std::optional(std::move(*text)) : std::nullopt;
}

Result<std::string> token_in_file(TokenTable& store, const std::filesystem::path& file,
                                  const NewToken& wanted) {
  if (auto text = token_of_file(store, file, wanted.scopes)) return std::move(*text);
  NewToken named = wanted;
  named.file = file.filename().string();
  VACUFORM_TRY(made, make_token(store, named));
  VACUFORM_CHECK(write_text_file(file, made.text + "\n"));
  return made.text;
}

}  // namespace vacuform
