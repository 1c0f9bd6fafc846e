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

/// The four states of a command, as in the paper (docs/paper-map.md). Every command ends in exactly
/// one of the last three states and stays in that state.
enum class State : std::uint8_t {
  Running,
  Finished,
  CommandFailed,
  ConnectionFailed,  ///< the command certainly did not start: it may be sent again
};
std::string_view to_string(State state);  ///< returns for example "RUNNING", as in the paper
std::ostream& operator<<(std::ostream& out, State state);

/// The detailed state of a command. The function `project` maps each detailed state to one of the
/// four states.
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
std::string_view to_string(Detail detail);  ///< returns for example "SERVER_CRASHED"
std::optional<Detail> detail_from(std::uint8_t number);
std::ostream& operator<<(std::ostream& out, Detail detail);

/// The reason for which a command did not finish, and the declared exception if the handler raised
/// one.
struct Failure {
  Detail detail = Detail::Fault;
  std::string text;       ///< what failed, where, and what the caller can do
  std::string exception;  ///< scoped name of the declared exception when detail is Fault
  Bytes evidence;         ///< the declared exception, encoded

  State state() const { return project(detail); }
  /// Returns the declared exception if the handler raised one of type E; otherwise nullopt.
  template <wire::GeneralContents E>
  std::optional<E> as() const {
    if (exception != E::type_name()) return std::nullopt;
    auto decoded = wire::from_bytes<E>(evidence);
    return decoded ? std::optional<E>(std::move(*decoded)) : std::nullopt;
  }
};
std::ostream& operator<<(std::ostream& out, const Failure& failure);

/// Identifies a command, so that any program can ask for the command's outcome later. When all
/// members are zero, the command was never sent.
struct CommandId {
  std::uint64_t incarnation = 0;  ///< incarnation of the server's process
  std::uint64_t session = 0;  ///< a random number; a client that knows it may ask for the outcome
  std::uint64_t counter = 0;  ///< number of the call in the session

  friend bool operator==(const CommandId&, const CommandId&) = default;
};
std::string to_string(const CommandId& id);  ///< three hexadecimal numbers, for example
                                             ///< "1a2b-3c4d-1"
std::optional<CommandId> command_id_from(std::string_view text);
std::ostream& operator<<(std::ostream& out, const CommandId& id);

/// The progress of a command. All members describe the same instant.
struct Progress {
  Detail detail = Detail::Sent;
  std::uint32_t position = 0;  ///< number of commands before this one, while Queued
  double fraction = 0;         ///< 0 to 1, as last reported by the server
};

namespace session {

/// A command without its result type, shared by caller and session. Thread-safe. Destroying a
/// CommandCore does not cancel its command.
class CommandCore {
 public:
  virtual ~CommandCore() = default;
  virtual CommandId id() const = 0;
  virtual Progress progress() const = 0;
  /// Returns the latest feedback in encoded form; empty when no feedback has arrived.
  virtual Bytes feedback() const = 0;
  /// Waits until the command is terminal or `deadline` has passed; true when terminal. If the
  /// server process dies, the command still ends in bounded time.
  virtual bool wait_until(TimePoint deadline) = 0;
  /// Asks the server to cancel the command. The final state tells whether the request was in time.
  virtual void cancel() = 0;
  /// Returns the encoded result of a command that is Done. Call it only when the command is
  /// terminal. The view is valid as long as this object exists.
  virtual ByteView result() const = 0;
  /// Returns why the command failed. Call it only when the command is terminal and not Done.
  virtual const Failure& failure() const = 0;
  /// Returns a descriptor that becomes readable when the command is terminal. This object owns the
  /// descriptor.
  virtual int descriptor() = 0;
  /// Calls `then` once the command is terminal: immediately when it is terminal already, else on
  /// the lab's callback thread. `then` is called even when the program has destroyed its Command.
  /// An exception that `then` throws is logged and not propagated.
  virtual void when_ended(std::function<void()> then) = 0;
  /// Returns the name of the called operation, for example "RX90.move". After the command has
  /// ended, the name is empty unless the command failed and no caller had observed the failure.
  virtual std::string about() const { return {}; }

