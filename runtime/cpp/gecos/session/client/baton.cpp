#include "gecos/session/client/baton.hpp"

#include <algorithm>

namespace gecos::session {

void Baton::drop() {
  state_.store(State::Free, std::memory_order_seq_cst);
  if (follower_count_.load(std::memory_order_seq_cst) != 0) poke_one();
}

void Baton::resume() {
  while (!change(State::Resting, State::Held)) state_.wait(State::Borrowed);
}

void Baton::give_back() {
  state_.store(State::Resting, std::memory_order_release);
  state_.notify_one();
}

void Baton::poke_one() {
  const std::lock_guard lock(mutex_);
  if (followers_.empty()) return;
  followers_.front()->poked = true;
  followers_.front()->woken.notify_one();
}

void Baton::poke(const void* subject) {
  if (follower_count_.load(std::memory_order_seq_cst) == 0) return;
  const std::lock_guard lock(mutex_);
  for (Follower* follower : followers_) {
    if (follower->subject != subject) continue;
    follower->poked = true;
    follower->woken.notify_one();
  }
}

void Baton::poke_all() {
  const std::lock_guard lock(mutex_);
  for (Follower* follower : followers_) {
    follower->poked = true;
    follower->woken.notify_one();
  }
}

Baton::Woken Baton::follow(const void* subject, FunctionRef<bool()> done, TimePoint deadline) {
  Follower self;
  self.subject = subject;
  {
    const std::lock_guard lock(mutex_);
    followers_.push_back(&self);
  }
  follower_count_.fetch_add(1, std::memory_order_seq_cst);

  Woken woken = Woken::Poked;
  if (done()) {
    woken = Woken::Done;
  } else {
    std::unique_lock lock(mutex_);
    const auto wanted = [&] { return self.poked || free(); };
    if (deadline == TimePoint::max()) {
      self.woken.wait(lock, wanted);
    } else if (!self.woken.wait_until(lock, deadline, wanted)) {
      woken = Woken::TimedOut;
    }
  }

  {
    const std::lock_guard lock(mutex_);
    followers_.erase(std::find(followers_.begin(), followers_.end(), &self));
  }
  follower_count_.fetch_sub(1, std::memory_order_seq_cst);
  // A poke that meant "lead" must not be lost with a follower that leaves.
  if (woken != Woken::Poked && free()) poke_one();
  return woken;
}

}  // namespace gecos::session
