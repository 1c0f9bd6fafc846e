#pragma once

#include <sys/epoll.h>

#include <cstdint>
#include <span>

#include "gecos/base/descriptor.hpp"

namespace gecos::session {

/// An epoll instance whose descriptors are edge-triggered. Thread-safe.
class Epoll {
 public:
  /// Throws std::system_error when the process has no descriptor left.
  Epoll();
  /// Makes `wait` return an event with `key` when a packet arrives on `descriptor`. Does nothing
  /// when the descriptor was added before. Throws std::system_error when the kernel refuses.
  void add(int descriptor, std::uint64_t key);
  /// Waits for events for at most `milliseconds`; -1 means without limit. Stores the events in
  /// `room` and returns the part of `room` that contains them.
  std::span<const epoll_event> wait(std::span<epoll_event> room, int milliseconds);

 private:
  const Descriptor descriptor_;
};

}  // namespace gecos::session
