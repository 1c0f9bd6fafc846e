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

/// How calls through one copy of a proxy are made.
struct CallOptions {
  /// Time from sending to completion. The server knows it and ends the call when it is over.
  /// Nothing: the operation's own `@qos(deadline=…)`, or none. Zero or less, as `end - now` is when
  /// time is over: the call is not sent and ends EXPIRED.
  std::optional<Duration> deadline{};
};

namespace session {

/// Client side of one session with one object: what generated proxies call. Thread-safe.
class ClientSession {
 public:
  virtual ~ClientSession() = default;
  /// Issues a call whose arguments take `size` bytes. Never blocks and never fails: what goes wrong
  /// is in the command.
  virtual std::shared_ptr<CommandCore> call(const OperationDescription& operation, std::size_t size,
                                            FunctionRef<void(wire::Encoder&)> encode,
                                            const CallOptions& options) = 0;
  /// Opens an outward stream.
  virtual tl::expected<std::shared_ptr<StreamCore>, Failure> subscribe(
      const StreamDescription& stream) = 0;
  /// Interface that the object really has (the proxy's own or one derived from it).
  virtual const std::string& interface_name() const = 0;
  virtual const std::string& object_name() const = 0;
  virtual const media::Offer& offer() const = 0;
  /// The reference by which others find the object; nil for a proxy that was never created.
  virtual ObjectRef reference() const = 0;
  /// A lease was acquired: commands are issued under its epoch from now on. Gives what
  /// `lease_released` wants.
  virtual std::uint64_t lease_acquired(std::uint64_t epoch) = 0;
  /// That lease is given back. After the last one of a status, commands are issued under none.
  virtual void lease_released(std::uint64_t held) = 0;
  /// Calls that were sent so far.
  virtual std::uint64_t issued() = 0;
};

/// Stands in for a proxy that was never created: every call is CONNECTION_FAILED/NO_SERVER.
const std::shared_ptr<ClientSession>& nil_session();

/// The session of a proxy whose lab was closed: as `nil_session`, in the name of the one it `was`.
std::shared_ptr<ClientSession> closed_session(const ClientSession& was);

/// A command that ended before anything was sent.
std::shared_ptr<CommandCore> ended(Failure failure);

/// A call whose parameters must not be sent: the command of such a call, BAD_PARAMETER.
class Refused {
 public:
  explicit Refused(std::string why);
  template <class T, class Feedback>
  operator Command<T, Feedback>() const {  // NOLINT(google-explicit-constructor): it is returned
    if constexpr (std::is_void_v<T>) {
      return Command<T, Feedback>(core_);
    } else {
      return Command<T, Feedback>(core_, nullptr);  // it has no result to decode
    }
  }

 private:
  std::shared_ptr<CommandCore> core_;
};

}  // namespace session

/// The base of every generated proxy: a copyable handle to a session with an object. Copies share
/// the session. It has no public member of its own, so an interface may use any name; what every
/// object answers is reached by the free functions of `gecos/builtin_operations.hpp`.
class Object {
 protected:
  Object() : gecos_session_(session::nil_session()) {}
  explicit Object(std::shared_ptr<session::ClientSession> gecos_session)
      : gecos_session_(std::move(gecos_session)) {}
  // Copied, never moved: as a virtual base it would be moved once per path that leads to it.
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
  /// The same without arguments.
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

/// The object as a value: what operations take and give where an interface is the type of a
/// parameter or result. `Lab::create` makes a proxy of it again, in any process of the laboratory.
inline ObjectRef reference(const Object& object) { return session_of(object)->reference(); }

/// The same object, called with other options: `gecos::with(robot, {.deadline = 2s}).move(goal)`.
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
