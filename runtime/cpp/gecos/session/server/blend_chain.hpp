#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/command.hpp"
#include "gecos/session/protocol/chain_report.hpp"

namespace gecos::session {

/// Decides which commands with @on_new("blend") of one session are left out, that is, not carried
/// out, because an earlier command did not succeed.
///
/// When a command with @on_new("blend") does not succeed, the later commands of its client are not
/// carried out. Otherwise an arm would move to the goals of the later commands on a path that
/// nobody asked for and nobody checked. This applies also to commands that arrive after the
/// failure. A command is carried out only if the program knew every earlier failure when it issued
/// the command; with the command, the client reports what the program knew (ChainReport). Failures
/// under an earlier status do not matter after the session has acquired the status anew. Reads no
/// clock. Not thread-safe.
class BlendChain {
 public:
  /// A command that failed for a reason of its own. A command that was not carried out because an
  /// earlier command had failed is none of these.
  struct Failed {
    std::uint64_t counter = 0;
    std::string operation;  ///< for example "move"
    Detail detail{};
    std::string text;
  };
  /// Why a command is left out: the counter of the failed command that is the reason, and the
  /// failure that the client gets.
  struct LeftOut {
    std::uint64_t because_of = 0;
    Failure failure;
  };

  /// An actor command that has arrived, as its client sent it.
  struct Arrival {
    std::uint64_t counter = 0;
    /// The epoch at which the session acquired the status under which the command was issued; 0 if
    /// the session has no status or if the command was issued under an earlier status.
    std::uint64_t held_from = 0;
    /// The client has stopped the object before this command, so failures of earlier commands do
    /// not matter for this command.
    bool stands_alone = false;
  };
  /// Notes that `command` has arrived, and what the client reports with it in `known`. Must be
  /// called for the actor commands of the session in the order in which the client issued them.
  void arrived(const Arrival& command, const ChainReport& known);
  /// Notes that the command `failed` did not succeed.
  void failed(Failed failed);
  /// Notes that the command `counter` succeeded.
  void succeeded(std::uint64_t counter) {
    if (!expected_.empty()) forget(counter);
  }
  /// Returns whether a failure is noted. If none is noted, `left_out` always returns nullopt.
  bool broken() const { return !failures_.empty(); }
  /// Returns why the command `counter` is left out; nullopt if it may be carried out. `what` names
  /// the command, for example "'move' of RX90".
  std::optional<LeftOut> left_out(std::uint64_t counter, const std::string& what) const;

 private:
  static constexpr std::uint64_t never = std::numeric_limits<std::uint64_t>::max();
  /// Maximum number of elements of `failures_`, and of elements of `expected_`.
  static constexpr std::size_t most_known = 256;

  struct Unseen {
    Failed failed;
    // Each of the following members is the counter of the first command that the program issued
    // after an event: after it had seen the failure, had canceled the failed command, or had
    // detached the failed command.
    std::uint64_t seen_from = never, canceled_from = never, detached_from = never;

    /// Returns the counter of the first command that the program issued after it had learned of the
    /// failure in any of these three ways.
    std::uint64_t known_from() const;
    /// Returns the counter of the first command by which the program has decided to continue: the
    /// first command that the program issued after it had seen the failure. If the failed command
    /// ended because the program canceled it, a command that was issued after the cancel counts,
    /// too.
    std::uint64_t went_on_from() const;
    /// Returns the counter of the first command whose own failure matters in addition to this
    /// failure. The commands before it would have been left out because of this failure.
    std::uint64_t covers_up_to() const;
  };
  /// What the program reported about a command that has not failed so far: the program has canceled
  /// or detached the command. When the command ends, this report is no longer needed.
  struct Expected {
    std::uint64_t counter = 0;
    ChainReport::Known known{};
    std::uint64_t known_from = 0;
  };
  void begin_at(std::uint64_t counter);
  void note(const ChainReport::Entry& entry, std::uint64_t from);
  static void learn(Unseen& failure, ChainReport::Known known, std::uint64_t from);
  Unseen* find(std::uint64_t counter);
  void forget(std::uint64_t counter);
  void drop_known();

  /// The counter of a command. Failures of earlier commands do not matter for this command and for
  /// later commands.
  std::uint64_t begin_ = 0;
  std::uint64_t held_from_ = 0;
  std::vector<Unseen> failures_;  ///< in the order of their counters
  std::vector<Expected> expected_;
};

}  // namespace gecos::session
