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

namespace gecos {

/// Options for the calls through one copy of a proxy.
struct CallOptions {
  /// Longest time from sending to completion. The server receives it, and ends the call when that
  /// time has passed. Without a value, the `@qos(deadline=…)` of the operation applies, if there is
  /// one. With zero or a negative value the call is not sent and ends EXPIRED.
  std::optional<Duration> deadline{};
};

namespace session {

/// Client side of one session with one object: what generated proxies call. Thread-safe.
class ClientSession {
 public:
  virtual ~ClientSession() = default;
  /// Issues a call whose arguments take `size` bytes. Never blocks and never fails: the returned
  /// command reports errors.
  virtual std::shared_ptr<CommandCore> call(const OperationDescription& operation, std::size_t size,
                                            FunctionRef<void(wire::Encoder&)> encode,
                                            const CallOptions& options) = 0;
  /// Subscribes to a stream of the object.
  virtual tl::expected<std::shared_ptr<StreamCore>, Failure> subscribe(
      const StreamDescription& stream) = 0;
  /// Scoped name of the interface that the object implements: the interface of the proxy, or an
  /// interface derived from it.
  virtual const std::string& interface_name() const = 0;
  virtual const std::string& object_name() const = 0;
  virtual const media::Capabilities& capabilities() const = 0;
  /// The reference by which other programs find the object. Nil when the proxy was not made by
  /// `Lab::create`.
  virtual ObjectRef reference() const = 0;
  /// Tells the session that a lease was acquired: from now on it issues commands under `epoch`.
  /// Returns the argument for `lease_released`.
  virtual std::uint64_t lease_acquired(std::uint64_t epoch) = 0;
  /// Tells the session that a lease was released. After the last lease of a status the session
  /// issues commands without an epoch.
  virtual void lease_released(std::uint64_t held) = 0;
  /// Number of calls that were issued so far.
  virtual std::uint64_t issued() = 0;
};

/// The session of a proxy that was not made by `Lab::create`: every call is
/// CONNECTION_FAILED/NO_SERVER.
const std::shared_ptr<ClientSession>& nil_session();

/// The session of a proxy whose lab was closed. It behaves like `nil_session`, but keeps the names
/// of `was`, the previous session of the proxy.
std::shared_ptr<ClientSession> closed_session(const ClientSession& was);

/// A command that failed before its call was sent.
std::shared_ptr<CommandCore> ended(Failure failure);

/// Converts to the command of a call with invalid parameters: the call is not sent and ends
/// BAD_PARAMETER.
class Refused {
 public:
  explicit Refused(std::string why);
  /// Number of calls that this process has refused before sending.
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
  // Copied, never moved: a move would move a virtual base again for each path that leads to it.
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
  /// Like the overloads above, for an operation without arguments.
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

  std::shared_ptr<session::ClientSession> gecos_session_;
  CallOptions gecos_options_;

  friend const std::shared_ptr<session::ClientSession>& session_of(const Object& object);
  template <class Proxy>
  friend Proxy with(Proxy proxy, CallOptions options);
};

inline const std::shared_ptr<session::ClientSession>& session_of(const Object& object) {
  return object.gecos_session_;
}

/// A reference to the object, which operations pass when the type of a parameter or result is an
/// interface. `Lab::create` makes a proxy from it in any process of the laboratory.
inline ObjectRef reference(const Object& object) { return session_of(object)->reference(); }

/// A copy of `proxy` with other call options: `gecos::with(robot, {.deadline = 2s}).move(goal)`.
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
//     tl::expected<gecos::Stream<robcl::Frame>, gecos::Failure> tool(gecos::StreamTag) const;
//     gecos::Command<void> set_tool_offset(const robcl::Frame& value) const;
//     gecos::Command<void, MotionProgress> move(const robcl::Frame& goal,
//                                               const std::optional<Trajectory>& how = {}) const;
//   };
//
// A root interface derives from `public virtual gecos::Object`. A method body is one expression
// after the checks of its parameters:
//   return gecos_call<void, MotionProgress>(ManipulatorInterface::move, size,
//                                           [&](auto& to) { goal.encode(to); … });
// A call on a nil proxy gives a command that is CONNECTION_FAILED/NO_SERVER
// (session::nil_session(), which Object() has).
