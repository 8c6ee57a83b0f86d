// An answer on its way to a client that may take it slowly: as much as the socket takes at once, and the rest
// later. Nothing here waits.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "api/base/sha256.hpp"
#include "server/http/message.hpp"

namespace vacuform::http {

class Outgoing {
 public:
  Outgoing() = default;
  // `text` and then the bytes of `body`.
  explicit Outgoing(std::string text, std::optional<SourceBody> body = std::nullopt);

  enum class Sent {
    all,
    blocked,  // the socket takes no more at present
    paused,   // it would take more; others get their turn first
    broken,   // the client is gone, or the source is not what it should be
  };
  Sent send(int socket);

  std::uint64_t bytes() const { return sent_; }            // sent so far
  std::size_t memory() const { return text_.capacity(); }  // held until all is sent

 private:
  Sent send_source(int socket, std::size_t& budget);
  bool right(std::uint64_t offset, std::string_view piece);

  std::string text_;
  std::size_t text_sent_ = 0;
  std::optional<SourceBody> body_;
  std::uint64_t body_sent_ = 0, hashed_ = 0, sent_ = 0;
  std::unique_ptr<Sha256> hash_;  // of the body up to hashed_, where its hash is known
};

}  // namespace vacuform::http
