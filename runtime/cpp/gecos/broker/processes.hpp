#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "gecos/base/descriptor.hpp"

namespace gecos::broker {

/// Watches processes of this host; the kernel reports when one of them ends. Not thread-safe,
/// except `descriptor`.
class Processes {
 public:
  /// Throws std::system_error when the process has no descriptor left.
  Processes();

  /// Begins to watch the process. Returns false when the process does not exist, because it has
  /// ended or is in another PID namespace. Does nothing when the process is watched already.
  bool watch(std::int32_t pid);
  /// Returns the time at which the watched process started, in ticks since the boot of the machine.
  /// A later process with the same PID has another start time. Returns 0 when the start time is not
  /// known.
  std::uint64_t start_of(std::int32_t pid) const;
  void forget(std::int32_t pid) { watched_.erase(pid); }
  /// Returns the watched processes that have ended, and forgets them. Never blocks.
  std::vector<std::int32_t> take_ended();
  std::vector<std::int32_t> watched() const;
  /// Returns a descriptor that is readable while take_ended() has an ended process to return.
  int descriptor() const { return epoll_.get(); }

 private:
  struct Watched {
    /// The pidfd of the watched process; -1 when the calling process had no descriptor left for a
    /// pidfd. `take_ended` then looks up the process by its PID.
    Descriptor process;
    std::uint64_t start = 0;
  };
  const Descriptor epoll_;
  std::map<std::int32_t, Watched> watched_;
};

}  // namespace gecos::broker
