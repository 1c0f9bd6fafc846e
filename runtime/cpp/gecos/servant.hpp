#pragma once

#include <atomic>
#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "gecos/base/function_ref.hpp"
#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/command.hpp"
#include "gecos/description.hpp"
#include "gecos/inward.hpp"
#include "gecos/loan.hpp"
#include "gecos/wire/encoder.hpp"

namespace gecos {

/// The client that issued a call.
struct Caller {
  std::string user;
  std::string host;
  std::string program;
  std::int32_t pid = 0;
  std::uint64_t incarnation = 0;  ///< incarnation of the client's process, as the client reports it
  std::uint64_t session = 0;
};

/// The reason for which a handler returns no result: a declared exception, or a failure that
/// rejected(), bad_parameter(), failed() or interrupted() makes.
class Fault {
 public:
  /// Makes a Fault from a declared exception of the operation, for example in `return
  /// tl::unexpected(OutOfReach{"…"});`. When a member of the exception is out of range, the caller
  /// gets a FAULT whose text names that member.
  template <wire::GeneralContents E>
  requires requires {
    { E::type_name() } -> std::convertible_to<std::string_view>;
  }
  Fault(const E& exception)  // NOLINT(google-explicit-constructor)
      : failure_(failure_of(exception)) {}

  /// Makes the Fault of a handler that refuses the command. `why` says what the caller should do.
  static Fault rejected(std::string why) {
    return Fault({Detail::Rejected, std::move(why), {}, {}});
  }
  static Fault bad_parameter(std::string why) {
    return Fault({Detail::BadParameter, std::move(why), {}, {}});
  }
  /// Makes a Fault for a failure for which the operation declares no exception.
  static Fault failed(std::string why) { return Fault({Detail::Fault, std::move(why), {}, {}}); }
  /// Makes the Fault of a handler that ended early because it was interrupted. The session already
  /// knows the reason of the interruption (cancel, stop or loss).
  static Fault interrupted() { return Fault({Detail::Canceled, "canceled", {}, {}}); }

  const Failure& failure() const { return failure_; }

 private:
  explicit Fault(Failure failure) : failure_(std::move(failure)) {}
  template <class E>
  static Failure failure_of(const E& exception) {
    if (auto wrong = wire::violation_of(exception); !wrong.empty()) {
      return {Detail::Fault, "the handler raised " + wrong, {}, {}};
    }
    return {Detail::Fault, describe(exception), std::string(E::type_name()),
            wire::to_bytes(exception)};
  }
  /// Returns a text with the members of the exception, for a caller that only prints the failure.
  template <class E>
  static std::string describe(const E& exception) {
    if constexpr (requires(std::ostringstream out) { out << exception; }) {
      std::ostringstream out;
      out << exception;
      return std::move(out).str();
    } else {
      return "the handler raised this exception";
    }
  }
  Failure failure_;
};

/// The return type of a handler.
template <class T>
using Result = tl::expected<T, Fault>;

namespace session {

/// Server side of one call. Shared by the session and the handler; thread-safe.
class CallCore {
 public:
  virtual ~CallCore() = default;
  virtual const OperationDescription& operation() const = 0;
  virtual ByteView arguments() const = 0;
  virtual const Caller& caller() const = 0;
  /// Returns the number of the call in its session; 0 when the call has none.
  virtual std::uint64_t counter_in_session() const { return 0; }
  /// Returns the epoch of the status under which the call was issued; 0 if it was issued under
  /// none.
  virtual std::uint64_t status_epoch() const { return 0; }
  /// Returns true when the handler should end soon, because the call was canceled or stopped, its
  /// lease was lost, its deadline has passed or the server is closing.
  virtual bool interrupted() const = 0;
  /// Sleeps until interrupted() or `deadline`. Returns true when interrupted.
  virtual bool wait_interrupted_until(TimePoint deadline) = 0;
  /// Must be called directly before the handler runs. Returns false when the handler must not run.
  virtual bool begin() { return true; }
  /// Returns the time at which the server marked this call as started; nullopt before that.
  virtual std::optional<TimePoint> marked_at() const { return std::nullopt; }
  virtual void progress(double fraction, ByteView feedback) = 0;
  /// Lets the next command with @on_new("blend") start; see Execution::let_next.
  virtual void let_next() {}
  /// Only the first call of `finish` or `fail` has an effect.
  virtual void finish(ByteView result) = 0;
  virtual void fail(Failure failure) = 0;
};

}  // namespace session

/// A call that arrived at its object. Move-only; a servant answers it now or later, on any thread.
/// A call that is destroyed without an answer fails as FAULT, for example with the text "the
/// handler of 'move' gave no answer".
class IncomingCall {
 public:
  explicit IncomingCall(std::shared_ptr<session::CallCore> core) : core_(std::move(core)) {}
  IncomingCall(IncomingCall&&) noexcept = default;
  IncomingCall& operator=(IncomingCall&&) noexcept;
  ~IncomingCall();

