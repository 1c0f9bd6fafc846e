#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "gecos/base/ids.hpp"
#include "gecos/command.hpp"

namespace gecos::session {

/// Decides which commands with @on_new("blend") of one session are left out because an earlier one
/// did not succeed.
///
/// A chain is what a client issues before its program has seen the failure of a command of the
/// chain. When a command of a chain does not succeed, the later commands of the chain are not
/// carried out: an arm would go to their goals on a path that nobody asked for and that nobody
/// checked. This includes commands that arrive after the failure. A call that its client marks with
/// `begins_anew`, and a call under a newer epoch, begins the next chain. Reads no clock and knows
/// no thread.
class BlendChain {
 public:
  /// A command of the chain that did not succeed.
  struct Failed {
    std::uint64_t counter = 0;
    std::string operation;  ///< for example "move"
    Detail detail{};
    std::string text;
  };

  /// Notes that an actor command arrived. Must be called for the actor commands of the session in
  /// the order in which the client issued them. `anew`: the call has the flag `begins_anew`.
  void arrived(std::uint64_t counter, Epoch epoch, bool anew);
  /// Returns the counter of the command that began the current chain; 0 for the first chain.
  std::uint64_t first() const { return first_; }
  /// Notes that `failed`, a command of the chain that began with `first`, did not succeed. Only the
  /// earliest failure of the current chain counts.
  void broke(std::uint64_t first, Failed failed);
  /// Returns why the command `counter` of the chain that began with `first` is left out; nullopt if
  /// it may be carried out. `what` names the command, for example "'move' of RX90".
  std::optional<Failure> left_out(std::uint64_t first, std::uint64_t counter,
                                  const std::string& what) const;

 private:
  std::uint64_t first_ = 0;
  Epoch epoch_{};
  std::optional<Failed> failed_;
};

/// Returns the failure of `what`, a command that is left out because of `failed`.
Failure left_out_because_of(const BlendChain::Failed& failed, const std::string& what);

}  // namespace gecos::session
