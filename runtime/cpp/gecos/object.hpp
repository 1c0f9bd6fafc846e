#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "gecos/base/clock.hpp"
#include "gecos/base/function_ref.hpp"
#include "gecos/command.hpp"
#include "gecos/description.hpp"
#include "gecos/object_ref_types.hpp"  // generated from idl/gecos/object_ref.gidl
#include "gecos/stream.hpp"
#include "gecos/writer.hpp"

namespace gecos {

/// Options for the calls through one copy of a proxy.
struct CallOptions {
  /// Longest time from sending to completion. The server receives this time and ends the call when
  /// it has passed. Without a value, the shorter of the `@qos(deadline=…)` of the operation and the
  /// deadline that the program requested at `create` applies, if there is one. If the value is zero
  /// or negative, the call is not sent and ends as EXPIRED.
  std::optional<Duration> deadline{};
};

/// The state of the connection of a proxy (gecos/line.hpp).
struct LineState {
  std::string medium;
  Duration bound{};  ///< the longest round trip that the interface allows; 0: no bound, and nothing
                     ///< is measured
  std::optional<Duration> round_trip{};  ///< the round trip that was measured last
  bool degraded = false;                 ///< the round trip has exceeded the bound for a second
  /// The number of changes of the state. The state changes when `degraded` changes, and when a
  /// failover has succeeded or failed.
  std::uint64_t changes = 0;
  /// The medium that the proxy has left, if the last change was a failover. The proxy now uses
  /// `medium`.
  std::string moved_from{};
  /// A text for people that says what the last change of the state was, and why; empty before the
  /// first change.
  std::string why{};
};

namespace session {

/// Client side of one session with one object. Generated proxies call its methods. Thread-safe.
class ClientSession {
 public:
  virtual ~ClientSession() = default;
  /// Issues a call whose arguments take `size` bytes. Never blocks and never fails: the returned
  /// command reports errors.
  virtual std::shared_ptr<CommandCore> call(const OperationDescription& operation, std::size_t size,
                                            FunctionRef<void(wire::Encoder&)> encode,
                                            const CallOptions& options) = 0;
  /// Returns a command of `operation` that has ended with `failure`, without being sent.
  virtual std::shared_ptr<CommandCore> refuse(const OperationDescription& operation,
                                              Failure failure) = 0;
  /// Subscribes to a stream of the object.
  virtual tl::expected<std::shared_ptr<StreamCore>, Failure> subscribe(
      const StreamDescription& stream) = 0;
  /// Opens an inward stream of the object.
  virtual tl::expected<std::shared_ptr<WriterCore>, Failure> open_writer(
      const InwardDescription& stream) = 0;
  /// Returns the scoped name of the interface that the object implements: the interface of the
  /// proxy, or an interface derived from that interface.
  virtual const std::string& interface_name() const = 0;
  virtual const std::string& object_name() const = 0;
  virtual const media::Capabilities& capabilities() const = 0;
  /// Returns the reference by which other programs find the object. The reference is nil when the
  /// proxy was not made by `Lab::create`.
  virtual ObjectRef reference() const = 0;
  /// Tells the session that a lease was acquired. From now on the session issues commands under
  /// `epoch`. Returns a number for the lease, which the caller passes to `lease_released` and
  /// `lease_lost`.
  virtual std::uint64_t lease_acquired(std::uint64_t epoch) = 0;
  /// Tells the session that a lease was released. When the last lease of a status is released, the
  /// session issues later commands without an epoch.
  virtual void lease_released(std::uint64_t held) = 0;
  /// Returns whether the status of a lease is certainly lost: the session has ended, or has
  /// acquired another status after that lease. False does not mean that the server still grants the
  /// status.
  virtual bool lease_lost(std::uint64_t /*held*/) const { return false; }
  /// Returns the state of the connection.
  virtual LineState line() const { return {}; }
  /// Waits until the state of the connection has changed more than `changes` times, the session is
  /// lost or closed, or `deadline` has passed. Returns the state.
  virtual LineState await_line_change(std::uint64_t /*changes*/, TimePoint /*deadline*/) const {
    return line();
  }
  /// Returns the number of calls that were issued and of samples that were sent so far.
  virtual std::uint64_t issued() = 0;
};

/// Returns the session of a proxy that was not made by `Lab::create`. Every call in it ends as
/// CONNECTION_FAILED/NO_SERVER.
const std::shared_ptr<ClientSession>& nil_session();

/// Returns a session for a proxy whose lab was closed. It behaves like `nil_session`, but returns
/// the object name and the interface name of `was`, the previous session of the proxy.
std::shared_ptr<ClientSession> closed_session(const ClientSession& was);

/// Returns a command that has ended with `failure`, without being sent.
std::shared_ptr<CommandCore> ended(Failure failure);

/// Stands for a call with invalid parameters, which is not sent. Converts to a Command of any type;
/// this command has ended as BAD_PARAMETER.
class Refused {
 public:
  explicit Refused(std::string why);
  /// Used for operations with @on_new("blend"): after a call with invalid parameters, `session`
  /// refuses all later commands with @on_new("blend") until the program has seen the failure of
  /// this call.
  Refused(std::string why, ClientSession& session, const OperationDescription& operation);
  /// Returns how many calls this process has refused before they were sent.
  static std::uint64_t count();
  template <class T, class Feedback>
  operator Command<T, Feedback>() const {  // NOLINT(google-explicit-constructor): it is returned
    if constexpr (std::is_void_v<T>) {
      return Command<T, Feedback>(core_);
    } else {
      return Command<T, Feedback>(core_, nullptr);  // a refused call has no result
    }
  }