  const OperationDescription& operation() const { return core_->operation(); }
  ByteView arguments() const { return core_->arguments(); }
  const Caller& caller() const { return core_->caller(); }
  std::uint64_t counter() const { return core_->counter_in_session(); }
  std::uint64_t status_epoch() const { return core_->status_epoch(); }
  /// For the runtime. A thread that holds the result may use it while another thread answers the
  /// call: as long as the result exists, the call and its object exist, too.
  std::shared_ptr<session::CallCore> core() const { return core_; }
  bool interrupted() const { return core_->interrupted(); }
  bool wait_interrupted_until(TimePoint deadline) const {
    return core_->wait_interrupted_until(deadline);
  }
  void progress(double fraction, ByteView feedback) { core_->progress(fraction, feedback); }
  void let_next() { core_->let_next(); }
  /// For servants that queue calls: call this directly before the handler runs. Returns false when
  /// the call has ended while it was queued, or when its caller has withdrawn it. Then destroy the
  /// call without an answer.
  [[nodiscard]] bool begin() { return core_->begin(); }
  /// Returns the time at which the server marked this call as started, which is directly before the
  /// handler begins. The time is read from CLOCK_BOOTTIME (Clock::since_boot) and is at most one
  /// kernel tick (10 ms) too early. If the servant calls begin() itself, the result is nullopt
  /// before begin().
  std::optional<TimePoint> marked_at() const { return core_->marked_at(); }

  void finish(ByteView result) { std::exchange(core_, nullptr)->finish(result); }
  void fail(Failure failure) { std::exchange(core_, nullptr)->fail(std::move(failure)); }
  /// Fails the call with the failure in `fault`. If the exception in `fault` is not one of
  /// `declared`, the call fails as FAULT with a text that says so.
  void fail(const Fault& fault, std::initializer_list<std::string_view> declared);
  /// Call this in a catch block: fails the call as FAULT with the type and text of the thrown
  /// exception.
  void fail_as_thrown();

  /// For generated skeletons: answers the call with the result of its handler. `encode` writes the
  /// result, which takes `size` bytes.
  void finish(std::size_t size, FunctionRef<void(wire::Encoder&)> encode);
  /// Answers the call with `result`, the result of its handler. If `result` has a valid value,
  /// calls `give`, which must encode and send this value. Otherwise fails the call. `handler` is
  /// the scoped name of the operation, for the error text. Always returns true.
  template <class T, class Give>
  bool answer(std::string_view handler, const Result<T>& result,
              std::initializer_list<std::string_view> declared, Give give) {
    if (!result) {
      fail(result.error(), declared);
    } else if (auto wrong = wire::violation_of(*result); !wrong.empty()) {
      fail_result(handler, wrong);
    } else {
      give(*result);
    }
    return true;
  }
  /// Answers the call with the encoded value of `result`. The value is a number or has a type that
  /// encodes itself.
  template <class T>
  bool answer(std::string_view handler, const Result<T>& result,
              std::initializer_list<std::string_view> declared) {
    return answer(handler, result, declared, [this](const T& value) {
      finish(wire::plain_size(value), [&](wire::Encoder& to) { wire::put_plain(to, value); });
    });
  }
  /// Answers the call with the value as a block (length, then fields). Appendable types are encoded
  /// in this way.
  template <class T>
  bool answer_block(std::string_view handler, const Result<T>& result,
                    std::initializer_list<std::string_view> declared) {
    return answer(handler, result, declared, [this](const T& value) {
      const std::size_t size = value.encoded_size();
      finish(4 + size, [&](wire::Encoder& to) { wire::put_block(to, value, size); });
    });
  }
  bool answer(const Result<void>& result, std::initializer_list<std::string_view> declared);
  /// Fails the call as BAD_PARAMETER, because its arguments do not decode. Always returns true.
  bool refuse(const wire::DecodeError& why);
  /// Fails the call as FAULT, because the handler returned an invalid value. `operation` is the
  /// scoped name of the operation.
  void fail_result(std::string_view operation, const std::string& why);

