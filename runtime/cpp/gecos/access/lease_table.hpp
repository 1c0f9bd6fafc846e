#pragma once

#include <cstdint>
#include <map>
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

/// The client of a session, as refusals and lists of holders show it.
struct Client {
  std::string user;
  std::string host;
  std::string program;
  std::int32_t pid = 0;
};

/// A holder of actor or master status: one entry of the list of holders.
struct Holder {
  SessionId session{};
  Status status = Status::Actor;
  Client client;
  TimePoint since{};
  /// The time at which the holder loses the status unless it is heard before. Unused while
  /// `releasing`.
  TimePoint expires{};
  bool releasing = false;   ///< the status was released, but the last commands under it still run
  bool taken_over = false;  ///< this holder has taken over: the commands of the others are refused
  TimePoint taken_over_since{};  ///< used while `taken_over`
};
/// Returns a text such as "actor status is held by ada on lab1 (grip_block, pid 4711) for 3.2 s;
/// the program of ada loses the status if it stays silent for 0.4 s more".
std::string describe(const Holder& holder, TimePoint now);

/// A granted status. Commands issued under it contain its epoch.
struct Grant {
  Status status = Status::Sensor;
  Epoch epoch{};
};

/// Why a status was refused, and which clients hold it.
struct LeaseRefusal {
  enum class Reason : std::uint8_t { HeldByOther, WrongPassword };
  Reason reason = Reason::HeldByOther;
  std::string text;
  std::vector<Holder> holders;
};

/// Why a command may not be queued or started.
struct Denial {
  enum class Reason : std::uint8_t {
    NeedsStatus,   ///< the session lacks the status that the operation needs
    OthersMaster,  ///< another client is master, so all others are refused
    LeaseEnded,    ///< the command was issued under a status that has ended
    Stopped,       ///< the command was issued under a status that a stop ended
    HeldOff,       ///< another holder of the shared status has taken over
    Preempted,     ///< the command was issued before another holder took over
  };
  Reason reason = Reason::NeedsStatus;
  std::string text;  ///< a text to append to the name of the operation, for example "needs actor
                     ///< status; …"
};

/// Decides who may command one object. Every client may read; moving needs a lease.
///
/// A lease ends when its holder releases it, is lost, or stays silent for `ttl`, so a crashed
/// client cannot lock a robot forever. The caller passes the current time. Reads no clock and does
/// no I/O.
///
/// A command that was issued under an older epoch than the current one does not start. The epoch
/// rises at every stop, at every take-over and whenever the last holder leaves. It does not rise
/// when a holder joins, or when one of several holders leaves. The holder that takes over keeps the
/// commands that it issued under the older epoch. Epochs of two incarnations of a server differ. No
/// epoch is 0.
///
/// One holder of a shared status can take over. Until it gives back, or its lease ends for any
/// reason, only its commands are queued and started; the leases of the others continue. A command
/// that another holder issued before the take-over never starts, not even after the take-over.
class LeaseTable {
 public:
  LeaseTable(IncarnationId incarnation, Duration ttl);

  /// Grants actor or master status to `session`. A session that has a status already keeps it, or
  /// gets `wanted` if `wanted` is higher. A session must release a status as often as it acquired
  /// the status. A session that gives the password of the first holder joins the holders. @pre
  /// `wanted` is not Sensor, which needs no lease.
  tl::expected<Grant, LeaseRefusal> acquire(SessionId session, const Client& client, Status wanted,
                                            const Proof& password, TimePoint now);

  /// Returns whether `acquire` by `session` would compare the given password with the password of
  /// the holders.
  bool compares_password(SessionId session) const;

  /// Returns the refusal for a session that has released its status and requests `wanted` again
  /// while other clients wait for a status.
  LeaseRefusal refusal_to_return(Status wanted, TimePoint now) const;

  /// Must be called at each sign of life of `session`. Does nothing when the session is no holder.
  void renew(SessionId session, TimePoint now);

  enum class Commands : std::uint8_t { None, Pending };
  /// Releases a status that was acquired under `epoch`. Does nothing when `epoch` is not the
  /// current epoch. A session with pending commands becomes `releasing` until `drained` is called:
  /// its commands still start and finish, and no other client gets a lease. Returns true when the
  /// session no longer holds any status.
  bool release(SessionId session, Epoch epoch, Commands commands);
  /// Must be called when the last command of a releasing session has ended.
  void drained(SessionId session);

