#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace gecos::session {

/// The unfinished calls of one session, by counter. Allocates memory only when the number of open
/// calls reaches a new maximum. Not thread-safe.
template <class Call>
class CallTable {
 public:
  CallTable() : slots_(16) {}

  std::size_t size() const { return size_; }

  /// @pre `counter` is not 0, and the table has no call with this counter.
  void insert(std::uint64_t counter, std::shared_ptr<Call> call) {
    if ((size_ + 1) * 2 > slots_.size()) grow();
    place({counter, std::move(call)});
    ++size_;
  }

  /// Returns the call with this counter; null when there is none. The pointer is valid until the
  /// table changes.
  const std::shared_ptr<Call>* find(std::uint64_t counter) const {
    for (std::size_t at = home(counter);; at = next(at)) {
      if (slots_[at].counter == 0) return nullptr;  // checked first: no call has counter 0
      if (slots_[at].counter == counter) return &slots_[at].call;
    }
  }

  /// Removes and returns the call; null when the table has no call with this counter.
  std::shared_ptr<Call> take(std::uint64_t counter) {
    std::size_t at = home(counter);
    for (;; at = next(at)) {
      if (slots_[at].counter == 0) return nullptr;  // checked first: no call has counter 0
      if (slots_[at].counter == counter) break;
    }
    auto taken = std::move(slots_[at].call);
    slots_[at] = {};
    --size_;
    close_gap(at);
    return taken;
  }

  /// Returns the lowest counter in the table; 0 when the table is empty.
  std::uint64_t lowest() const {
    std::uint64_t least = 0;
    for (const auto& slot : slots_) {
      if (slot.counter != 0 && (least == 0 || slot.counter < least)) least = slot.counter;
    }
    return least;
  }

  /// Removes and returns all calls, in the order of their counters.
  std::vector<std::pair<std::uint64_t, std::shared_ptr<Call>>> take_all();
  /// Returns all calls, in the order of their counters.
  std::vector<std::pair<std::uint64_t, std::shared_ptr<Call>>> all() const;

 private:
  struct Slot {
    std::uint64_t counter = 0;  ///< 0: the slot is free
    std::shared_ptr<Call> call;
  };

  std::size_t home(std::uint64_t counter) const { return counter & (slots_.size() - 1); }
  std::size_t next(std::size_t at) const { return (at + 1) & (slots_.size() - 1); }

  void place(Slot slot) {
    std::size_t at = home(slot.counter);
    while (slots_[at].counter != 0) at = next(at);
    slots_[at] = std::move(slot);
  }

  void grow() {
    std::vector<Slot> old(slots_.size() * 2);
    old.swap(slots_);
    for (auto& slot : old) {
      if (slot.counter != 0) place(std::move(slot));
    }
  }

  /// Fills the gap that a removed call left. Moves up each call after `gap` that was displaced from
  /// its hash slot because that slot was occupied.
  void close_gap(std::size_t gap) {
    for (std::size_t at = next(gap); slots_[at].counter != 0; at = next(at)) {
      const std::size_t distance_home = (at - home(slots_[at].counter)) & (slots_.size() - 1);
      const std::size_t distance_gap = (at - gap) & (slots_.size() - 1);
      if (distance_home < distance_gap) continue;
      slots_[gap] = std::move(slots_[at]);
      slots_[at] = {};
      gap = at;
    }
  }

  std::vector<Slot> slots_;
  std::size_t size_ = 0;
};

template <class Call>
std::vector<std::pair<std::uint64_t, std::shared_ptr<Call>>> CallTable<Call>::all() const {
  std::vector<std::pair<std::uint64_t, std::shared_ptr<Call>>> calls;
  for (const auto& slot : slots_) {
    if (slot.counter != 0) calls.emplace_back(slot.counter, slot.call);
  }
  std::sort(calls.begin(), calls.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  return calls;
}

template <class Call>
std::vector<std::pair<std::uint64_t, std::shared_ptr<Call>>> CallTable<Call>::take_all() {
  auto calls = all();
  for (auto& slot : slots_) slot = {};
  size_ = 0;
  return calls;
}

}  // namespace gecos::session