 private:
  std::shared_ptr<session::CallCore> core_;
};

/// The execution of a cancelable handler. Valid while the handler runs.
template <class Feedback = void>
class Execution {
 public:
  explicit Execution(IncomingCall& call) : call_(call) {}
  /// Returns true when the handler should stop soon and return `Fault::interrupted()`.
  bool interrupted() const { return call_.interrupted(); }
  /// Sleeps for at most `time`. Returns true as soon as the handler is interrupted.
  bool wait_interrupted(Duration time) const {
    return call_.wait_interrupted_until(deadline_after(time));
  }
  /// Reports the completed fraction, 0 to 1, to the caller. Only the latest report is kept, so a
  /// handler may report as often as it likes. Feedback with a member that is out of range is not
  /// sent; an error is logged instead.
  void progress(double fraction) requires(std::is_void_v<Feedback>) {
    call_.progress(fraction, {});
  }
  template <class F = Feedback>
  requires(!std::is_void_v<F>) void progress(double fraction, const F& feedback) {
    if (const auto wrong = wire::violation_of(feedback); !wrong.empty()) {
      log_error(call_.operation().name, "feedback not sent: " + wrong);
      return;
    }
    call_.progress(fraction, wire::to_bytes(feedback));
  }
  /// For an operation with @on_new("blend"): lets the next command start while this command still
  /// runs, if the operation of the next command has @on_new("blend") too. The next command waits
  /// until the handler of this command calls let_next(). The handlers therefore begin in the order
  /// of their commands, and each handler decides when the next one may begin. Has no effect for
  /// other operations.
  void let_next() { call_.let_next(); }
  const Caller& caller() const { return call_.caller(); }
  /// Returns the number of the command in its caller's session.
  std::uint64_t counter() const { return call_.counter(); }
  /// Returns the epoch of the status under which the command was issued; 0 if it was issued under
  /// none. A stop, a take-over and the end of a status begin a new epoch.
  std::uint64_t status_epoch() const { return call_.status_epoch(); }
  /// For the runtime.
  std::shared_ptr<const session::CallCore> core() const { return call_.core(); }

 private:
  IncomingCall& call_;
};

namespace session {

/// Sends the samples of a servant's streams. A servant receives its Publisher when the servant is
/// added to a server.
class Publisher {
 public:
  virtual ~Publisher() = default;
  /// `stamp_ns`: the Unix time in ns at which the sample was measured, or `measured_now`.
  virtual void publish(const StreamDescription& stream, ByteView sample, std::int64_t stamp_ns) = 0;
  /// Lends `size` bytes of memory for the next sample of the stream. On failure, returns the
  /// reason.
  virtual tl::expected<LentMemory, std::string> lend(const StreamDescription& stream,
                                                     std::size_t size);
  /// Publishes the sample in `memory`, which lend() returned. Returns false if the stream was
  /// closed meanwhile.
  virtual bool publish_lent(const StreamDescription& stream, const LentMemory& memory,
                            std::int64_t stamp_ns);
  /// Must be called when the memory `memory`, which lend() returned, will not be published.
  virtual void give_back(const StreamDescription& stream, const LentMemory& memory);
  /// Returns the samples of an inward stream; null when the object has no such stream.
  virtual InwardCore* inward(const InwardDescription& stream) {
    static_cast<void>(stream);
    return nullptr;
  }
  /// Returns the name under which the servant is served now; an empty text while no server serves
  /// it.
  virtual std::string served_as() { return {}; }
};

/// The destination of the samples that a servant publishes. All functions may be called from
/// several threads: a thread of the servant may publish while a server adds or releases the
/// servant.
class PublisherSlot {
 public:
  /// Sets the publisher. Returns false if a server serves the servant already.
  bool claim(std::shared_ptr<Publisher> publisher);
  /// Waits until no thread uses the publisher, and drops the publisher.
  void release();
  /// Calls `use` with the publisher, if there is one. Takes no lock.
  void with(FunctionRef<void(Publisher&)> use) const;
  bool empty() const { return current_.load() == nullptr; }
  /// Returns the name under which a server serves the servant; an empty text when no server does.
  /// Takes no lock, because a forked child may call it.
  std::string served_as() const;

