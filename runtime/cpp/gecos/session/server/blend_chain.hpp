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

/// Decides which commands with @on_new("blend") of one session are left out because an earlier one
/// did not succeed.
///
/// When such a command does not succeed, the later ones of its client are not carried out: an arm
/// would go to their goals on a path that nobody asked for and that nobody checked. This includes
/// commands that arrive after the failure. A command is carried out only if its program, when it
/// issued the command, knew each failure before it. The client reports what its program knows with
/// the command (ChainReport). Under a newly acquired status nothing earlier counts. Reads no clock
/// and knows no thread.
class BlendChain {
 public:
  /// A command that did not succeed, and was not left out because of another one.
  struct Failed {
    std::uint64_t counter = 0;
    std::string operation;  ///< for example "move"
    Detail detail{};
    std::string text;
  };
  /// A command that is left out, and the counter of the failed command that is the reason.
  struct LeftOut {
    std::uint64_t because_of = 0;
    Failure failure;
  };

  /// An actor command that arrives, as its client sent it.
  struct Arrival {
    std::uint64_t counter = 0;
    /// The epoch at which the session acquired the status of the command; 0 if the command has an
    /// earlier status, or none.
    std::uint64_t held_from = 0;
    /// The client has stopped the object before: no earlier command counts.
    bool stands_alone = false;
  };
  /// Notes an arrival, with what the client reports. Must be called for the actor commands of the
  /// session in the order in which the client issued them.
  void arrived(const Arrival& command, const ChainReport& known);
  /// Notes that the command `failed` did not succeed.
  void failed(Failed failed);
  /// Notes that the command `counter` succeeded.
  void succeeded(std::uint64_t counter) {
    if (!expected_.empty()) forget(counter);
  }
  /// Returns whether a failure is noted, so that `left_out` may return one.
  bool broken() const { return !failures_.empty(); }
  /// Returns why the command `counter` is left out; nullopt if it may be carried out. `what` names
  /// the command, for example "'move' of RX90".
  std::optional<LeftOut> left_out(std::uint64_t counter, const std::string& what) const;

 private:
  static constexpr std::uint64_t never = std::numeric_limits<std::uint64_t>::max();
  static constexpr std::size_t most_known = 256;  ///< failures, and ends that are expected

  struct Unseen {
    Failed failed;
    // The first command that was issued when the program had seen the failure, had canceled the
    // command, or had detached it.
    std::uint64_t seen_from = never, canceled_from = never, detached_from = never;

    /// Returns the first command that was issued when the program knew the failure.
    std::uint64_t known_from() const;
    /// Returns the first command that was issued when the program went on in view of the failure.
    std::uint64_t went_on_from() const;
    /// Returns the first command before which other failures do not count, because those commands
    /// would have been left out because of this one.
    std::uint64_t covers_up_to() const;
  };
  /// The program knows the end that this command will have. One of a command that had an end before
  /// is never needed.
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

  std::uint64_t begin_ = 0;  ///< commands before this one do not count for it and later ones
  std::uint64_t held_from_ = 0;
  std::vector<Unseen> failures_;  ///< in the order of their counters
  std::vector<Expected> expected_;
};

}  // namespace gecos::session
