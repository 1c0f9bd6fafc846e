#pragma once

#include "gecos/base/descriptor.hpp"

namespace gecos {

/// Makes the eventfd `descriptor` readable, which wakes the threads that wait on it.
void notify_event_fd(int descriptor);

/// An eventfd. Its owner waits on it, and other threads or processes notify it.
class EventFd {
 public:
  /// Throws std::system_error when the process cannot open another file descriptor.
  EventFd();
  int descriptor() const { return fd_.get(); }
  void notify() const { notify_event_fd(fd_.get()); }
  /// Makes the descriptor unreadable again. Returns true when the eventfd had been notified. Never
  /// blocks, even when an untrusted process with the same eventfd has changed the flags of the
  /// descriptor.
  bool drain();
  void close() { fd_.reset(); }

 private:
  Descriptor fd_;
};

}  // namespace gecos
