#include "gecos/media/parts/fork_watch.hpp"

#include <pthread.h>

#include <mutex>

namespace gecos::media {

/// All watches of this process. The handlers of pthread_atfork take no argument, so the list is
/// global.
struct ForkList {
  std::mutex mutex;
  ForkWatch* first = nullptr;

  ForkList() {
    ::pthread_atfork([] { instance().mutex.lock(); }, [] { instance().mutex.unlock(); },
                     [] { instance().abandon_all(); });
  }

  static ForkList& instance() {
    static ForkList* const list = new ForkList;  // never destroyed: outlives all static connections
    return *list;
  }

  void abandon_all() {
    for (ForkWatch* watch = first; watch != nullptr; watch = watch->next_) {
      watch->abandon_(watch->owner_);
    }
    mutex.unlock();  // locked by this thread before the fork
  }
};

ForkWatch::ForkWatch(void* owner, Abandon abandon) : owner_(owner), abandon_(abandon) {
  ForkList& list = ForkList::instance();
  const std::lock_guard lock(list.mutex);
  next_ = list.first;
  if (next_ != nullptr) next_->previous_ = this;
  list.first = this;
}

ForkWatch::~ForkWatch() {
  ForkList& list = ForkList::instance();
  const std::lock_guard lock(list.mutex);
  if (next_ != nullptr) next_->previous_ = previous_;
  (previous_ != nullptr ? previous_->next_ : list.first) = next_;
}

}  // namespace gecos::media
