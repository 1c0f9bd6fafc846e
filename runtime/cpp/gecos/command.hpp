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

/// The paper's four states. Exactly one of the last three is reached, and then it never changes.
enum class State : std::uint8_t {
  Running,
  Finished,
  CommandFailed,
  ConnectionFailed,  ///< proves that the command did not start: sending it again is safe
};
std::string_view to_string(State state);  ///< "RUNNING", as in the paper
std::ostream& operator<<(std::ostream& out, State state);

/// The finer state, which projects onto one of the four.
enum class Detail : std::uint8_t {
  // RUNNING
  Sent,
  Queued,
  Executing,
  Canceling,
  Unreachable,
  // FINISHED
  Done,
  // COMMAND_FAILED
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
  // CONNECTION_FAILED
  NotStarted,
  NoServer,
  Refused,
  QosUnavailable,
};
State project(Detail detail);
std::string_view to_string(Detail detail);  ///< "SERVER_CRASHED"
std::optional<Detail> detail_from(std::uint8_t number);
std::ostream& operator<<(std::ostream& out, Detail detail);

/// Why a command did not finish, with its evidence.
struct Failure {
  Detail detail = Detail::Fault;
  std::string text;       ///< what, where, what to do
  std::string exception;  ///< scoped name of the declared exception when detail is Fault
  Bytes evidence;         ///< that exception, encoded

  State state() const { return project(detail); }
  /// The declared exception E, when that is what was raised.
  template <wire::GeneralContents E>
  std::optional<E> as() const {
    if (exception != E::type_name()) return std::nullopt;
    auto decoded = wire::from_bytes<E>(evidence);
    return decoded ? std::optional<E>(std::move(*decoded)) : std::nullopt;
  }
};
std::ostream& operator<<(std::ostream& out, const Failure& failure);

/// Which command it is, to ask for its outcome later, also from another program. All zero: it was
/// never sent.
struct CommandId {
  std::uint64_t incarnation = 0;  ///< the server's process
  std::uint64_t session = 0;      ///< random: who knows it may ask
  std::uint64_t counter = 0;      ///< in that session

  friend bool operator==(const CommandId&, const CommandId&) = default;
};
std::string to_string(const CommandId& id);  ///< three hexadecimal numbers, "0123-4567-1"
std::optional<CommandId> command_id_from(std::string_view text);
std::ostream& operator<<(std::ostream& out, const CommandId& id);

/// Where a command stands, all read at one instant.
struct Progress {
  Detail detail = Detail::Sent;
  std::uint32_t position = 0;  ///< commands before it, while Queued
  double fraction = 0;         ///< 0 to 1, as the server last said
};

namespace session {

/// A command without its types: what caller and session share. Thread-safe. Dropping it detaches;
/// it never cancels.
class CommandCore {
 public:
  virtual ~CommandCore() = default;
  virtual CommandId id() const = 0;
  virtual Progress progress() const = 0;
  /// Latest feedback, encoded; empty when none has come.
  virtual Bytes feedback() const = 0;
  /// Waits until it is terminal or `deadline`; true when terminal. Never hangs: every command ends
  /// within its bound, whatever dies.
  virtual bool wait_until(TimePoint deadline) = 0;
  /// Asks the server to stop it. The state tells whether that came in time.
  virtual void cancel() = 0;
  /// Valid once terminal: the encoded result, when Done. Stays valid for the core's life.
  virtual ByteView result() const = 0;
  /// Valid once terminal and not Done.
  virtual const Failure& failure() const = 0;
  /// Descriptor that becomes readable when the command is terminal; the core owns it.
  virtual int descriptor() = 0;
  /// Runs `then` once the command is terminal: at once when it is, else on the lab's thread of
  /// callbacks, even when the command was dropped. An exception of `then` is logged and goes no
  /// further.
  virtual void when_ended(std::function<void()> then) = 0;
  /// The called operation, "RX90.move". Valid while it runs, and after a failure that no caller had
  /// asked before.
  virtual std::string about() const { return {}; }

  /// Marks its outcome as observed, or as of no interest: its failure is not logged.
  void observe() { observed_.store(true, std::memory_order_relaxed); }
  bool observed() const { return observed_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> observed_{false};  // publishes nothing but itself
};

/// `co_await command`: resumes on the lab's thread of callbacks with what `get()` gives.
template <class Command>
class CommandAwaiter {
 public:
  explicit CommandAwaiter(Command command) : command_(std::move(command)) {}
  bool await_ready() const { return command_.wait_for(Duration{}) != State::Running; }
  void await_suspend(std::coroutine_handle<> waits) const {
    // The awaiter may be gone before this returns: the coroutine owns it.
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
  /// For `gecos::outcome`, when the connection was lost.
  CommandId id() const { return core_->id(); }
  State state() const& { return project(progress().detail); }
  State state() && = delete;
  Progress progress() const& {
    core_->observe();
    return core_->progress();
  }
  Progress progress() && = delete;

  /// Latest feedback, when some has come.
  std::optional<Feedback> feedback() const requires(!std::is_void_v<Feedback>) {
    core_->observe();
    const Bytes bytes = core_->feedback();
    if (bytes.empty()) return std::nullopt;
    auto decoded = wire::from_bytes<Feedback>(bytes);
    return decoded ? std::optional<Feedback>(std::move(*decoded)) : std::nullopt;
  }

  /// Waits until the command is terminal.
  State wait() const { return wait_until(TimePoint::max()); }
  /// Waits at most `patience`; Running when that was not enough.
  State wait_for(Duration patience) const { return wait_until(deadline_after(patience)); }
  /// Asks the server to stop it. The state tells whether that came in time.
  void cancel() const {
    core_->observe();
    core_->cancel();
  }
  /// Declares that its outcome is of no interest: its failure is not logged.
  void detach() const { core_->observe(); }

  /// Readable once the command is terminal, for poll and its like. The command owns it.
  int descriptor() const {
    core_->observe();
    return core_->descriptor();
  }
  const std::shared_ptr<CommandCore>& core() const { return core_; }

 protected:
  explicit AnyCommand(std::shared_ptr<CommandCore> core) : core_(std::move(core)) {}
  /// Waits; why there is no result, if there is none.
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

/// A call that was issued. T is its result, Feedback what it reports while it runs.
///
/// The call is on its way when you have this; nothing waits until you ask. Dropping it lets it run;
/// the failure of a command whose outcome no caller observed is logged, once for each operation of
/// an object and way to fail. `while (robot.move(x).state() == State::Running)` does not compile:
/// each turn would issue a new command. Keep the command: `auto move = robot.move(x); while
/// (move.state() == State::Running)`.
template <class T, class Feedback = void>
class [[nodiscard]] Command : public session::AnyCommand<Feedback> {
 public:
  using Decode = bool (*)(wire::Decoder&, T&);

  Command(std::shared_ptr<session::CommandCore> core, Decode decode)
      : session::AnyCommand<Feedback>(std::move(core)), decode_(decode) {}

  /// Waits, then gives the result or why there is none.
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

  /// Calls `callback` with what `get()` gives, once the command is terminal: at once when it is,
  /// else on the lab's thread of callbacks, one after another. It may block, and issue commands.
  template <class Callback>
  void then(Callback callback) const {
    this->call_once_ended(*this, std::move(callback));
  }
  auto operator co_await() const { return session::CommandAwaiter<Command>(*this); }

 private:
  Decode decode_;
};

/// A call without result. The same promises.
template <class Feedback>
class [[nodiscard]] Command<void, Feedback> : public session::AnyCommand<Feedback> {
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

}  // namespace gecos
