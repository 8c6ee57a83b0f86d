#include "server/messages/source_reader.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "api/base/log.hpp"

namespace vacuform::http {

SourceReader::SourceReader(SourceBody body) : body_(std::move(body)) {
  if (!body_.sha256.empty()) hash_ = std::make_unique<Sha256>();
}

std::string_view SourceReader::next(std::size_t most) {
  piece_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(most, body_.bytes - read_)));
  const auto got = body_.source->read_at(body_.offset + read_, piece_);
  if (!got) return {};
  const std::string_view piece(piece_.data(), *got);
  read_ += piece.size();
  if (!hash_) return piece;
  hash_->add(piece);
  if (read_ < body_.bytes || hash_->hex() == body_.sha256) return piece;
  log_event("blob-damaged", {{"blob", body_.sha256}});
  body_.source->invalidate();
  return {};
}

}  // namespace vacuform::http