  /// Declares that the program does not need the outcome of the command. If the command has
  /// @on_new("blend") and fails, later commands with @on_new("blend") are then carried out
  /// nevertheless.
  virtual void ignore_outcome() { observe(); }
  /// Must be called when the program has read `seen`, the state or the outcome of the command.
  /// After a command with @on_new("blend") has failed, later commands with @on_new("blend") are not
  /// carried out until the program has seen the failure.
  virtual void note_look(Detail seen) const { static_cast<void>(seen); }
  /// Marks the outcome as observed. A failure of the command is then not logged.
  void observe() { observed_.store(true, std::memory_order_relaxed); }
  bool observed() const { return observed_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> observed_{false};  // protects no other data, so relaxed is enough
};

/// Implements `co_await command`. The coroutine resumes on the lab's callback thread with the
/// result of `get()`.
template <class Command>
class CommandAwaiter {
 public:
  explicit CommandAwaiter(Command command) : command_(std::move(command)) {}
  bool await_ready() const { return command_.wait_for(Duration{}) != State::Running; }
  void await_suspend(std::coroutine_handle<> waits) const {
    // `core` is a copy, because the coroutine owns this awaiter and may destroy it before
    // await_suspend returns.
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
  /// Returns the id of the command. After the connection was lost, pass it to `gecos::outcome` to
  /// ask for the command's outcome.
  CommandId id() const { return core_->id(); }
  State state() const& { return project(progress().detail); }
  State state() && = delete;  // keep the command: `auto move = robot.move(goal); move.state()`
  Progress progress() const& {
    core_->observe();
    const Progress progress = core_->progress();
    core_->note_look(progress.detail);
    return progress;
  }
  Progress progress() && = delete;  // keep the command: `auto move = robot.move(goal);`

  /// Returns the latest feedback; nullopt when no feedback has arrived.
  std::optional<Feedback> feedback() const requires(!std::is_void_v<Feedback>) {
    core_->observe();
    const Bytes bytes = core_->feedback();
    if (bytes.empty()) return std::nullopt;
    auto decoded = wire::from_bytes<Feedback>(bytes);
    return decoded ? std::optional<Feedback>(std::move(*decoded)) : std::nullopt;
  }

  /// Waits until the command is terminal.
  State wait() const { return wait_until(TimePoint::max()); }
  /// Waits at most `patience`. Returns Running when the command has not ended by then.
  State wait_for(Duration patience) const { return wait_until(deadline_after(patience)); }
  /// Asks the server to cancel the command. The final state tells whether the request was in time.
  void cancel() const {
    core_->observe();
    core_->cancel();
  }
  /// Declares that the program does not need the outcome of the command. A failure of the command
  /// is then not logged. If the command has @on_new("blend") and fails, commands with
  /// @on_new("blend") that the program issues after this call are carried out nevertheless.
  void detach() const { core_->ignore_outcome(); }

  /// Returns a descriptor for poll, select or epoll that becomes readable when the command is
  /// terminal. The command owns the descriptor.
  int descriptor() const {
    core_->observe();
    return core_->descriptor();
  }
  const std::shared_ptr<CommandCore>& core() const { return core_; }

 protected:
  explicit AnyCommand(std::shared_ptr<CommandCore> core) : core_(std::move(core)) {}
  /// Waits until the command is terminal. Returns its failure unless the command is FINISHED.
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
    return state();
  }

  std::shared_ptr<CommandCore> core_;
};

}  // namespace session

#define GECOS_KEPT [[nodiscard("keep the command, or detach() it")]]

/// A call that was issued. T is the type of its result. Feedback is the type of the reports that
/// the handler sends while it runs.
///
/// The method of the proxy issues the call and returns at once; only `wait`, `wait_for` and `get`
/// block. Destroying the Command does not cancel the call. A failure that the program did not
/// observe is logged, but only the first failure for each object, operation and detail. `while
/// (robot.move(x).state() == State::Running)` does not compile: each iteration would issue a new
/// command. Keep the command: `auto move = robot.move(x); while (move.state() == State::Running)`.
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
    tl::expected<T, Failure> value;
    if (!decode_(from, *value)) {
      value = tl::unexpected(
          Failure{Detail::Fault, "the reply does not decode: " + describe(from.error()), {}, {}});
    }
    return value;
  }

  /// Calls `callback` with the result of `get()` once the command is terminal: immediately when it
  /// is terminal already, else on the lab's callback thread, one callback after another. A callback
  /// may block and issue commands. When the callback is called, the command counts as observed: the
  /// program has seen how the command ended.
  template <class Callback>
  void then(Callback callback) const {
    this->call_once_ended(*this, std::move(callback));
  }
  auto operator co_await() const { return session::CommandAwaiter<Command>(*this); }

 private:
  Decode decode_;
};

/// A call of an operation without a result. In all other respects it is like Command<T>.
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
