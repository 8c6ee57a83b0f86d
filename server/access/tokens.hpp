// Tokens: how they are made, told apart and checked.
//
// A token is "vft_" + its id + "_" + its secret. The id is public and finds the row; lists and logs name it. The secret
// is 256 random bits, which the store keeps as SHA-256 alone. A slow or salted hash would add nothing: those protect
// secrets that people choose, from a guesser who tries likely ones, and here all 2^256 are alike.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "server/store/tokens.hpp"

namespace vacuform {

struct NewToken {
  std::string
      owner;  // whose jobs it sees: 1 to 32 of a-z, 0-9 and '-', for a place or a purpose, never a person
  Scopes scopes;
  std::optional<Millis> expires;
  std::string file = {};  // of the data folder, if the server makes it for one
};

struct MadeToken {
  Token token;
  std::string text;  // what its user shows; it is kept nowhere
};

// Errors: bad_usage (the owner's name, no scope, work together with another scope, already expired), and those of the
// store.
Result<MadeToken> make_token(TokenTable& store, const NewToken& wanted, const Clock& clock = wall_clock);

// The token that a text is, if it is one that may be used now. Errors: unauthorized.
Result<Token> usable_token(TokenTable& store, std::string_view text, const Clock& clock = wall_clock);

// Whether a token may be used now.
bool usable(const Token& token, Millis now);

// The text of the usable token of exactly these scopes that a file holds, if it holds one.
std::optional<std::string> token_of_file(TokenTable& store, const std::filesystem::path& file,
                                         const Scopes& scopes);
// Sees that a file holds a usable token of this scope, and otherwise makes one and writes it there, for the owner of
// the folder alone (0600). Gives its text.
Result<std::string> token_in_file(TokenTable& store, const std::filesystem::path& file,
                                  const NewToken& wanted);

}  // namespace vacuform
