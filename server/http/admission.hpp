// Who may use how much of the server at the same time. A client is the owner of a token; it has no name before it showed
// one. From any thread; each object outlives what it gives.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/messages/message.hpp"

namespace vacuform::http {

using Slot = std::shared_ptr<void>;  // given back when the last copy goes

// Slots that are held for as long as a client likes: a limit for all, and one for each client, so that no client takes
// those of the others.
class Slots {
 public:
  Slots(std::string held, int most, int most_of_one)
      : held_(std::move(held)), most_(most), most_of_one_(most_of_one) {}
  // Refusals: 503 if all are taken, 429 if the client has as many as one may have.
  tl::expected<Slot, Refusal> take(const std::string& client);
  int taken() const;

 private:
  void give_back(const std::string& client);

  const std::string held_;  // "large bodies": in the refusals
  const int most_, most_of_one_;
  mutable std::mutex mutex_;
  int taken_ = 0;
  std::map<std::string, int> of_;
};

// Work that does not wait for clients has turns: so many at the same time, and half of them for one client. Who waits
// longest is next, one client after the other.
class FairQueue {
 public:
  explicit FairQueue(int most) : most_(most) {}
  // Waits for a turn; null if it does not come in time.
  Slot take(const std::string& client, std::chrono::milliseconds time);

 private:
  struct Waiting {
    std::condition_variable wake;
    bool called = false;
  };
  struct Client {
    int at_work = 0;
    std::deque<Waiting*> waiting;
  };
  bool free_for(const Client& client) const;
  void call_next();
  void give_back(const std::string& name);
  void forget_if_idle(const std::string& name);

  const int most_;
  std::mutex mutex_;
  int at_work_ = 0;
  std::map<std::string, Client> clients_;
  std::deque<std::string> order_;  // of the parties that wait
};

}  // namespace vacuform::http
