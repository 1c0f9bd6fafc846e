#pragma once

#include <atomic>
#include <coroutine>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/result.hpp"
#include "gecos/wire/contents.hpp"

namespace gecos {

/// The four states of a command, as in the paper (docs/paper-map.md). Every command reaches exactly
/// one of the last three, which is final.
enum class State : std::uint8_t {
  Running,
  Finished,
  CommandFailed,
  ConnectionFailed,  ///< the command certainly did not start: it may be sent again
};
std::string_view to_string(State state);  ///< "RUNNING", as in the paper
std::ostream& operator<<(std::ostream& out, State state);

/// The detailed state of a command; `project` maps it onto one of the four states.
enum class Detail : std::uint8_t {
  // state RUNNING
  Sent,
  Queued,
  Executing,
  Canceling,
  Unreachable,
  // state FINISHED
  Done,
  // state COMMAND_FAILED
  Rejected,
  BadParameter,
  UnknownOperation,
  Denied,
  QueueFull,
  Expired,
  TimedOut,
  Fault,
  Canceled,
  Preempted,
  Stopped,
  LeaseLost,
  PresenceLost,
  ServerCrashed,
  OutcomeUnknown,
  // state CONNECTION_FAILED
  NotStarted,
  NoServer,
  Refused,
  QosUnavailable,
};
State project(Detail detail);
std::string_view to_string(Detail detail);  ///< "SERVER_CRASHED"
std::optional<Detail> detail_from(std::uint8_t number);
std::ostream& operator<<(std::ostream& out, Detail detail);

/// Why a command did not finish, with the declared exception if the handler raised one.
struct Failure {
  Detail detail = Detail::Fault;
  std::string text;       ///< what failed, where, and what the caller can do
  std::string exception;  ///< scoped name of the declared exception when detail is Fault
  Bytes evidence;         ///< the declared exception, encoded

  State state() const { return project(detail); }
  /// The declared exception, when the handler raised one of type E.
  template <wire::GeneralContents E>
  std::optional<E> as() const {
    if (exception != E::type_name()) return std::nullopt;
    auto decoded = wire::from_bytes<E>(evidence);
    return decoded ? std::optional<E>(std::move(*decoded)) : std::nullopt;
  }
};
std::ostream& operator<<(std::ostream& out, const Failure& failure);

/// Identifies a command, so that any program can ask for its outcome later. All zero: the command
/// was never sent.
struct CommandId {
  std::uint64_t incarnation = 0;  ///< incarnation of the server's process
  std::uint64_t session = 0;      ///< random; a client that knows it may ask for the outcome
  std::uint64_t counter = 0;      ///< number of the call in the session

  friend bool operator==(const CommandId&, const CommandId&) = default;
};
std::string to_string(const CommandId& id);  ///< three hexadecimal numbers, "0123-4567-1"
std::optional<CommandId> command_id_from(std::string_view text);
std::ostream& operator<<(std::ostream& out, const CommandId& id);

/// The progress of a command; all members were read at the same instant.
struct Progress {
  Detail detail = Detail::Sent;
  std::uint32_t position = 0;  ///< number of commands before this one, while Queued
  double fraction = 0;         ///< 0 to 1, as last reported by the server
};

namespace session {

/// A command without its result type, shared by caller and session. Thread-safe. Dropping a
/// CommandCore never cancels: its command runs on.
class CommandCore {
 public:
  virtual ~CommandCore() = default;
  virtual CommandId id() const = 0;
  virtual Progress progress() const = 0;
  /// Latest feedback, encoded; empty when none has arrived.
  virtual Bytes feedback() const = 0;
  /// Waits until the command is terminal or `deadline` has passed; true when terminal. Never hangs:
  /// every command ends in bounded time, whichever process dies.
  virtual bool wait_until(TimePoint deadline) = 0;
  /// Asks the server to cancel the command. The final state tells whether the request was in time.
  virtual void cancel() = 0;
  /// The encoded result of a command that is Done. Call it only when the command is terminal; the
  /// view is valid as long as this object.
  virtual ByteView result() const = 0;
  /// Why the command failed. Call it only when the command is terminal and not Done.
  virtual const Failure& failure() const = 0;
  /// Descriptor that becomes readable when the command is terminal; this object owns it.
  virtual int descriptor() = 0;
  /// Calls `then` once the command is terminal: immediately when it is terminal already, else on
  /// the lab's callback thread. The callback comes even when the caller has dropped the command. An
  /// exception that `then` throws is logged and not propagated.
  virtual void when_ended(std::function<void()> then) = 0;
  /// The name of the called operation, "RX90.move". Known while the command runs; afterwards only
  /// when the command failed and no caller had observed it.
  virtual std::string about() const { return {}; }

  /// Marks the outcome as observed. A failure of the command is then not logged.
  void observe() { observed_.store(true, std::memory_order_relaxed); }
  bool observed() const { return observed_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> observed_{false};  // protects no other data, so relaxed is enough
};

/// `co_await command`: resumes on the lab's callback thread with the result of `get()`.
template <class Command>
class CommandAwaiter {
 public:
  explicit CommandAwaiter(Command command) : command_(std::move(command)) {}
  bool await_ready() const { return command_.wait_for(Duration{}) != State::Running; }
  void await_suspend(std::coroutine_handle<> waits) const {
    // The coroutine owns this awaiter and may destroy it before await_suspend returns.
    const auto core = command_.core();
    core->observe();
    core->when_ended([waits] { waits.resume(); });
  }
  auto await_resume() const { return command_.get(); }

