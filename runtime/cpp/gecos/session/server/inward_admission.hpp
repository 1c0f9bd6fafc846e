#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "gecos/base/clock.hpp"
#include "gecos/session/protocol/inward_sample.hpp"

namespace gecos::session {

/// The verdict of a server about one sample of an inward stream.
enum class InwardVerdict {
  Admitted,
  OtherSession,     ///< the header names another session than that of the connection
  SessionEnded,     ///< the session ended, or is lost
  OtherEpoch,       ///< the client's status has ended, or is another one
  NameUnconfirmed,  ///< the broker does not confirm the name of the object
  /// Nobody is known to be present in the zone of the object, or nobody was when the sample was
  /// sent.
  NobodyPresent,
  CommandNotRunning,  ///< the command does not run: it waits, has ended, or takes no samples
  TooOld,             ///< older than the watchdog or the lifespan of the stream
  NotNewer,           ///< an admitted sample of this stream is as new, or newer
};

/// Returns the reason for a verdict in words, for example "its command does not run".
std::string_view describe(InwardVerdict verdict);

/// What the server knows of the sender when it judges a sample.
struct InwardSender {
  SessionId session{};
  bool alive = false;  ///< the session is open
  /// The epoch under which the session has the status that the stream needs; nullopt if the session
  /// does not have this status.
  std::optional<Epoch> epoch{};
  /// The counter of the running command of this session that takes samples of this stream; 0 when
  /// samples without a command are admitted; nullopt when no samples are admitted.
  std::optional<std::uint64_t> feeding{};
  /// The stream moves the object, and another server may have the name of the object (NameClaim).
  bool name_unconfirmed = false;
  bool nobody_present = false;  ///< the stream needs a person in the zone of the object
};

/// The age of a sample, and the age from which on samples have no effect.
struct InwardAge {
  Duration age{};
  Duration limit = Duration::max();
};

/// Judges the samples of one inward stream of one session. Only an admitted sample may have an
/// effect. Pure: reads no clock, does no input or output, and does not allocate or lock. Each
/// stream that a session opens needs its own instance.
class InwardAdmission {
 public:
  /// `sequence`: number of the sample in its stream, from 1, as the medium gives it.
  InwardVerdict judge(const InwardHeader& sample, std::uint64_t sequence,
                      const InwardSender& sender, const InwardAge& age = {});

 private:
  std::uint64_t newest_ = 0;  ///< sequence of the newest admitted sample
};

}  // namespace gecos::session
