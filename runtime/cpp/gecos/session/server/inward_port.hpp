#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/access/object_presence.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/inward.hpp"
#include "gecos/session/process/pause_watch.hpp"
#include "gecos/session/server/feed_standing.hpp"
#include "gecos/session/server/inward_admission.hpp"
#include "gecos/session/server/name_claim.hpp"

namespace gecos::session {

/// A session that feeds an inward stream.
struct Feeder {
  SessionId session{};
  std::uint32_t stream = 0;  ///< the id under which the session shares its stream
  std::unique_ptr<media::StreamReader> reader;
  std::shared_ptr<const FeedStanding> standing;
  /// Returns this host's CLOCK_BOOTTIME minus the CLOCK_BOOTTIME of the sender's host, as
  /// media::Connection::clock_difference measures it. The function object keeps alive the
  /// connection that `reader` uses.
  std::function<Duration()> clock_difference;
};

/// Reads the samples of one inward stream of an object from all sessions that feed it, and judges
/// each sample when the servant reads it. Samples wait whenever commands would wait: while a pause
/// of this process is not judged, and while a heartbeat of the client is awaited. If the stream
/// moves the object, its samples also wait until the broker has confirmed the name of the object.
/// Uses no mutex of the object. Thread-safe.
class InwardPort final : public InwardCore {
 public:
  /// All arguments must outlive the port.
  InwardPort(const InwardDescription& stream, const Clock& clock, const PauseWatch& pauses,
             const NameClaim& claim, const access::ObjectPresence& presence)
      : stream_(stream), clock_(clock), pauses_(pauses), claim_(claim), presence_(presence) {}

  const InwardDescription& stream() const { return stream_; }
  /// Adds the stream of a session. The new stream replaces an earlier stream of the same session,
  /// and the unread samples of that stream are lost.
  void add(Feeder feeder);
  bool has(SessionId session, std::uint32_t stream);
  /// Must be called when the session sends no more samples on `stream`. The samples that the
  /// session has already sent can still be read.
  void end(SessionId session, std::uint32_t stream);
  /// Must be called when the session has ended. Its unread samples are refused and counted.
  void depart(SessionId session);
  /// Returns the counts of the samples of `session`, which feeds this stream.
  FeedReport report_of(SessionId session);

  bool next(RawInward& into, Unfed unfed) override;
  void unreadable(const RawInward& sample, const std::string& why) override;
  bool expired() override;
  FeedReport report() override;
  std::uint64_t begin_feeding(std::shared_ptr<const CallCore> call) override;
  void end_feeding(std::uint64_t feeding) override;

 private:
  /// A command that takes samples.
  struct Feeding {
    std::uint64_t number = 0;
    std::shared_ptr<const CallCore> call;
  };
  /// How many samples got each verdict. Copying this struct allocates no memory.
  struct Counts {
    FeedReport numbers;  ///< the counts; the text of the report is not set
    InwardVerdict last_refusal = InwardVerdict::Admitted;
    /// The text of the last refusal, if the refused sample did not decode.
    std::shared_ptr<const std::string> unreadable{};
  };
  struct Source {
    Feeder feeder;
    bool ended = false;       ///< no more samples will come on the stream of `feeder`
    std::uint64_t after = 0;  ///< sequence number of the sample that was read last
    InwardAdmission admission{};
    Counts counts{};
  };
  /// The moment at which a sample is judged, and whether samples without a command are admitted.
  struct Look {
    TimePoint now{};
    Unfed unfed{};
  };

  static void count(Counts& counts, InwardVerdict verdict);
  static void add(Counts& to, const Counts& more);
  static FeedReport in_words(const Counts& counts);
  bool moves_the_object() const { return stream_.status != access::Status::Sensor; }
  bool next_of(Source& source, RawInward& into, const Look& look) GECOS_REQUIRES(mutex_);
  InwardVerdict judge(Source& source, RawInward& into, const Look& look) GECOS_REQUIRES(mutex_);
  /// `sent`: when the sample was sent, by the clock of this host.
  InwardSender sender_of(const Source& source, const InwardHeader& header, TimePoint sent,
                         const Look& look) const GECOS_REQUIRES(mutex_);
  std::optional<std::uint64_t> fed_by(SessionId session, Unfed unfed) const GECOS_REQUIRES(mutex_);
  bool expired_now() const GECOS_REQUIRES(mutex_);
  Source* find(SessionId session) GECOS_REQUIRES(mutex_);

  const InwardDescription& stream_;
  const Clock& clock_;
  const PauseWatch& pauses_;
  const NameClaim& claim_;
  const access::ObjectPresence& presence_;
  Mutex mutex_;
  std::vector<std::unique_ptr<Source>> sources_ GECOS_GUARDED_BY(mutex_);
  std::size_t turn_ GECOS_GUARDED_BY(mutex_) = 0;      ///< index of the source that is read first
  Counts gone_ GECOS_GUARDED_BY(mutex_);               ///< counts of sources that are gone
  std::vector<Feeding> fed_ GECOS_GUARDED_BY(mutex_);  ///< the last element takes the samples
  std::uint64_t feedings_ GECOS_GUARDED_BY(mutex_) = 0;
  /// The time of measurement of the newest sample that the servant took; or, if later, the time at
  /// which a command began to take samples.
  std::optional<TimePoint> fresh_at_ GECOS_GUARDED_BY(mutex_);
  /// The value of `fresh_at_` before the servant took the last sample.
  std::optional<TimePoint> fresh_before_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
