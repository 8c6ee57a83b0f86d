// All artifacts of a job in one zip file, the same bytes for the same artifacts.
#pragma once

#include "server/store/store.hpp"

namespace vacuform {

// Identifies the zip of these artifacts: the hash of their names and hashes, without making it.
std::string zip_etag(const Job& job);

// Makes the zip in a temporary file of the store; the file has no name any more and disappears when it is
// closed. Errors: those of the store; unavailable when the disk is full.
Result<File> make_zip(Store& store, const Job& job);

}  // namespace vacuform
