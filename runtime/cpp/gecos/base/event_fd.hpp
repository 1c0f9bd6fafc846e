#pragma once

#include "gecos/base/descriptor.hpp"

namespace gecos {

/// Makes the eventfd `descriptor` readable, which wakes the threads that wait on it.
void notify_event_fd(int descriptor);

/// An eventfd on which its owner waits and which others notify.
class EventFd {
 public:
  /// Throws std::system_error when the process has no descriptor left.
  EventFd();
  int descriptor() const { return fd_.get(); }
  void notify() const { notify_event_fd(fd_.get()); }
  /// Makes the descriptor unreadable again. True when the eventfd had been notified. Never blocks,
  /// even when an untrusted holder of the descriptor has changed its flags.
  bool drain();
  void close() { fd_.reset(); }

 private:
  Descriptor fd_;
};

}  // namespace gecos
