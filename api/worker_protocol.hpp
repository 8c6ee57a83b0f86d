// The version of what a server and its workers say to each other. It is raised when an older side would do harm by not
// understanding a newer one; a server gives no jobs to workers of other versions.
#pragma once

namespace vacuform {

// 1: workers stated no version, and kept stages by scan. 2: they state it, and keep stages by the key of the lease.
inline constexpr int worker_protocol = 2;

}  // namespace vacuform