 private:
  void await_users() const;

  Mutex mutex_;
  std::shared_ptr<Publisher> owned_ GECOS_GUARDED_BY(mutex_);
  std::atomic<Publisher*> current_{nullptr};
  /// Number of threads in with(). A thread counts itself before it reads `current_`, and release()
  /// clears `current_` before it reads the number; both are sequentially consistent.
  mutable std::atomic<std::uint32_t> users_{0};
};

}  // namespace session

/// The base of every implementation of an object. A generated skeleton derives from this class, and
/// the class of the user derives from the skeleton. The handlers of a servant run one at a time,
/// unless the servant was added as thread-safe.
class Servant {
 public:
  virtual ~Servant();  ///< logs an error when a server still serves the servant
  Servant() = default;
  Servant(const Servant&) = delete;
  Servant& operator=(const Servant&) = delete;

  virtual const InterfaceDescription& gecos_interface() const = 0;
  /// Decodes the arguments, runs the handler and answers the call. If the handler throws an
  /// exception, the call ends as FAULT with the text of the exception. A class may override this
  /// function. If the override throws an exception, an error is logged, and the call ends as FAULT
  /// without the text of the exception.
  virtual void gecos_dispatch(IncomingCall call);

  /// Returns true when gecos_dispatch() only queues calls. The servant must then call
  /// IncomingCall::begin() before each handler.
  virtual bool gecos_begins_calls() const { return false; }

  /// For servants that queue calls: returns true when the handlers of both operations run on the
  /// same thread.
  virtual bool gecos_share_thread(const OperationDescription& one,
                                  const OperationDescription& other) const {
    static_cast<void>(one);
    static_cast<void>(other);
    return false;
  }

  /// Called when a session that sent calls (Caller::session) has ended. Runs on a thread of the
  /// server, concurrently with handlers; must not block.
  virtual void gecos_session_ended(std::uint64_t session) { static_cast<void>(session); }

  /// Sets the publisher that receives the samples of the servant. Returns false if a server serves
  /// the servant already.
  bool gecos_attach(std::shared_ptr<session::Publisher> publisher) {
    return gecos_publisher_.claim(std::move(publisher));
  }
  /// After this call the servant publishes nothing.
  void gecos_detach() { gecos_publisher_.release(); }
  /// Returns the name under which a server serves this servant; an empty text when no server does.
  std::string gecos_served_as() const { return gecos_publisher_.served_as(); }

