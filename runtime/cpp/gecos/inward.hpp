#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "gecos/base/clock.hpp"
#include "gecos/base/function_ref.hpp"
#include "gecos/description.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/wire/decoder.hpp"

/// The server's side of inward streams: how a servant reads the samples that clients send.
namespace gecos {

class Servant;
template <class Feedback>
class Execution;

/// One value of an inward stream.
template <class T>
struct InwardSample {
  T value{};
  std::uint64_t sequence = 0;  ///< rises by one per sample that its sender has sent
  /// The time at which the value was measured, in s of Unix time by the sender's clock; for display
  /// only.
  double stamp = 0;
  /// The time from measuring to reading. The age is exact on one host; between hosts, it is too
  /// small by at most the shortest transit time of a packet.
  Duration age{};
  std::uint64_t session = 0;  ///< session of the sender, as Caller::session
  std::uint64_t command = 0;  ///< counter of the command that the sample feeds; 0: none
};

namespace session {

class CallCore;

/// Says what a stream does with samples that feed no command. It takes them while no command takes
/// samples, or it always refuses them.
enum class Unfed : std::uint8_t { Taken, Refused };

/// An admitted sample before it is decoded. Its memory is reused for the next sample.
struct RawInward {
  media::StreamSample sample;
  ByteView value;  ///< the encoded value, a part of `sample.bytes`
  Duration age{};
  std::uint64_t session = 0;
  std::uint64_t command = 0;
};

/// The samples of one inward stream of an object, without their type. Thread-safe.
class InwardCore {
 public:
  virtual ~InwardCore() = default;
  /// Stores in `into` the oldest unread sample that may have an effect at present. Returns false
  /// when there is no such sample. Never waits.
  virtual bool next(RawInward& into, Unfed unfed) = 0;
  /// Must be called when the sample that `next` returned last cannot be decoded. The sample then
  /// counts as refused.
  virtual void unreadable(const RawInward& sample, const std::string& why) = 0;
  virtual bool expired() = 0;
  virtual FeedReport report() = 0;
  /// From now on, admits only samples that feed the command `call`. After `call` is interrupted,
  /// admits no sample. If several commands take samples, only the command that began last gets
  /// them. Returns a number that the caller must pass to `end_feeding`.
  virtual std::uint64_t begin_feeding(std::shared_ptr<const CallCore> call) = 0;
  virtual void end_feeding(std::uint64_t feeding) = 0;
};

/// Calls `use` with the core of the stream. Does nothing while no server serves `servant`.
void with_inward(const Servant& servant, const InwardDescription& stream,
                 FunctionRef<void(InwardCore&)> use);

}  // namespace session

/// The samples that clients send to an object on one inward stream. A generated servant has one
/// member of this type for each inward stream. Reading takes no mutex of the object. After the
/// first sample, reading allocates no memory for samples of a fixed size. One thread at a time may
/// read.
///
/// Each sample is judged when it is read. The session of the sample must be open. The sender must
/// have the status that the stream needs, under the present epoch. The sample must not be older
/// than the watchdog time or the lifespan of the stream. If the sample feeds a command, this
/// command must take samples (Feeding). A sample that does not meet these conditions has no effect
/// and is only counted.
///
/// After a pause of this process, samples are held back until commands may start again. The samples
/// of one client arrive in order. If a client sends more samples than the depth of the stream
/// between two reads, the oldest of these samples are lost.
template <class T>
class Inward {
 public:
  using Decode = bool (*)(wire::Decoder&, T&);
  /// For generated skeletons.
  Inward(const Servant& servant, const InwardDescription& inward, Decode decode)
      : servant_(servant), stream_(inward), decode_(decode) {}
  Inward(const Inward&) = delete;
  Inward& operator=(const Inward&) = delete;

  /// Returns the oldest unread sample; nullopt when there is none. Never waits.
  std::optional<InwardSample<T>> next() {
    int looks = most_looks;
    return next_within(looks);
  }
  /// Returns the newest unread sample and passes over the older ones; nullopt when there is none.
  std::optional<InwardSample<T>> newest() {
    std::optional<InwardSample<T>> sample;
    int looks = most_looks;
    while (auto later = next_within(looks)) sample = std::move(later);
    return sample;
  }
  /// Returns true when every sample that next() or newest() has returned is older than the watchdog
  /// time of the stream. Returns false for one watchdog time after the beginning of a Feeding, and
  /// always for a stream without a watchdog.
  bool expired() const {
    bool expired = stream_.watchdog > Duration{};
    with([&](session::InwardCore& core) { expired = core.expired(); });
    return expired;
  }
  /// Returns the counts of samples since the servant was added to its server.
  FeedReport report() const {
    FeedReport report;
    with([&](session::InwardCore& core) { report = core.report(); });
    return report;
  }
  /// Makes the stream refuse samples that feed no command, even while no command takes samples.
  void need_command() { unfed_ = session::Unfed::Refused; }

  /// While this object lives, the stream takes only the samples that feed one command. After the
  /// command is interrupted, the stream takes no samples.
  class [[nodiscard]] Feeding {
   public:
    Feeding(Inward& inward, const std::shared_ptr<const session::CallCore>& call)
        : stream_(inward) {
      stream_.with([&](session::InwardCore& core) { number_ = core.begin_feeding(call); });
    }
    ~Feeding() {
      stream_.with([&](session::InwardCore& core) { core.end_feeding(number_); });
    }
    Feeding(const Feeding&) = delete;
    Feeding& operator=(const Feeding&) = delete;

   private:
    Inward& stream_;
    std::uint64_t number_ = 0;
  };
  /// Lets the command of a running handler take the samples: `const auto feeding =
  /// alter().feeds(run);`. The stream then refuses samples that feed another command or no command.
  template <class Feedback>
  Feeding feeds(const Execution<Feedback>& run) {
    return {*this, run.core()};
  }

 private:
  /// The maximum number of samples that one call of next() or newest() reads. Without this limit, a
  /// client that floods the stream would keep the servant in the call.
  static constexpr int most_looks = 1024;

  std::optional<InwardSample<T>> next_within(int& looks) {
    std::optional<InwardSample<T>> sample;
    with([&](session::InwardCore& core) {
      while (looks-- > 0 && core.next(raw_, unfed_)) {
        wire::Decoder from(raw_.value);
        if (decode_(from, sample.emplace().value)) return;
        core.unreadable(raw_, from.error().message());
        sample.reset();
      }
    });
    if (!sample) return sample;
    sample->sequence = raw_.sample.sequence;
    sample->stamp = static_cast<double>(raw_.sample.stamp_ns) * 1e-9;
    sample->age = raw_.age;
    sample->session = raw_.session;
    sample->command = raw_.command;
    return sample;
  }
  template <class Use>
  void with(const Use& use) const {
    session::with_inward(servant_, stream_, use);
  }

  const Servant& servant_;
  const InwardDescription& stream_;
  const Decode decode_;
  session::Unfed unfed_ = session::Unfed::Taken;
  session::RawInward raw_;
};

}  // namespace gecos
