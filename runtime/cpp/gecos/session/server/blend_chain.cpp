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

void BlendChain::arrived(std::uint64_t counter, Epoch epoch, bool anew) {
  if (!anew && epoch <= epoch_) return;
  first_ = counter;
  epoch_ = epoch;
  if (failed_ && failed_->counter < counter) failed_.reset();
}

void BlendChain::broke(std::uint64_t first, Failed failed) {
  if (first != first_ || (failed_ && failed_->counter <= failed.counter)) return;
  failed_ = std::move(failed);
}

std::optional<Failure> BlendChain::left_out(std::uint64_t first, std::uint64_t counter,
                                            const std::string& what) const {
  if (!failed_ || first != first_ || counter <= failed_->counter) return std::nullopt;
  return left_out_because_of(*failed_, what);
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