 private:
  Command command_;
};

/// The part of a command that does not depend on its result type.
template <class Feedback>
class AnyCommand {
 public:
  /// The argument for `gecos::outcome` after the connection was lost.
  CommandId id() const { return core_->id(); }
  State state() const& { return project(progress().detail); }
  State state() && = delete;  // keep the command: `auto move = robot.move(goal); move.state()`
  Progress progress() const& {
    core_->observe();
    return core_->progress();
  }
  Progress progress() && = delete;  // keep the command: `auto move = robot.move(goal);`

  /// Latest feedback; nothing when none has arrived.
  std::optional<Feedback> feedback() const requires(!std::is_void_v<Feedback>) {
    core_->observe();
    const Bytes bytes = core_->feedback();
    if (bytes.empty()) return std::nullopt;
    auto decoded = wire::from_bytes<Feedback>(bytes);
    return decoded ? std::optional<Feedback>(std::move(*decoded)) : std::nullopt;
  }

  /// Waits until the command is terminal.
  State wait() const { return wait_until(TimePoint::max()); }
  /// Waits at most `patience`; Running when the command has not ended by then.
  State wait_for(Duration patience) const { return wait_until(deadline_after(patience)); }
  /// Asks the server to cancel the command. The final state tells whether the request was in time.
  void cancel() const {
    core_->observe();
    core_->cancel();
  }
  /// Says that the caller needs no outcome. A failure of the command is then not logged.
  void detach() const { core_->observe(); }

  /// A descriptor for poll, select or epoll, readable once the command is terminal. The command
  /// owns it.
  int descriptor() const {
    core_->observe();
    return core_->descriptor();
  }
  const std::shared_ptr<CommandCore>& core() const { return core_; }

 protected:
  explicit AnyCommand(std::shared_ptr<CommandCore> core) : core_(std::move(core)) {}
  /// Waits until the command is terminal; returns its failure unless it finished.
  tl::expected<void, Failure> ended() const {
    if (wait() != State::Finished) return tl::unexpected(core_->failure());
    return {};
  }
  template <class Command, class Callback>
  static void call_once_ended(const Command& command, Callback callback) {
    command.core()->observe();
    command.core()->when_ended(
        [command, callback = std::move(callback)]() mutable { callback(command.get()); });
  }

 private:
  State wait_until(TimePoint deadline) const {
    core_->wait_until(deadline);
    return project(core_->progress().detail);
  }

  std::shared_ptr<CommandCore> core_;
};

}  // namespace session

#define GECOS_KEPT [[nodiscard("keep the command, or detach() it")]]

/// An issued call. T is the type of its result, Feedback the type that it reports while it runs.
///
/// The method of the proxy issues the call and returns at once; only `wait`, `wait_for` and `get`
/// block. Dropping the Command lets the call run on. A failure that no caller observed is logged,
/// once for each operation of an object and kind of failure. `while (robot.move(x).state() ==
/// State::Running)` does not compile: each iteration would issue a new command. Keep the command:
/// `auto move = robot.move(x); while (move.state() == State::Running)`.
template <class T, class Feedback = void>
class GECOS_KEPT Command : public session::AnyCommand<Feedback> {
 public:
  using Decode = bool (*)(wire::Decoder&, T&);

  Command(std::shared_ptr<session::CommandCore> core, Decode decode)
      : session::AnyCommand<Feedback>(std::move(core)), decode_(decode) {}

  /// Waits until the command is terminal, then returns its result or its failure.
  tl::expected<T, Failure> get() const {
    if (auto ended = this->ended(); !ended) return tl::unexpected(std::move(ended.error()));
    wire::Decoder from(this->core()->result());
    T value{};
    if (!decode_(from, value)) {
      return tl::unexpected(
          Failure{Detail::Fault, "the reply does not decode: " + describe(from.error()), {}, {}});
    }
    return value;
  }

  /// Calls `callback` with the result of `get()` once the command is terminal: immediately when it
  /// is terminal already, else on the lab's callback thread, one callback after another. A callback
  /// may block and issue commands.
  template <class Callback>
  void then(Callback callback) const {
    this->call_once_ended(*this, std::move(callback));
  }
  auto operator co_await() const { return session::CommandAwaiter<Command>(*this); }

 private:
  Decode decode_;
};

/// A call of an operation without a result; otherwise like Command<T>.
template <class Feedback>
class GECOS_KEPT Command<void, Feedback> : public session::AnyCommand<Feedback> {
 public:
  explicit Command(std::shared_ptr<session::CommandCore> core)
      : session::AnyCommand<Feedback>(std::move(core)) {}

  tl::expected<void, Failure> get() const { return this->ended(); }
  template <class Callback>
  void then(Callback callback) const {
    this->call_once_ended(*this, std::move(callback));
  }
  auto operator co_await() const { return session::CommandAwaiter<Command>(*this); }
};

#undef GECOS_KEPT

}  // namespace gecos
