#include "server/http/admission.hpp"

#include <algorithm>

namespace vacuform::http {

tl::expected<Slot, Refusal> Slots::take(const std::string& client) {
  const std::lock_guard hold(mutex_);
  const auto refuse = [&](int status, const char* whose) {
    return tl::make_unexpected(Refusal{
        status, {Code::busy, "too many " + held_ + whose, {}, "try again later, or fewer at a time"}});
  };
  if (taken_ >= most_) return refuse(503, " at this moment");
  const auto found = of_.find(client);
  if (found != of_.end() && found->second >= most_of_one_) return refuse(429, " of yours at this moment");
  ++taken_;
  ++of_[client];
  return Slot(static_cast<void*>(this), [this, client](void*) { give_back(client); });
}

int Slots::taken() const {
  const std::lock_guard hold(mutex_);
  return taken_;
}

void Slots::give_back(const std::string& client) {
  const std::lock_guard hold(mutex_);
  --taken_;
  if (--of_[client] == 0) of_.erase(client);
}

bool FairQueue::free_for(const Client& client) const {
  return at_work_ < most_ && client.at_work < std::max(1, most_ / 2);
}

Slot FairQueue::take(const std::string& client, std::chrono::milliseconds time) {
  std::unique_lock hold(mutex_);
  Client& mine = clients_[client];
  Waiting me;
  if (mine.waiting.empty()) order_.push_back(client);
  mine.waiting.push_back(&me);
  call_next();
  if (!me.wake.wait_for(hold, time, [&] { return me.called; })) {
    std::erase(mine.waiting, &me);
    if (mine.waiting.empty()) std::erase(order_, client);
    forget_if_idle(client);
    return nullptr;
  }
  return Slot(static_cast<void*>(this), [this, client](void*) { give_back(client); });
}

// Each client is looked at once; those whose share is taken stay in the order.
void FairQueue::call_next() {
  for (std::size_t looks = order_.size(); looks > 0 && at_work_ < most_; --looks) {
    const std::string name = std::move(order_.front());
    order_.pop_front();
    Client& client = clients_[name];
    if (free_for(client)) {
      client.waiting.front()->called = true;
      client.waiting.front()->wake.notify_one();
      client.waiting.pop_front();
      ++client.at_work;
      ++at_work_;
    }
    if (!client.waiting.empty()) order_.push_back(name);
  }
}

void FairQueue::give_back(const std::string& name) {
  const std::lock_guard hold(mutex_);
  --at_work_;
  --clients_[name].at_work;
  call_next();
  forget_if_idle(name);
}

void FairQueue::forget_if_idle(const std::string& name) {
  const Client& client = clients_[name];
  if (client.at_work == 0 && client.waiting.empty()) clients_.erase(name);
}

}  // namespace vacuform::http
