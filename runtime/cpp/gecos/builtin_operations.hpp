#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/checked_result.hpp"
#include "gecos/object.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl

/// The built-in operations of every object, as free functions: an interface may use the same names.
namespace gecos {

/// Actor or master status of one object, held by this session. A lease ends when it is released or
/// lost; its destructor calls `release()`. Move-only.
///
/// A release waits at most one second for the server's reply. Other clients can then acquire the
/// status as soon as the commands issued under this lease have ended. Commands that are issued
/// later without another lease end as DENIED. A lease logs a warning when it is destroyed while it
/// is `fresh()`: the program probably did not keep it.
class [[nodiscard("keep the lease: its destructor releases the status")]] Lease {
 public:
  Lease(std::shared_ptr<session::ClientSession> session, Grant grant);
  Lease(Lease &&) noexcept = default;
  Lease& operator=(Lease&&) noexcept;
  ~Lease();

  Status status() const { return grant_.status; }
  std::uint64_t epoch() const { return grant_.epoch; }
  /// Releases the status; queued and running commands still finish.
  void release();
  /// Releases the status and stops the commands that are queued and running under it.
  void release_now();
  /// Returns true when the lease was acquired less than 100 ms ago and the program has issued no
  /// call since.
  bool fresh() const;
  /// Returns whether the status is certainly lost: the session has ended, or has acquired another
  /// status since. False after a release, and while the program cannot know: that another client
  /// has stopped the object shows only at the end of a command.
  bool lost() const;

 private:
  void send_release(bool now);

  std::shared_ptr<session::ClientSession> session_;
  Grant grant_;
  std::uint64_t held_;    ///< the result of ClientSession::lease_acquired
  std::uint64_t issued_;  ///< number of calls that the program had issued before the lease
  TimePoint since_;
};

/// The reason for which the server refused actor or master status.
struct LeaseRefusal {
  Failure failure;
  std::vector<Holder> holders;  ///< the present holders, each with the times of its status
};
std::ostream& operator<<(std::ostream& out, const LeaseRefusal& refusal);

/// Options for acquiring a status.
struct LeaseOptions {
  std::string password{};  ///< clients that pass the same password share the status
  /// How long to wait while other clients hold the status. Waiting requests are granted in the
  /// order of their arrival. Zero: do not wait. Duration::max(): wait without limit.
  Duration timeout{};
  /// Called on the thread that acquires the status: when the wait begins, and whenever the number
  /// of requests before this one changes. `before` is that number.
  std::function<void(std::uint32_t before)> on_position{};
};

/// Acquires actor status, which allows commands that move or change the device. Clients that pass
/// the same `password` share the status.
[[nodiscard("keep the lease: its destructor releases the status")]] Checked<Lease, LeaseRefusal>
actor(const Object& object, std::string password = {});
/// Like the overload above, but can wait while other clients hold the status, for example
/// `gecos::actor(*robot, {.timeout = 10s})`. A `stop` of the object ends the wait with a refusal. A
/// server that was built before this option existed refuses at once.
[[nodiscard("keep the lease: its destructor releases the status")]] Checked<Lease, LeaseRefusal>
actor(const Object& object, const LeaseOptions& options);
void actor(std::string_view name) = delete;  // give a proxy, from lab.create
/// Acquires master status. It gives the rights of actor status, and the server refuses the calls of
/// all other clients.
[[nodiscard("keep the lease: its destructor releases the status")]] Checked<Lease, LeaseRefusal>
master(const Object& object, std::string password = {});
[[nodiscard("keep the lease: its destructor releases the status")]] Checked<Lease, LeaseRefusal>
master(const Object& object, const LeaseOptions& options);
void master(std::string_view name) = delete;  // takes a proxy, as gecos::actor does

/// Stops the object for all clients: ends every lease except those of this session, removes all
/// queued commands and interrupts the running ones.
Command<void> stop(const Object& object);
/// Takes sole command of a status that this session shares with others by password. Their running
/// and queued commands end PREEMPTED, their later ones DENIED and their samples have no effect,
/// until `give_back` or until the status of this session ends. Stops no command of this session.
/// Fails as FAULT (StatusRefused) when this session has no status or another client has taken over.
Command<void> take_over(const Object& object);
/// Ends the take-over of this session: the others may command again. No command that ended is
/// started again. Does nothing without a take-over.
Command<void> give_back(const Object& object);
/// Returns the requests for a status that wait in line (LeaseOptions::timeout), in the order of
/// their arrival. The command ends when one of them has a larger id than `after`, at the latest
/// after `timeout`, so that a holder can be called when another program asks:
/// `gecos::requests(*robot, last, 60s).then(…)`. To grant a request, release the lease: the first
/// in line gets the status when the last command has ended.
Command<std::vector<WaitingRequest>> requests(const Object& object, std::uint64_t after = 0,
                                              Duration timeout = {});
/// Refuses the request with the id `request`, which waits. Its program gets a LeaseRefusal that
/// names this program and says `why`. Finishes with false when the request waits no longer. Fails
/// as FAULT (StatusRefused) when this session does not hold the status.
Command<bool> deny(const Object& object, std::uint64_t request, const std::string& why = {});
/// Ends every status of the object, as an administrator: the user of the server, root, or a user
/// whom `[admin]` of the lab file names. The commands of the holders end LEASE_LOST, with `why` and
/// the name of this program; the first request in line gets the status. A program must not do this
/// by itself: `gecos break` is for persons. Fails as FAULT (StatusRefused) for all others.
Command<void> break_status(const Object& object, const std::string& why);
Command<void> ping(const Object& object);
Command<Description> describe(const Object& object);
Command<std::vector<Holder>> holders(const Object& object);
/// Returns what the object has counted since it is served: the calls of each operation and of each
/// open session by outcome, the times of handlers, and the samples of each stream. Its counts are
/// those of the server: what a reader of a stream lost is in `Stream::counts`, and the latency of a
/// connection in `line_state`. A server that was built before this operation existed answers
/// UNKNOWN_OPERATION.
Command<ObjectStats> stats(const Object& object);
/// Returns the object's interface and each of its bases as JSON, for clients without generated
/// code.
Command<std::vector<std::string>> model(const Object& object);

/// The outcome of a command that has ended, or the present state of a command that has not.
struct Outcome {
  Detail detail = Detail::OutcomeUnknown;
  std::string text;  ///< explains `detail`, unless it is Done
  State state() const { return project(detail); }
};
std::ostream& operator<<(std::ostream& out, const Outcome& outcome);

/// Asks, through a new proxy, for the outcome of an actor command that ended as OUTCOME_UNKNOWN.
/// The state of the `Command` object does not change. The answer NotStarted is a promise: the
/// command has not arrived at the server and will never start. Sent means that the command has not
/// arrived and may still start; ask again. OutcomeUnknown means that the server was restarted after
/// the command, or no longer keeps the outcome (a server keeps the last 1024 outcomes of each
/// object).
Command<Outcome> outcome(const Object& object, const CommandId& id);

}  // namespace gecos
