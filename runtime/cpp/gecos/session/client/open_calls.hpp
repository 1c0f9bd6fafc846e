#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "gecos/session/client/pending_command.hpp"
#include "gecos/session/protocol/call_table.hpp"

namespace gecos::session {

/// The calls of one session that have no reply yet, and the counter that numbers the calls of the
/// session. Does no I/O. Not thread-safe.
class OpenCalls {
 public:
  using List = std::vector<std::pair<std::uint64_t, std::shared_ptr<PendingCommand>>>;

  std::size_t size() const { return table_.size(); }
  /// Returns the number of calls that were issued so far.
  std::uint64_t issued() const { return next_counter_ - 1; }
  /// Returns the counter of the next call: 1 for the first call.
  std::uint64_t next_counter() const { return next_counter_; }
  /// Returns `next_counter()` and increases it. Must be called as soon as a packet with that
  /// counter was sent, because no other call may ever have this counter.
  std::uint64_t issue() { return next_counter_++; }
  /// Returns the highest counter up to which every call has its reply.
  std::uint64_t finished_up_to() const;

  /// Adds `command` under `counter`, which `issue` returned.
  void add(std::uint64_t counter, std::shared_ptr<PendingCommand> command) {
    table_.insert(counter, std::move(command));
  }
  /// Returns the open call with this counter; null when there is none. The pointer is valid until a
  /// call is added or removed.
  const std::shared_ptr<PendingCommand>* find(std::uint64_t counter) const {
    return table_.find(counter);
  }
  /// Removes and returns the call; null when no open call has this counter.
  std::shared_ptr<PendingCommand> take(std::uint64_t counter) { return table_.take(counter); }

  // The following functions return the calls in the order of their counters.
  List all() const { return table_.all(); }
  List take_all() { return table_.take_all(); }
  /// Removes and returns the calls that may be sent again in another session, except canceled ones.
  List take_repeatable();

  bool has_repeatable() const;
  /// True when the server has confirmed the arrival of every open call.
  bool everything_arrived() const;

 private:
  CallTable<PendingCommand> table_;
  std::uint64_t next_counter_ = 1;
};

}  // namespace gecos::session
