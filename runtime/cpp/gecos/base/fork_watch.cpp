#include "gecos/base/fork_watch.hpp"

#include <pthread.h>

#include "gecos/base/mutex.hpp"

namespace gecos {

/// The list of all watches of this process. The list is global, because the handlers of
/// pthread_atfork have no parameter.
struct ForkList {
  Mutex mutex;
  ForkWatch* first GECOS_GUARDED_BY(mutex) = nullptr;

  ForkList() { ::pthread_atfork(&before_fork, &after_fork_in_parent, &after_fork_in_child); }

  static ForkList& instance() {
    static ForkList* const list = new ForkList;  // never destroyed: outlives all static connections
    return *list;
  }

  // The thread that calls fork() locks the mutex in before_fork(). after_fork_in_parent() unlocks
  // the mutex in the parent, and after_fork_in_child() unlocks the child's copy.
  static void before_fork() GECOS_ACQUIRE(instance().mutex) { instance().mutex.lock(); }
  static void after_fork_in_parent() GECOS_RELEASE(instance().mutex) { instance().mutex.unlock(); }
  static void after_fork_in_child() GECOS_RELEASE(instance().mutex) {
    for (ForkWatch* watch = instance().first; watch != nullptr; watch = watch->next_) {
      watch->abandon_(watch->owner_);
    }
    instance().mutex.unlock();
  }
};

ForkWatch::ForkWatch(void* owner, Abandon abandon) : owner_(owner), abandon_(abandon) {
  ForkList& list = ForkList::instance();
  const MutexLock lock(list.mutex);
  next_ = list.first;
  if (next_ != nullptr) next_->previous_ = this;
  list.first = this;
}

ForkWatch::~ForkWatch() {
  ForkList& list = ForkList::instance();
  const MutexLock lock(list.mutex);
  if (next_ != nullptr) next_->previous_ = previous_;
  (previous_ != nullptr ? previous_->next_ : list.first) = next_;
}

}  // namespace gecos