  /// Ends the lease of a session at once, because the session was lost. Does nothing when the
  /// session is releasing: its last commands may still finish. Returns true when a lease was lost.
  bool lose(SessionId session);
  /// Ends the lease of every holder that was silent for `ttl`. Returns these holders, unsorted.
  std::vector<Holder> expire(TimePoint now);
  /// Ends every lease except the lease of `by`, which continues under the new epoch. Returns the
  /// holders that lost their leases. A call that was issued before the stop but arrives after it is
  /// denied with `reason` and the text `why`.
  std::vector<Holder> stop(SessionId by, const std::string& why,
                           Denial::Reason reason = Denial::Reason::Stopped);
  /// Gives `session` sole command of the status that it shares, until `give_back` or the end of its
  /// lease. Does nothing when the session has taken over already. Fails when the session holds no
  /// status or has released it, or when another holder has taken over.
  tl::expected<void, LeaseRefusal> take_over(SessionId session, TimePoint now);
  /// Ends the take-over by `session`. Does nothing, and returns false, when the session has not
  /// taken over.
  bool give_back(SessionId session);

  /// Forgets why `session` lost its status. Must be called when no further call of the session can
  /// arrive.
  void forget(SessionId session);

  /// Returns whether a command of `session` may be queued. The command needs the status `needed`
  /// and was issued under `epoch`.
  tl::expected<void, Denial> may_queue(SessionId session, Epoch epoch, Status needed,
                                       TimePoint now) const;
  /// Returns whether a command of `session` may start now. The conditions are those of may_queue,
  /// except that commands of a releasing session may still start.
  tl::expected<void, Denial> may_start(SessionId session, Epoch epoch, Status needed,
                                       TimePoint now) const;

  std::vector<Holder> roster() const;  ///< the holders, in the order in which they acquired the
                                       ///< status
  Epoch epoch() const;
  /// Returns the status that the session holds; Sensor when it holds none.
  Status status_of(SessionId session) const;
  bool releasing(SessionId session) const;

 private:
  struct Member {
    Holder holder;
    std::uint32_t claims = 1;  ///< how many acquisitions are not released yet
    /// The epoch under which this holder acquired the status, or the epoch that began when this
    /// holder stopped the object.
    Epoch first{};
    /// Commands that this holder issued under an epoch before `fence` were preempted by a
    /// take-over. `fence` is at least `first`.
    Epoch fence{};
    std::string preempted_by{};  ///< the client whose take-over preempted those commands
    TimePoint preempted_at{};
  };
  /// A std::map, because every command looks up its session here: with few holders, comparing keys
  /// costs less than computing a hash.
  using Members = std::map<SessionId, Member>;
  /// Why a session lost its last status: the session was silent for too long, or stop() ended the
  /// status.
  struct Loss {
    Epoch first;  ///< the first epoch in which the session held the status
    Epoch last;   ///< the last epoch in which the session held the status
    Denial::Reason reason = Denial::Reason::LeaseEnded;
    std::string why;
  };
  const Member* find(SessionId session) const;
  void remove(Members::iterator member);
  LeaseRefusal refuse(LeaseRefusal::Reason reason, std::string_view why, TimePoint now) const;
  bool was_issued_under(const Loss& loss, Epoch epoch, const Member* member) const;
  bool current(const Member* member, SessionId session, Epoch epoch) const;
  Denial ended(const Member* member, SessionId session, Epoch epoch, Status needed,
               TimePoint now) const;
  tl::expected<void, Denial> authorise(const Member* member, SessionId session, Epoch epoch,
                                       Status needed, TimePoint now) const;

  const IncarnationId incarnation_;
  const Duration ttl_;
  std::uint32_t changes_ = 1;
  Members members_;    ///< the holders, which all have the same status
  SessionId taker_{};  ///< the holder that has taken over; SessionId{} when none has
  std::unordered_map<SessionId, Loss> losses_;
  Proof password_;
};

}  // namespace gecos::access
