#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "gecos/base/clock.hpp"
#include "gecos/session/protocol/inward_sample.hpp"

namespace gecos::session {

/// What a server decides about a sample of an inward stream.
enum class InwardVerdict {
  Admitted,
  OtherSession,       ///< the header names another session than that of the connection
  SessionEnded,       ///< the session ended, or is lost
  OtherEpoch,         ///< the client's status has ended, or is another one
  NameUnconfirmed,    ///< the broker does not confirm the name of the object
  CommandNotRunning,  ///< the command does not run: it waits, has ended, or takes no samples
  TooOld,             ///< older than the watchdog or the lifespan of the stream
  NotNewer,           ///< an admitted sample of this stream is as new, or newer
};

/// The reason in words: "its command does not run".
std::string_view describe(InwardVerdict verdict);

/// What is true of the sender at the moment at which a sample is judged.
struct InwardSender {
  SessionId session{};
  bool alive = false;  ///< the session is open
  /// the epoch under which the session has the status that the stream needs; nullopt without it
  std::optional<Epoch> epoch{};
  /// counter of the command of this session that runs and takes samples of this stream; 0 when
  /// samples that feed no command are admitted
  std::optional<std::uint64_t> feeding{};
  /// the stream moves the object, and another server may have its name (NameClaim)
  bool name_unconfirmed = false;
};

/// How old a sample is, and the age from which on samples have no effect.
struct InwardAge {
  Duration age{};
  Duration limit = Duration::max();
};

/// Judges the samples of one inward stream of one session. Only an admitted sample may have an
/// effect. Pure: no clock, no input or output; does not allocate or lock. Give each stream that a
/// session opens an instance of its own.
class InwardAdmission {
 public:
  /// `sequence`: number of the sample in its stream, from 1, as the medium gives it.
  InwardVerdict judge(const InwardHeader& sample, std::uint64_t sequence,
                      const InwardSender& sender, const InwardAge& age = {});

 private:
  std::uint64_t newest_ = 0;  ///< sequence of the newest admitted sample
};

}  // namespace gecos::session
