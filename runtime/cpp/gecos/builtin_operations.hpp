#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gecos/base/checked_result.hpp"
#include "gecos/object.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl

/// Built-in operations of every object. They are free functions, so their names cannot clash.
namespace gecos {

/// Status of one object that this session holds. Ends when it is destroyed, which is `release()`,
/// when it is released, or when it is lost. Move-only.
///
/// Once a release has returned the server knows of it: others may have the status, as soon as what
/// was issued under it has ended. It waits for the server's word, at most a second. What is issued
/// afterwards without another lease is DENIED: one that is destroyed at once, before anything was
/// issued under it, says so in the log.
class [[nodiscard("keep the lease: the status is given back when it is destroyed")]] Lease {
 public:
  Lease(std::shared_ptr<session::ClientSession> session, Grant grant);
  Lease(Lease &&) noexcept = default;
  Lease& operator=(Lease&&) noexcept;
  ~Lease();

  Status status() const { return grant_.status; }
  std::uint64_t epoch() const { return grant_.epoch; }
  /// Gives it back; queued and running commands still finish.
  void release();
  /// Gives it back and stops what is queued and running under it.
  void release_now();
  /// Nothing was issued since it was acquired, which was less than 100 ms ago.
  bool fresh() const;

 private:
  void send_release(bool now);

  std::shared_ptr<session::ClientSession> session_;
  Grant grant_;
  std::uint64_t held_;    ///< what the session calls it
  std::uint64_t issued_;  ///< calls of the session until then
  TimePoint since_;
};

/// Why status was not given.
struct LeaseRefusal {
  Failure failure;
  std::vector<Holder> holders;  ///< each holder, since when and until when
};
std::ostream& operator<<(std::ostream& out, const LeaseRefusal& refusal);

/// Actor status: commands that move or change the device. `password` lets others who know it join.
[[nodiscard(
    "keep the lease: the status is given back when it is destroyed")]] Checked<Lease, LeaseRefusal>
actor(const Object& object, std::string password = {});
/// Master status: as actor, and other clients' calls are refused.
[[nodiscard(
    "keep the lease: the status is given back when it is destroyed")]] Checked<Lease, LeaseRefusal>
master(const Object& object, std::string password = {});

/// Stops the device for every holder: ends every lease, drops the queue, interrupts commands.
Command<void> stop(const Object& object);
Command<void> ping(const Object& object);
Command<Description> describe(const Object& object);
Command<std::vector<Holder>> holders(const Object& object);

/// The outcome of a command, or its present state.
struct Outcome {
  Detail detail = Detail::OutcomeUnknown;
  std::string text;  ///< why, when it is not Done
  State state() const { return project(detail); }
};
std::ostream& operator<<(std::ostream& out, const Outcome& outcome);

/// What became of an actor command whose own outcome is OUTCOME_UNKNOWN, through a new proxy. The
/// command's state stays what it is. NotStarted is a promise: what has not arrived by now never
/// starts. Sent: it has not arrived and may still start; ask again. OutcomeUnknown: the server was
/// started anew since, or keeps it no more (it keeps the last 1024 of each object).
Command<Outcome> outcome(const Object& object, const CommandId& id);

}  // namespace gecos
