// Places for responses that keep a thread while they stream or wait: so many in all, and so many for one party, so that no
// one takes those of the others.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/http/message.hpp"

namespace vacuform::http {

// From any thread; outlives the places that it gives.
class Places {
 public:
  using Place = std::shared_ptr<void>;  // given back when the last copy goes

  Places(int most, int most_of_one) : most_(most), most_of_one_(most_of_one) {}

  // Refusals: 503 when all are taken, 429 when the party has as many as one may have.
  tl::expected<Place, Refusal> take(const std::string& party) {
    const std::lock_guard hold(mutex_);
    const auto refuse = [](int status, const char* what) {
      return tl::make_unexpected(Refusal{
          status, {Code::busy, what, {}, "try again later, or ask from time to time instead of waiting"}});
    };
    if (taken_ >= most_) return refuse(503, "too many clients follow jobs already");
    if (of_[party] >= most_of_one_) return refuse(429, "too many of your clients follow jobs already");
    ++taken_;
    ++of_[party];
    return Place(static_cast<void*>(this), [this, party](void*) { give_back(party); });
  }

  int taken() const {
    const std::lock_guard hold(mutex_);
    return taken_;
  }

 private:
  void give_back(const std::string& party) {
    const std::lock_guard hold(mutex_);
    --taken_;
    if (--of_[party] == 0) of_.erase(party);
  }

  const int most_, most_of_one_;
  mutable std::mutex mutex_;
  int taken_ = 0;
  std::map<std::string, int> of_;
};

}  // namespace vacuform::http
