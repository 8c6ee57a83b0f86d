// Where the triangles of a binary STL are. Its head of 84 bytes says how many follow, and some programs write the wrong
// count, or put several files into one.
#pragma once

#include <cstdint>
#include <vector>

#include "api/base/byte_source.hpp"

namespace vacuform {

inline constexpr std::uint64_t stl_head_bytes = 84, stl_record_bytes = 50;

struct StlBodies {
  struct Body {
    std::uint64_t begin = 0, triangles = 0;  // of its head; behind it
    std::uint64_t end() const { return begin + stl_head_bytes + stl_record_bytes * triangles; }
  };
  // What is behind the last body: zeros or text, which nobody misses, or something else.
  enum class Rest { none, idle, unknown };

  std::vector<Body> bodies;    // at least one; the first may end behind the end of the file
  std::uint64_t declared = 0;  // the count in the first head
  std::uint64_t rest_bytes = 0;
  Rest rest = Rest::none;

  std::uint64_t triangles() const {
    std::uint64_t sum = 0;
    for (const Body& body : bodies) sum += body.triangles;
    return sum;
  }
  // Whether the bodies are not what the first head says.
  bool by_size() const { return bodies.size() > 1 || bodies.front().triangles != declared; }
};

// A file of at least 84 bytes. Bodies one after another are all found. If the bytes behind the counted triangles are
// whole records with plausible numbers, they are triangles too: the count is then too small. O(1), and O(n) where bytes
// are left over. Errors: of the source.
Result<StlBodies> find_stl_bodies(const ByteSource& file);

}  // namespace vacuform
