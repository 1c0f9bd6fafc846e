#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "gecos/access/proof.hpp"
#include "gecos/access/status.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/ids.hpp"
#include "gecos/base/result.hpp"

namespace gecos::access {

/// The client of a session, as refusals and rosters show it.
struct Client {
  std::string user;
  std::string host;
  std::string program;
  std::int32_t pid = 0;
};

/// One line of the roster.
struct Holder {
  SessionId session{};
  Status status = Status::Actor;
  Client client;
  TimePoint since{};
  TimePoint expires{};     ///< when it is lost if it stays silent; means nothing while releasing
  bool releasing = false;  ///< given back; its last commands still run
};
/// "actor status is held by ada on lab1 (grip_block, pid 4711) for 3.2 s, lost in 0.4 s if silent".
std::string describe(const Holder& holder, TimePoint now);

/// Status that was given. Commands issued under it carry the epoch.
struct Grant {
  Status status = Status::Sensor;
  Epoch epoch{};
};

/// Why status was not given, and who has it.
struct LeaseRefusal {
  enum class Reason : std::uint8_t { HeldByOther, WrongPassword };
  Reason reason = Reason::HeldByOther;
  std::string text;
  std::vector<Holder> holders;
};

/// Why a command may not be queued or started.
struct Denial {
  enum class Reason : std::uint8_t {
    NeedsStatus,   ///< the session does not hold what the operation asks for
    OthersMaster,  ///< somebody else is master, and refuses everybody
    LeaseEnded,    ///< it was issued under a status that has ended since
    Stopped,       ///< likewise, and a stop ended that status
  };
  Reason reason = Reason::NeedsStatus;
  std::string text;  ///< goes on after what was refused: "needs actor status; …"
};

/// Decides who may command one object. Every client may read; moving needs a lease.
///
/// A lease ends when its holder releases it, is lost, or stays silent for `ttl`, so a crashed
/// client cannot lock a robot forever. Time is passed in: no clock, no I/O, tests need no sleep.
///
/// The epoch fences commands: it rises whenever the object becomes free and at stop, and what was
/// issued under an older one does not start. It does not rise when a holder joins or one of several
/// leaves. Epochs of two server lives differ; 0 is never one.
class LeaseTable {
 public:
  LeaseTable(IncarnationId incarnation, Duration ttl);

  /// Gives `session` actor or master status. A session that has it already keeps it, raised to
  /// `wanted`, and has to release it once more. Others join with the password of the first holder.
  /// @pre `wanted` is not Sensor: that needs no lease.
  tl::expected<Grant, LeaseRefusal> acquire(SessionId session, const Client& client, Status wanted,
                                            const Proof& password, TimePoint now);

  /// A sign of life of `session`, holder or not.
  void renew(SessionId session, TimePoint now);

  enum class Commands : std::uint8_t { None, Pending };
  /// Gives back what was acquired under `epoch`; a stale epoch changes nothing. With commands still
  /// pending it is RELEASING: they start and finish, and no other client gets a lease, until
  /// `drained`. True when the session holds nothing any more.
  bool release(SessionId session, Epoch epoch, Commands commands);
  /// The last command of a releasing session has ended.
  void drained(SessionId session);

  /// The session is gone without a word, revoked, or gave up at once: its share ends now. A
  /// releasing one goes on draining, for it was given back in order. True when something was lost.
  bool lose(SessionId session);
  /// Ends the share of everybody silent for the TTL and names them, in no order.
  std::vector<Holder> expire(TimePoint now);
  /// Ends every lease but that of `by`, which goes on under the new epoch. Names those who lost
  /// theirs. A call issued before that arrives later is denied as Stopped, with `why`.
  std::vector<Holder> stop(SessionId by, const std::string& why);
  /// Nothing of `session` arrives any more.
  void forget(SessionId session);

  /// May `session` have a command queued that needs `needed` and was issued under `epoch`?
  tl::expected<void, Denial> may_queue(SessionId session, Epoch epoch, Status needed,
                                       TimePoint now) const;
  /// May it start now? As may_queue, but a releasing session's commands still may.
  tl::expected<void, Denial> may_start(SessionId session, Epoch epoch, Status needed,
                                       TimePoint now) const;

  std::vector<Holder> roster() const;  ///< holders, the longest first
  Epoch epoch() const;
  /// The status that the session holds; at least Sensor.
  Status status_of(SessionId session) const;
  bool releasing(SessionId session) const;

 private:
  struct Member {
    Holder holder;
    std::uint32_t claims = 1;  ///< how often it acquired and did not release
  };
  using Members = std::unordered_map<SessionId, Member>;
  /// How a session lost what it held last, while others held on or a stop came.
  struct Loss {
    Epoch epoch;
    Denial::Reason reason = Denial::Reason::LeaseEnded;
    std::string why;
  };
  const Member* find(SessionId session) const;
  void remove(Members::iterator member);
  LeaseRefusal refuse(LeaseRefusal::Reason reason, std::string_view why, TimePoint now) const;
  tl::expected<void, Denial> authorise(const Member* member, SessionId session, Epoch epoch,
                                       Status needed, TimePoint now) const;

  const IncarnationId incarnation_;
  const Duration ttl_;
  std::uint32_t changes_ = 1;
  Members members_;  ///< all of one status
  std::unordered_map<SessionId, Loss> losses_;
  Proof password_;
};

}  // namespace gecos::access
