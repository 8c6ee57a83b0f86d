#include "server/http/admission.hpp"

#include <algorithm>

namespace vacuform::http {

tl::expected<Place, Refusal> Places::take(const std::string& party) {
  const std::lock_guard hold(mutex_);
  const auto refuse = [&](int status, const char* whose) {
    return tl::make_unexpected(Refusal{
        status, {Code::busy, "too many " + held_ + whose, {}, "try again later, or fewer at a time"}});
  };
  if (taken_ >= most_) return refuse(503, " at this moment");
  const auto found = of_.find(party);
  if (found != of_.end() && found->second >= most_of_one_) return refuse(429, " of yours at this moment");
  ++taken_;
  ++of_[party];
  return Place(static_cast<void*>(this), [this, party](void*) { give_back(party); });
}

int Places::taken() const {
  const std::lock_guard hold(mutex_);
  return taken_;
}

void Places::give_back(const std::string& party) {
  const std::lock_guard hold(mutex_);
  --taken_;
  if (--of_[party] == 0) of_.erase(party);
}

bool Turns::free_for(const Party& party) const {
  return at_work_ < most_ && party.at_work < std::max(1, most_ / 2);
}

Place Turns::take(const std::string& party, std::chrono::milliseconds time) {
  std::unique_lock hold(mutex_);
  Party& mine = parties_[party];
  Waiting me;
  if (mine.waiting.empty()) order_.push_back(party);
  mine.waiting.push_back(&me);
  call_next();
  if (!me.wake.wait_for(hold, time, [&] { return me.called; })) {
    std::erase(mine.waiting, &me);
    if (mine.waiting.empty()) std::erase(order_, party);
    forget_if_idle(party);
    return nullptr;
  }
  return Place(static_cast<void*>(this), [this, party](void*) { give_back(party); });
}

// Each party is looked at once; those whose share is taken stay in the order.
void Turns::call_next() {
  for (std::size_t looks = order_.size(); looks > 0 && at_work_ < most_; --looks) {
    const std::string name = std::move(order_.front());
    order_.pop_front();
    Party& party = parties_[name];
    if (free_for(party)) {
      party.waiting.front()->called = true;
      party.waiting.front()->wake.notify_one();
      party.waiting.pop_front();
      ++party.at_work;
      ++at_work_;
    }
    if (!party.waiting.empty()) order_.push_back(name);
  }
}

void Turns::give_back(const std::string& name) {
  const std::lock_guard hold(mutex_);
  --at_work_;
  --parties_[name].at_work;
  call_next();
  forget_if_idle(name);
}

void Turns::forget_if_idle(const std::string& name) {
  const Party& party = parties_[name];
  if (party.at_work == 0 && party.waiting.empty()) parties_.erase(name);
}

}  // namespace vacuform::http
