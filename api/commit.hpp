// The commit that the programs are built from. Only the programs link it, so that a new commit rebuilds only this.
#pragma once

#include <string>
#include <string_view>

namespace vacuform {

// "abcdef123456"; "abcdef123456, modified" if tracked files differ from that commit; "unknown" without git.
std::string_view commit();

// What --version prints: "vacuform-server 0.1.0 (commit abcdef123456)".
std::string version_line(std::string_view program);

}  // namespace vacuform
