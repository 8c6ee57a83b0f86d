// A file that a person gives for a job. Its bytes are untrusted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace vacuform {

struct InputFile {
  std::vector<std::uint8_t> bytes;
  std::string name;  // for messages, and for the format of a scan
};

}  // namespace vacuform
