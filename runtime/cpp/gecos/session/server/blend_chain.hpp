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
/// checked. This includes commands that arrive after the failure.
///
/// A call that its client marks with `begins_anew` begins the next chain. Commands of earlier
/// chains that are still open bind the new chain, too, because the program has not seen how they
/// end. Only the end of one that its client cancels does not. A call that is marked with
/// `stands_alone`, and a newly acquired status, begin a chain that nothing earlier binds. Reads no
/// clock and knows no thread.
class BlendChain {
 public:
  /// A command of the chain that did not succeed.
  struct Failed {
    std::uint64_t counter = 0;
    std::string operation;  ///< for example "move"
    Detail detail{};
    std::string text;
  };

  /// How a call begins a chain, as its client marks it.
  enum class Begin { No, Anew, Alone };

  /// Notes that an actor command arrived. Must be called for the actor commands of the session in
  /// the order in which the client issued them. `held_from`: the epoch at which the session
  /// acquired its status.
  void arrived(std::uint64_t counter, std::uint64_t held_from, Begin begin);
  /// Returns the counter of the command that began the current chain; 0 for the first chain.
  std::uint64_t first() const { return first_; }
  /// Returns the counter of the command that began the earliest chain on which the current one
  /// rests.
  std::uint64_t oldest() const { return oldest_; }
  /// Notes that `failed`, a command of the chain that began with `first`, did not succeed. The
  /// earliest failure counts, and the earliest one of a command that has not arrived in its turn.
  void broke(std::uint64_t first, Failed failed);
  /// Returns whether a failure is noted, so that `left_out` may return one.
  bool broken() const { return failed_ || ahead_; }
  /// Returns why the command `counter` of the chain that began with `first` is left out; nullopt if
  /// it may be carried out. `what` names the command, for example "'move' of RX90".
  std::optional<Failure> left_out(std::uint64_t first, std::uint64_t counter,
                                  const std::string& what) const;

 private:
  std::uint64_t first_ = 0;
  std::uint64_t oldest_ =
      0;                    ///< the first command of the earliest chain that binds the current one
  std::uint64_t last_ = 0;  ///< the command that arrived last
  std::uint64_t held_from_ = 0;
  std::optional<Failed> failed_;
  std::optional<Failed> ahead_;  ///< failed before those arrived that were issued before it
};

/// Returns the failure of `what`, a command that is left out because of `failed`.
Failure left_out_because_of(const BlendChain::Failed& failed, const std::string& what);

}  // namespace gecos::session
