#include "gecos/session/server/blend_chain.hpp"

#include <algorithm>
#include <utility>

namespace gecos::session {
namespace {

/// Returns the detail of the commands that are left out because an earlier command ended with the
/// detail `cause`. After NOT_STARTED, the commands that are left out end as NOT_STARTED, too: this
/// detail tells the caller that the command may be sent again.
Detail detail_after(Detail cause) {
  return cause == Detail::Canceled || cause == Detail::NotStarted ? cause : Detail::Rejected;
}

/// Returns the failure of the command `what`, which is left out because the command `failed` did
/// not succeed.
Failure failure_after(const BlendChain::Failed& failed, const std::string& what) {
  std::string why = std::string(to_string(failed.detail));
  if (!failed.text.empty()) why += ", " + failed.text;
  return {detail_after(failed.detail),
          what + " was not carried out, because the earlier command '" + failed.operation +
              "' of the same caller did not succeed: " + why +
              ". Look at the outcome of a failed command before you issue the next one",
          {},
          {}};
}

/// Returns whether `detail` may be the end of a command that was canceled. A canceled command may
/// end as TIMED_OUT, because its deadline may pass while the device brakes.
bool ends_a_cancel(Detail detail) {
  return detail == Detail::Canceled || detail == Detail::TimedOut;
}

}  // namespace

std::uint64_t BlendChain::Unseen::known_from() const {
  return std::min(went_on_from(), detached_from);
}

std::uint64_t BlendChain::Unseen::went_on_from() const {
  return ends_a_cancel(failed.detail) ? std::min(seen_from, canceled_from) : seen_from;
}

std::uint64_t BlendChain::Unseen::covers_up_to() const {
  const std::uint64_t from = went_on_from();
  return from == never && detached_from != never ? 0 : from;
}

void BlendChain::arrived(const Arrival& command, const ChainReport& known) {
  const bool newly_held =
      command.held_from != 0 && std::exchange(held_from_, command.held_from) != command.held_from;
  if (newly_held || command.stands_alone) begin_at(command.counter);
  for (const ChainReport::Entry& entry : known.entries) note(entry, command.counter);
}

/// Records what `entry` reports about an earlier command. The program knew this when it issued the
/// command `from`.
void BlendChain::note(const ChainReport::Entry& entry, std::uint64_t from) {
  if (Unseen* const failure = find(entry.counter)) {
    learn(*failure, entry.known, from);
  } else if (entry.known != ChainReport::Known::Failure) {
    if (expected_.size() == most_known) expected_.erase(expected_.begin());
    expected_.push_back({entry.counter, entry.known, from});
  }
}

/// Notes what the program knew of `failure` when it issued the command `from`.
void BlendChain::learn(Unseen& failure, ChainReport::Known known, std::uint64_t from) {
  std::uint64_t& since = known == ChainReport::Known::Failure    ? failure.seen_from
                         : known == ChainReport::Known::Canceled ? failure.canceled_from
                                                                 : failure.detached_from;
  since = std::min(since, from);
}

BlendChain::Unseen* BlendChain::find(std::uint64_t counter) {
  const auto at = std::ranges::find(failures_, counter,
                                    [](const Unseen& failure) { return failure.failed.counter; });
  return at == failures_.end() ? nullptr : &*at;
}

/// For the command `counter` and later commands, failures of commands before `counter` no longer
/// matter.
void BlendChain::begin_at(std::uint64_t counter) {
  begin_ = counter;
  for (Unseen& failure : failures_) {
    if (failure.failed.counter < counter) learn(failure, ChainReport::Known::Failure, counter);
  }
}

void BlendChain::failed(Failed failed) {
  const std::uint64_t counter = failed.counter;
  // If the command was canceled while it ran, the failure was noted at the cancel.
  if (Unseen* const before = find(counter)) {
    before->failed = std::move(failed);
    return;
  }
  if (failures_.size() >= most_known) drop_known();
  // The failure that is dropped here is not needed: an earlier failure, which the program does not
  // know, leaves out the same commands.
  if (failures_.size() >= most_known) failures_.pop_back();
  Unseen failure{std::move(failed)};
  if (counter < begin_) failure.seen_from = begin_;
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

/// Drops a failure that the program knows, and the later failures that this failure covers
/// (covers_up_to). The dropped failures mattered only for commands that were issued before the
/// program knew the failure, and these commands were left out when the failure was noted.
void BlendChain::drop_known() {
  const auto known = std::ranges::find_if(
      failures_, [](const Unseen& failure) { return failure.known_from() != never; });
  if (known == failures_.end()) return;
  const std::uint64_t from = known->failed.counter;
  const std::uint64_t up_to = std::max(known->covers_up_to(), from + 1);
  std::erase_if(failures_, [&](const Unseen& failure) {
    return failure.failed.counter >= from && failure.failed.counter < up_to;
  });
}

std::optional<BlendChain::LeftOut> BlendChain::left_out(std::uint64_t counter,
                                                        const std::string& what) const {
  std::uint64_t covered = 0;  // failures of commands with lower counters do not matter
  for (const Unseen& failure : failures_) {
    // This failure does not matter: its command would have been left out anyway because of an
    // earlier failure, and the program has since continued although it knew the earlier failure.
    if (failure.failed.counter < covered) continue;
    if (failure.failed.counter < counter && counter < failure.known_from()) {
      return LeftOut{failure.failed.counter, failure_after(failure.failed, what)};
    }
    covered = std::max(covered, failure.covers_up_to());
  }
  return std::nullopt;
}

}  // namespace gecos::session
