// A disk that fills up at a chosen call: the program that links this has open(), write(), fsync() and the like of its own,
// which the store and SQLite call without knowing. They fail with ENOSPC when they are told to. Flushes that do not fail
// do nothing, for speed.
#pragma once

#include <cstdint>
#include <optional>

namespace vacuform {

enum class Full { once, from_then_on };

// The n-th call from now on that could take space fails, or all from it on.
void fill_disk_at(int call, Full how);
// No more calls fail. Gives whether one did.
bool empty_disk();
// What statvfs() says is free, of a disk of 1 GiB; nothing: the truth.
void say_free(std::optional<std::uint64_t> bytes);

}  // namespace vacuform
