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

/// The built-in operations of every object, as free functions, so that an interface may have
/// operations of the same names.
namespace gecos {

/// Actor or master status of one object, held by this session. A lease ends when it is released or
/// lost; its destructor calls `release()`. Move-only.
///
/// release() waits at most one second for the server's reply. Other clients can then acquire the
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
  /// Releases the status, and stops the queued and running commands that were issued under it.
  void release_now();
  /// Returns true when this lease was acquired less than 100 ms ago and the program has issued no
  /// call since then.
  bool fresh() const;
  /// Returns whether the status of this lease is certainly lost: the session has ended, or has
  /// acquired another status after this one. Returns false after a release. Also returns false
  /// while the program does not know of a loss: if another client has stopped the object, the
  /// program learns of the loss only when one of its commands ends.
  bool lost() const;

 private:
  void send_release(bool now);

  std::shared_ptr<session::ClientSession> session_;
  Grant grant_;
  std::uint64_t held_;    ///< the number that ClientSession::lease_acquired returned
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
  /// How long to wait while other clients hold the status. The server grants waiting requests in
  /// the order of their arrival. Zero: do not wait. Duration::max(): wait without limit.
  Duration timeout{};
  /// Called when the wait begins, and whenever the number of requests before the request of this
  /// program changes. Runs on the thread that acquires the status. `before` is the number of these
  /// earlier requests.
  std::function<void(std::uint32_t before)> on_position{};
};

/// Acquires actor status, which allows commands that move or change the device. Clients that pass
/// the same `password` share the status.
[[nodiscard("keep the lease: its destructor releases the status")]] Checked<Lease, LeaseRefusal>
actor(const Object& object, std::string password = {});
/// Acquires actor status like actor(object, password), but can wait while other clients hold the
/// status, for example `gecos::actor(*robot, {.timeout = 10s})`. A `stop` of the object ends the
/// wait with a refusal. A server that was built before this option existed refuses at once.
[[nodiscard("keep the lease: its destructor releases the status")]] Checked<Lease, LeaseRefusal>
actor(const Object& object, const LeaseOptions& options);
void actor(std::string_view name) = delete;  // give a proxy, from lab.create
/// Acquires master status, which gives the rights of actor status. While a client has master
/// status, the server refuses the calls of all other clients.
[[nodiscard("keep the lease: its destructor releases the status")]] Checked<Lease, LeaseRefusal>
master(const Object& object, std::string password = {});
[[nodiscard("keep the lease: its destructor releases the status")]] Checked<Lease, LeaseRefusal>
master(const Object& object, const LeaseOptions& options);
void master(std::string_view name) = delete;  // give a proxy, from lab.create

/// Stops the object for all clients: ends every lease except those of this session, removes all
/// queued commands and interrupts the running commands.
Command<void> stop(const Object& object);
/// Takes sole command of a status that other clients share with this session, by its password. The
/// running and queued commands of the other clients end as PREEMPTED. Until `give_back`, or until
/// the status of this session ends, new commands of the other clients end as DENIED, and their
/// samples have no effect. The commands of this session go on. The returned command fails as FAULT
/// (StatusRefused) if this session has no status or another client has taken over.
Command<void> take_over(const Object& object);
/// Ends the take-over of this session, so that the other clients may issue commands again. The
/// commands that the take-over ended are not started again. Does nothing if this session has not
/// taken over.
Command<void> give_back(const Object& object);
/// Returns the requests for a status that wait in line (LeaseOptions::timeout), in the order of
/// their arrival. The command ends as soon as a request with a larger id than `after` waits, at the
/// latest after `timeout`. A holder can thus be told of a new request: `gecos::requests(*robot,
/// last, 60s).then(…)`. To grant a request, release the lease: the first in line gets the status
/// when the last command under the lease has ended.
Command<std::vector<WaitingRequest>> requests(const Object& object, std::uint64_t after = 0,
                                              Duration timeout = {});
/// Refuses the waiting request with the id `request`. The program that made the request gets a
/// LeaseRefusal that names this program and says `why`. The result is false when the request no
/// longer waits. Fails as FAULT (StatusRefused) when this session does not hold the status.
Command<bool> deny(const Object& object, std::uint64_t request, const std::string& why = {});
/// Ends every status of the object. Only an administrator may do this: the user of the server,
/// root, or a user in `[admin]` of the lab file; for other users the command fails as FAULT
/// (StatusRefused). The commands of the holders end as LEASE_LOST, with `why` and the name of this
/// program. The first waiting request gets the status. A person should decide to end a status, for
/// example by `gecos break`; a program must not decide this automatically.
Command<void> break_status(const Object& object, const std::string& why);
Command<void> ping(const Object& object);
Command<Description> describe(const Object& object);
Command<std::vector<Holder>> holders(const Object& object);
/// Returns the present holders of actor or master status, and the recent changes of the holders.
/// The object numbers these changes; the result contains those whose number is larger than `after`.
/// The command ends as soon as there is such a change, at the latest after `timeout`. A program
/// that passes the `newest` of the last result as `after` is told each change once:
/// `gecos::roster(*robot, last.newest, 60s).then(…)`. The first time, pass 0: the command then ends
/// at once, and its result contains all changes that the object keeps, at most 256. The result also
/// contains all changes when `after` is a number from another server, which served the object
/// before. The numbers of changes are consecutive, so a gap shows that changes were lost because
/// the program asked too late. A server that was built before this operation existed answers
/// UNKNOWN_OPERATION.
Command<Roster> roster(const Object& object, std::uint64_t after = 0, Duration timeout = {});
/// Returns what the object has counted since its server began to serve it: the calls of each
/// operation and of each open session by outcome, the times of handlers, and the samples of each
/// stream. All counts are made at the server. The samples that a reader of a stream lost are in
/// `Stream::counts`, and the latency of a connection is in `line_state`. A server that was built
/// before this operation existed answers UNKNOWN_OPERATION.
Command<ObjectStats> stats(const Object& object);
/// Returns the object's interface and each of its bases as JSON, for clients without generated
/// code.
Command<std::vector<std::string>> model(const Object& object);

/// The outcome of a command that has ended, or the present state of a command that has not.
struct Outcome {
  Detail detail = Detail::OutcomeUnknown;
  std::string text;  ///< explains `detail`, unless `detail` is Done
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
