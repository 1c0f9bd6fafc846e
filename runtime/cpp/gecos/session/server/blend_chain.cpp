#include "gecos/session/server/blend_chain.hpp"

#include <algorithm>
#include <utility>

namespace gecos::session {
namespace {

/// Returns the detail of the commands that are left out after an end as `cause`. NOT_STARTED stays
/// NOT_STARTED, because it promises the caller that the command may be sent again.
Detail detail_after(Detail cause) {
  return cause == Detail::Canceled || cause == Detail::NotStarted ? cause : Detail::Rejected;
}

/// Returns the failure of `what`, a command that is left out because of `failed`.
Failure failure_after(const BlendChain::Failed& failed, const std::string& what) {
  std::string why = std::string(to_string(failed.detail));
  if (!failed.text.empty()) why += ", " + failed.text;
  return {detail_after(failed.detail),
          what + " was not carried out, because '" + failed.operation +
              "', which the same caller had called before it, did not succeed: " + why +
              ". Look at the outcome of a failed command before you issue the next one",
          {},
          {}};
}

/// Returns whether a program that knows `known` of a command knows its end `detail`. A command that
/// is canceled may pass its deadline while it brakes.
bool knows(ChainReport::Known known, Detail detail) {
  return known != ChainReport::Known::Canceled || detail == Detail::Canceled ||
         detail == Detail::TimedOut;
}

}  // namespace

void BlendChain::arrived(const Arrival& command, const ChainReport& known) {
  const bool newly_held =
      command.held_from != 0 && std::exchange(held_from_, command.held_from) != command.held_from;
  if (newly_held || command.stands_alone) begin_at(command.counter);
  for (const ChainReport::Entry& entry : known.entries) note(entry, command.counter);
}

/// Notes what the program knew when it issued the command `from`.
void BlendChain::note(const ChainReport::Entry& entry, std::uint64_t from) {
  if (Unseen* const failure = find(entry.counter)) {
    learn(*failure, entry.known, from);
  } else if (entry.known != ChainReport::Known::Failure) {
    if (expected_.size() == most_known) expected_.erase(expected_.begin());
    expected_.push_back({entry.counter, entry.known, from});
  }
}

/// Notes that the program knew `known` when it issued the command `from`.
void BlendChain::learn(Unseen& failure, ChainReport::Known known, std::uint64_t from) {
  if (!knows(known, failure.failed.detail) || from >= failure.known_from) return;
  failure.known_from = from;
  failure.known = known;
}

BlendChain::Unseen* BlendChain::find(std::uint64_t counter) {
  const auto at = std::ranges::find(failures_, counter,
                                    [](const Unseen& failure) { return failure.failed.counter; });
  return at == failures_.end() ? nullptr : &*at;
}

/// From the command `counter` on, no command before it counts.
void BlendChain::begin_at(std::uint64_t counter) {
  begin_ = counter;
  for (Unseen& failure : failures_) {
    if (failure.failed.counter < counter) {
      failure.known_from = std::min(failure.known_from, counter);
    }
  }
}

void BlendChain::failed(Failed failed) {
  const std::uint64_t counter = failed.counter;
  if (Unseen* const before = find(counter)) {  // one that was canceled while it ran, and now ends
    before->failed = std::move(failed);
    if (!knows(before->known, before->failed.detail)) before->known_from = never;
    return;
  }
  if (failures_.size() >= most_known) drop_known();
  if (failures_.size() >= most_known && left_out(counter, {})) return;
  Unseen failure{std::move(failed)};
  if (counter < begin_) failure.known_from = begin_;
  for (const Expected& expected : expected_) {
    if (expected.counter == counter) learn(failure, expected.known, expected.known_from);
  }
  forget(counter);
  const auto after = std::ranges::upper_bound(failures_, counter, {},
                                              [](const Unseen& one) { return one.failed.counter; });
  failures_.insert(after, std::move(failure));
}

void BlendChain::forget(std::uint64_t counter) {
  std::erase_if(expected_, [&](const Expected& one) { return one.counter == counter; });
}

/// Keeps the number of failures small. One that the program knows matters only for the commands
/// before it knew it, which the queue had left out when the failure was noted.
void BlendChain::drop_known() {
  const auto known = std::ranges::find_if(
      failures_, [](const Unseen& failure) { return failure.known_from != never; });
  if (known != failures_.end()) failures_.erase(known);
}

std::optional<BlendChain::LeftOut> BlendChain::left_out(std::uint64_t counter,
                                                        const std::string& what) const {
  std::uint64_t bound =
      0;  // the commands before this one are left out because of an earlier failure
  for (const Unseen& failure : failures_) {
    // A command that fails where it would have been left out binds no other: who knows the earlier
    // failure goes on.
    if (failure.failed.counter < bound) continue;
    if (failure.failed.counter < counter && counter < failure.known_from) {
      return LeftOut{failure.failed.counter, failure_after(failure.failed, what)};
    }
    if (failure.known != ChainReport::Known::Detached) bound = std::max(bound, failure.known_from);
  }
  return std::nullopt;
}

}  // namespace gecos::session