 protected:
  /// For generated skeletons: answers a call of an own or inherited operation. Returns false when
  /// the interface has no operation with the code of the call.
  virtual bool gecos_answer(IncomingCall& call) {
    static_cast<void>(call);
    return false;
  }
  /// For generated skeletons: publishes a sample of `size` bytes.
  void gecos_publish(const StreamDescription& outward, std::size_t size,
                     FunctionRef<void(wire::Encoder&)> encode, std::int64_t stamp_ns);
  /// Publishes a number, or a value that encodes itself. `name` is the stream's scoped name.
  template <class T>
  void gecos_publish(const StreamDescription& outward, std::string_view name, const T& value,
                     std::int64_t stamp_ns) {
    if (!gecos_may_publish(name, value)) return;
    gecos_publish(
        outward, wire::plain_size(value), [&](wire::Encoder& to) { wire::put_plain(to, value); },
        stamp_ns);
  }
  /// Publishes a value as a block (length, then fields). Appendable types are encoded in this way.
  template <class T>
  void gecos_publish_block(const StreamDescription& outward, std::string_view name, const T& value,
                           std::int64_t stamp_ns) {
    if (!gecos_may_publish(name, value)) return;
    const std::size_t size = value.encoded_size();
    gecos_publish(
        outward, 4 + size, [&](wire::Encoder& to) { wire::put_block(to, value, size); }, stamp_ns);
  }
  /// The size of a sample whose @bulk sequence is written in place.
  struct LentSize {
    std::size_t bytes = 0;   ///< size of the whole encoded sample
    std::size_t octets = 0;  ///< number of elements of the @bulk sequence
    std::size_t most = 0;    ///< largest number of elements that the interface allows there
  };
  /// For generated skeletons and bindings: lends the memory of a sample. `encode` writes all
  /// members, with put_bulk() for the @bulk sequence. On failure, returns the reason. Returns an
  /// empty Loan if no server serves the servant.
  tl::expected<Loan, std::string> gecos_lend(const StreamDescription& outward, const LentSize& size,
                                             FunctionRef<void(wire::Encoder&)> encode);
  /// For generated skeletons: lends the memory of a sample. The sample has the members of `value`,
  /// and `octets` octets in its @bulk sequence. In `value`, the @bulk sequence must be empty.
  template <class T>
  Loan gecos_lend(const StreamDescription& outward, std::string_view name, const T& value,
                  std::size_t octets, std::size_t most) {
    if (!gecos_may_publish(name, value)) return {};
    return gecos_lent(name, gecos_lend(outward, {value.encoded_size() + octets, octets, most},
                                       [&](wire::Encoder& to) { value.encode(to); }));
  }
  /// Like gecos_lend(), but for a value that is encoded as a block.
  template <class T>
  Loan gecos_lend_block(const StreamDescription& outward, std::string_view name, const T& value,
                        std::size_t octets, std::size_t most) {
    if (!gecos_may_publish(name, value)) return {};
    const std::size_t size = value.encoded_size() + octets;
    return gecos_lent(name, gecos_lend(outward, {4 + size, octets, most}, [&](wire::Encoder& to) {
                        wire::put_block(to, value, size);
                      }));
  }
  template <class T>
  bool gecos_may_publish(std::string_view name, const T& value) const {
    if (!gecos_attached()) return false;
    const auto wrong = wire::violation_of(value);
    if (!wrong.empty()) gecos_not_published(name, wrong);
    return wrong.empty();
  }
  /// Returns true when a server has added this servant.
  bool gecos_attached() const { return !gecos_publisher_.empty(); }
  /// Logs why a sample was not published, at most ten times a second for each stream. The
  /// next line, if there is one, counts the samples that were left out. `name` is the
  /// stream's scoped name.
  static void gecos_not_published(std::string_view name, const std::string& why);
  /// If `lent` is an error, logs why no memory was lent, and returns an empty Loan. Otherwise
  /// returns the Loan.
  static Loan gecos_lent(std::string_view name, tl::expected<Loan, std::string> lent);

  session::PublisherSlot gecos_publisher_;

  friend void session::with_inward(const Servant& servant, const InwardDescription& stream,
                                   FunctionRef<void(session::InwardCore&)> use);
};

/// Returns the current Unix time in ns, for time stamps that people read.
std::int64_t unix_now_ns();

}  // namespace gecos

// What gidl generates for a server:
//
//   class ManipulatorServant : public virtual robcl::DeviceServant {
//    public:
//     const gecos::InterfaceDescription& gecos_interface() const override;
//    protected:
//     bool gecos_answer(gecos::IncomingCall& call) override;  // own codes, else those of the bases
//     virtual gecos::Result<robcl::Frame> tool() = 0;
//     virtual gecos::Result<robcl::Frame> tool_offset() = 0;
//     virtual gecos::Result<void> set_tool_offset(const robcl::Frame& value) = 0;
//     virtual gecos::Result<void> move(const robcl::Frame& goal, const std::optional<Trajectory>&
//     how,
//                                      gecos::Execution<MotionProgress>& run) = 0;
//     gecos::Inward<robcl::Frame>& alter() { return gecos_inward_alter_; }  // an inward stream
//     void publish_tool(const robcl::Frame& value, std::int64_t stamp_ns = gecos::measured_now);
//   };
//
// A root servant derives from `public virtual gecos::Servant`. The getter of a stream attribute is
// an ordinary handler. A call whose arguments do not decode or are outside their @range ends as
// BAD_PARAMETER with a text that names the field.