 private:
  std::shared_ptr<CommandCore> core_;
};

}  // namespace session

/// The base of every generated proxy: a copyable handle to a session with an object. Copies share
/// the session. This class has no public members, so an interface may use any name. The built-in
/// operations are the free functions of `gecos/builtin_operations.hpp`.
class Object {
 protected:
  Object() : gecos_session_(session::nil_session()) {}
  explicit Object(std::shared_ptr<session::ClientSession> gecos_session)
      : gecos_session_(std::move(gecos_session)) {}
  // Proxies are copied, never moved: a move would move a virtual base once for each path of
  // inheritance that leads to the base.
  Object(const Object&) = default;
  Object& operator=(const Object&) = default;

  /// For generated methods: issues a call whose arguments take `size` bytes.
  template <class T, class Feedback = void>
  requires(!std::is_void_v<T>) Command<T, Feedback> gecos_call(
      const OperationDescription& operation, std::size_t size,
      FunctionRef<void(wire::Encoder&)> encode, bool (*decode)(wire::Decoder&, T&))
  const { return {gecos_session_->call(operation, size, encode, gecos_options_), decode}; }
  template <class T, class Feedback = void>
  requires(std::is_void_v<T>) Command<T, Feedback> gecos_call(
      const OperationDescription& operation, std::size_t size,
      FunctionRef<void(wire::Encoder&)> encode)
  const {
    return Command<T, Feedback>(gecos_session_->call(operation, size, encode, gecos_options_));
  }
  /// For generated methods: issues a call of an operation that has no arguments.
  template <class T, class Feedback = void>
  requires(!std::is_void_v<T>) Command<T, Feedback> gecos_call(
      const OperationDescription& operation, bool (*decode)(wire::Decoder&, T&))
  const {
    return gecos_call<T, Feedback>(
        operation, 0, [](wire::Encoder&) {}, decode);
  }
  template <class T, class Feedback = void>
  requires(std::is_void_v<T>) Command<T, Feedback> gecos_call(const OperationDescription& operation)
  const {
    return gecos_call<T, Feedback>(operation, 0, [](wire::Encoder&) {});
  }
  template <class T>
  tl::expected<Stream<T>, Failure> gecos_subscribe(const StreamDescription& outward,
                                                   bool (*decode)(wire::Decoder&, T&)) const {
    auto core = gecos_session_->subscribe(outward);
    if (!core) return tl::unexpected(std::move(core.error()));
    return Stream<T>(std::move(*core), decode);
  }

  template <class T>
  tl::expected<Writer<T>, Failure> gecos_write(const InwardDescription& inward,
                                               typename Writer<T>::Send send) const {
    auto core = gecos_session_->open_writer(inward);
    if (!core) return tl::unexpected(std::move(core.error()));
    return Writer<T>(std::move(*core), send);
  }

  std::shared_ptr<session::ClientSession> gecos_session_;
  CallOptions gecos_options_;

  friend const std::shared_ptr<session::ClientSession>& session_of(const Object& object);
  template <class Proxy>
  friend Proxy with(Proxy proxy, CallOptions options);
};

inline const std::shared_ptr<session::ClientSession>& session_of(const Object& object) {
  return object.gecos_session_;
}

/// Returns a reference to the object. Operations pass such a reference when the type of a parameter
/// or result is an interface. In any process of the laboratory, `Lab::create` makes a proxy from
/// the reference.
inline ObjectRef reference(const Object& object) { return session_of(object)->reference(); }

/// Returns a copy of `proxy` with other call options. Example: `gecos::with(robot, {.deadline =
/// 2s}).move(goal)`.
template <class Proxy>
Proxy with(Proxy proxy, CallOptions options) {
  static_cast<Object&>(proxy).gecos_options_ = options;
  return proxy;
}

}  // namespace gecos

// What gidl generates for a client (Manipulator derives from Device; interfaces are virtual bases
// so that diamonds have one session):
//
//   class Manipulator : public virtual robcl::Device {
//    public:
//     static const gecos::InterfaceDescription& gecos_description() {
//       return ManipulatorInterface::description;                // of manipulator_interface.hpp
//     }
//     Manipulator() = default;                                  // nil
//     explicit Manipulator(std::shared_ptr<gecos::session::ClientSession> session);
//     gecos::Command<robcl::Frame> tool() const;                                        // one-shot
//     tl::expected<gecos::Stream<Frame>, gecos::Failure> tool(gecos::StreamAnnotation) const;
//     gecos::Command<void> set_tool_offset(const robcl::Frame& value) const;
//     gecos::Command<void, MotionProgress> move(const robcl::Frame& goal,
//                                               const std::optional<Trajectory>& how = {}) const;
//   };
//
// A root interface derives from `public virtual gecos::Object`. A method body is one expression
// after the checks of its parameters:
//   return gecos_call<void, MotionProgress>(ManipulatorInterface::move, size,
//                                           [&](auto& to) { goal.encode(to); … });
// A call on a nil proxy returns a command that has ended as CONNECTION_FAILED/NO_SERVER, because
// Object() uses session::nil_session().
