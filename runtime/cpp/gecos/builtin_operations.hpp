#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/checked_result.hpp"
#include "gecos/object.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl

/// The built-in operations of every object, as free functions: an interface may use the same names.
namespace gecos {

/// Actor or master status of one object, held by this session. A lease ends when it is released or
/// lost; its destructor calls `release()`. Move-only.
///
/// A release waits for the server's reply, at most a second. After that other clients may get the
/// status, as soon as the commands issued under it have ended. Commands issued later without
/// another lease are DENIED. A lease that is destroyed at once, before any command was issued under
/// it, logs a warning.
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
  /// True when the lease was acquired less than 100 ms ago and no call was issued since.
  bool fresh() const;

 private:
  void send_release(bool now);

  std::shared_ptr<session::ClientSession> session_;
  Grant grant_;
  std::uint64_t held_;    ///< result of ClientSession::lease_acquired
  std::uint64_t issued_;  ///< number of calls that the program had issued before the lease
  TimePoint since_;
};

/// Why the server refused actor or master status.
struct LeaseRefusal {
  Failure failure;
  std::vector<Holder> holders;  ///< the present holders; each says since when and until when
};
std::ostream& operator<<(std::ostream& out, const LeaseRefusal& refusal);

/// How a status is acquired.
struct LeaseOptions {
  std::string password{};  ///< clients that pass the same password share the status
  /// How long to wait in line while others hold the status, in the order of arrival. Zero: not at
  /// all. Duration::max(): without limit.
  Duration timeout{};
  /// Called on the calling thread with the number of requests before this one, when the wait begins
  /// and whenever the number changes.
  std::function<void(std::uint32_t before)> on_position{};
};

/// Acquires actor status, which allows commands that move or change the device. Clients that pass
/// the same `password` share the status.
[[nodiscard("keep the lease: its destructor releases the status")]] Checked<Lease, LeaseRefusal>
actor(const Object& object, std::string password = {});
/// Waits in line while others hold the status: `gecos::actor(*robot, {.timeout = 10s})`. A `stop`
/// of the object ends the line. A server that is older than this option refuses at once.
[[nodiscard("keep the lease: its destructor releases the status")]] Checked<Lease, LeaseRefusal>
actor(const Object& object, const LeaseOptions& options);
/// Acquires master status: like actor status, and the calls of other clients are refused.
[[nodiscard("keep the lease: its destructor releases the status")]] Checked<Lease, LeaseRefusal>
master(const Object& object, std::string password = {});
[[nodiscard("keep the lease: its destructor releases the status")]] Checked<Lease, LeaseRefusal>
master(const Object& object, const LeaseOptions& options);

/// Stops the device for every holder: ends every lease, drops the queue, interrupts commands.
Command<void> stop(const Object& object);
Command<void> ping(const Object& object);
Command<Description> describe(const Object& object);
Command<std::vector<Holder>> holders(const Object& object);
/// The object's interface and each of its bases as JSON, for clients without generated code.
Command<std::vector<std::string>> model(const Object& object);

/// The outcome of a command, or its present state.
struct Outcome {
  Detail detail = Detail::OutcomeUnknown;
  std::string text;  ///< explains `detail`, unless it is Done
  State state() const { return project(detail); }
};
std::ostream& operator<<(std::ostream& out, const Outcome& outcome);

/// Asks, through a new proxy, for the outcome of an actor command that ended as OUTCOME_UNKNOWN.
/// The state of that command does not change. NotStarted is a promise: the command has not arrived
/// and never starts. Sent: the command has not arrived and may still start; ask again.
/// OutcomeUnknown: the server was restarted since, or no longer keeps the outcome (it keeps the
/// last 1024 of each object).
Command<Outcome> outcome(const Object& object, const CommandId& id);

}  // namespace gecos
