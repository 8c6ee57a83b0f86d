#include "server/jobs/blob_response.hpp"

namespace vacuform {

namespace {

class BlobSource : public http::Source {
 public:
  explicit BlobSource(std::unique_ptr<BlobReader> reader) : reader_(std::move(reader)) {}
  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> into) const override {
    return reader_->read_at(offset, into);
  }
  void invalidate() const override { reader_->invalidate(); }

 private:
  std::unique_ptr<BlobReader> reader_;
};

}  // namespace

Result<http::Response> blob_response(const http::Request& request, std::unique_ptr<BlobReader> reader,
                                     std::string media_type, const std::string& sha256) {
  VACUFORM_TRY(bytes, reader->size());
  return http::source_response(request, std::make_shared<BlobSource>(std::move(reader)), bytes,
                               std::move(media_type), sha256, sha256);
}

}  // namespace vacuform
