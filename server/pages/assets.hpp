// Files of the source tree that are built into the program (see embed.cmake).
#pragma once

#include <span>
#include <string_view>

namespace vacuform {

struct Asset {
  std::string_view name, bytes;  // name: without folders
};
std::span<const Asset> assets();

// The web application and the files of the sample, each compressed with gzip under its name with ".gz".
std::span<const Asset> app_files();

// The bytes of the file of that name. Throws std::logic_error if there is no such file.
std::string_view asset(std::string_view name);

}  // namespace vacuform
