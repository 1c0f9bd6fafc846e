#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "gecos/base/descriptor.hpp"

namespace gecos::broker {

/// Processes of this host whose end the kernel reports. Not thread-safe, except `descriptor`.
class Processes {
 public:
  /// Throws std::system_error when the process has no descriptor left.
  Processes();

  /// Begins to watch the process. Returns false when there is no such process: it has ended, or it
  /// is in another PID namespace. Does nothing when the process is watched already.
  bool watch(std::int32_t pid);
  void forget(std::int32_t pid) { watched_.erase(pid); }
  /// Returns the watched processes that have ended, and forgets them. Never blocks.
  std::vector<std::int32_t> take_ended();
  std::vector<std::int32_t> watched() const;
  /// Is readable while a watched process has ended that `take_ended` has not returned.
  int descriptor() const { return epoll_.get(); }

 private:
  const Descriptor epoll_;
  /// The pidfd of each process. Without one, because this process had no descriptor left,
  /// `take_ended` asks for the process by its number.
  std::map<std::int32_t, Descriptor> watched_;
};

}  // namespace gecos::broker
