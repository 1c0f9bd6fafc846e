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
  /// Reports packets on `descriptor` with `key`. Does nothing when the descriptor is added already.
  /// Throws std::system_error when the kernel refuses.
  void add(int descriptor, std::uint64_t key);
  /// Waits for events; -1 milliseconds: without a limit. Returns the events, in `room`.
  std::span<const epoll_event> wait(std::span<epoll_event> room, int milliseconds);

 private:
  const Descriptor descriptor_;
};

}  // namespace gecos::session
