#include "gecos/session/client/leader_lock.hpp"

#include <algorithm>

namespace gecos::session {

void LeaderLock::drop() {
  state_.store(State::Free, std::memory_order_seq_cst);
  if (follower_count_.load(std::memory_order_seq_cst) != 0) notify_one();
}

void LeaderLock::resume() {
  while (!change(State::Resting, State::Held)) state_.wait(State::Borrowed);
}

void LeaderLock::release() {
  state_.store(State::Resting, std::memory_order_release);
  state_.notify_one();
}

void LeaderLock::notify_one() {
  const MutexLock lock(mutex_);
  if (followers_.empty()) return;
  followers_.front()->notified = true;
  followers_.front()->woken.notify_one();
}

void LeaderLock::notify(const void* subject) {
  if (follower_count_.load(std::memory_order_seq_cst) == 0) return;
  const MutexLock lock(mutex_);
  for (Follower* follower : followers_) {
    if (follower->subject != subject) continue;
    follower->notified = true;
    follower->woken.notify_one();
  }
}

void LeaderLock::notify_all() {
  const MutexLock lock(mutex_);
  for (Follower* follower : followers_) {
    follower->notified = true;
    follower->woken.notify_one();
  }
}

LeaderLock::Woken LeaderLock::follow(const void* subject, FunctionRef<bool()> done,
                                     TimePoint deadline) {
  Follower self;
  self.subject = subject;
  {
    const MutexLock lock(mutex_);
    followers_.push_back(&self);
  }
  follower_count_.fetch_add(1, std::memory_order_seq_cst);

  Woken woken = Woken::Notified;
  if (done()) {
    woken = Woken::Done;
  } else {
    MutexLock lock(mutex_);
    const auto wanted = [&] { return self.notified || free(); };
    if (deadline == TimePoint::max()) {
      self.woken.wait(lock, wanted);
    } else if (!self.woken.wait_until(lock, deadline, wanted)) {
      woken = Woken::TimedOut;
    }
  }

  {
    const MutexLock lock(mutex_);
    followers_.erase(std::find(followers_.begin(), followers_.end(), &self));
  }
  follower_count_.fetch_sub(1, std::memory_order_seq_cst);
  // If the lead is free, another follower must be notified, because this thread stops waiting and
  // does not take the lead.
  if (woken != Woken::Notified && free()) notify_one();
  return woken;
}

}  // namespace gecos::session
