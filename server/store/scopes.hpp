// What a token is good for.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace vacuform {

enum class Scope {
  submit,  // make jobs, cancel and delete one's own
  read,    // see one's own jobs and their artifacts
  work,    // lease jobs and run them
  admin,   // see and end everybody's jobs, make and revoke tokens; submit and read with it
};
inline constexpr std::array<std::string_view, 4> scope_names{"submit", "read", "work", "admin"};
constexpr std::string_view name(Scope scope) { return scope_names[static_cast<std::size_t>(scope)]; }

class Scopes {
 public:
  Scopes() = default;
  Scopes(std::initializer_list<Scope> scopes) {
    for (const Scope scope : scopes) add(scope);
  }
  // "submit,read"; nothing when it names none or an unknown one.
  static std::optional<Scopes> from(std::string_view text);

  void add(Scope scope) { bits_ |= bit(scope); }
  // Whether a token with these may do what needs `scope`. Work is for machines alone: admin does not include it.
  bool allow(Scope scope) const {
    return (bits_ & bit(scope)) != 0 || (scope != Scope::work && (bits_ & bit(Scope::admin)) != 0);
  }
  bool has(Scope scope) const { return (bits_ & bit(scope)) != 0; }
  std::string text() const;  // "submit,read"
  bool operator==(const Scopes&) const = default;

 private:
  static unsigned bit(Scope scope) { return 1u << static_cast<unsigned>(scope); }
  unsigned bits_ = 0;
};

}  // namespace vacuform
