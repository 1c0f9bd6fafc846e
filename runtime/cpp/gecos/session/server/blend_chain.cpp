#include "gecos/session/server/blend_chain.hpp"

#include <utility>

namespace gecos::session {
namespace {

/// Returns the detail of the commands that are left out after an end as `cause`. NOT_STARTED stays
/// NOT_STARTED, because it promises the caller that the command may be sent again.
Detail detail_after(Detail cause) {
  return cause == Detail::Canceled || cause == Detail::NotStarted ? cause : Detail::Rejected;
}

}  // namespace

void BlendChain::arrived(std::uint64_t counter, std::uint64_t held_from, Begin begin) {
  if (std::exchange(held_from_, held_from) != held_from) begin = Begin::Alone;
  last_ = counter;
  if (begin != Begin::No) {
    first_ = counter;
    failed_.reset();
    if (ahead_ && ahead_->counter < counter) ahead_.reset();
  }
  if (begin == Begin::Alone) oldest_ = counter;
  if (!ahead_ || ahead_->counter >= counter) return;
  if (!failed_) failed_ = std::move(ahead_);
  ahead_.reset();
}

void BlendChain::broke(std::uint64_t first, Failed failed) {
  const bool rests_on_it = first >= oldest_ && failed.detail != Detail::Canceled;
  if (first != first_ && !rests_on_it) return;
  std::optional<Failed>& earliest = failed.counter > last_ ? ahead_ : failed_;
  if (!earliest || failed.counter < earliest->counter) earliest = std::move(failed);
}

std::optional<Failure> BlendChain::left_out(std::uint64_t first, std::uint64_t counter,
                                            const std::string& what) const {
  if (first != first_) return std::nullopt;
  for (const auto* const failed : {&failed_, &ahead_}) {
    if (*failed && counter > (*failed)->counter) return left_out_because_of(**failed, what);
  }
  return std::nullopt;
}

Failure left_out_because_of(const BlendChain::Failed& failed, const std::string& what) {
  std::string why = std::string(to_string(failed.detail));
  if (!failed.text.empty()) why += ", " + failed.text;
  return {detail_after(failed.detail),
          what + " was not carried out, because '" + failed.operation +
              "', which the same caller had called before it, did not succeed: " + why +
              ". Look at the outcome of a failed command before you issue the next one",
          {},
          {}};
}

}  // namespace gecos::session
