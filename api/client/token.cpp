#include "api/client/token.hpp"

#include <cstdlib>
#include <fstream>

namespace vacuform {

Result<std::string> find_token(const std::string& file) {
  std::string name = file, token;
  if (name.empty()) {
    if (const char* given = std::getenv("VACUFORM_TOKEN"); given && *given) return std::string(given);
    if (const char* named = std::getenv("VACUFORM_TOKEN_FILE")) name = named;
  }
  if (name.empty()) return token;
  std::ifstream in(name);
  if (!std::getline(in, token) || token.empty())
    return fail(Code::unreadable, "the token cannot be read", name,
                "give a file with the token on its first line");
  return token;
}

}  // namespace vacuform
