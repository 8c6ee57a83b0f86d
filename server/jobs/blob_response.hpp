// A blob as the body of a response.
#pragma once

#include <memory>
#include <string>

#include "server/messages/message.hpp"
#include "server/store/blob_store.hpp"

namespace vacuform {

// As http::source_response; the hash is the entity tag. Reads while the response is sent.
Result<http::Response> blob_response(const http::Request& request, std::unique_ptr<BlobReader> reader,
                                     std::string media_type, const std::string& sha256);

}  // namespace vacuform
