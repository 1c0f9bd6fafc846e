#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string_view>

#include "gecos/crypto/channel.hpp"

namespace gecos::crypto {

struct HandshakeRule {
  /// Limits how many first messages of handshakes are checked: at most `burst` of them at once, and
  /// after that `per_second` of them in each second. A check takes up to 0.2 ms on the thread that
  /// also serves calls, so that a flood of first messages can take only a limited part of the
  /// thread's time.
  std::uint32_t burst = 256;
  std::uint32_t per_second = 200;
  /// When a first message is repeated within this time, the acceptor gives the same answer again.
  Duration answers_kept = std::chrono::seconds{5};
  /// The number of first messages that the acceptor remembers. It refuses a later replay of these
  /// messages.
  std::size_t remembered = 4096;
};

enum class Refusal : std::uint8_t {
  Busy,         ///< too many first messages; the client should repeat its message
  Malformed,    ///< not a first message for this key and context, or altered
  NotAdmitted,  ///< the client has proved that it owns its key, but the key is not admitted
  Replayed,     ///< the message was answered more than `answers_kept` ago
};
std::string_view to_string(Refusal refusal);

/// The server's side of the handshake that opens a channel. Stores nothing of a first message until
/// the message has proved the identity of its sender, and this sender is admitted.
///
/// An attacker can replay an old first message to a restarted server, or after `remembered` other
/// messages. Such a replay opens a channel, but the attacker does not have the keys of this
/// channel. Therefore the owner of a new channel must wait until Channel::in.opened_any() returns
/// true. Until then, the owner must not replace another channel by the new one, and must not act on
/// the payload. The owner must drop the new channel when no packet was opened on it within
/// `answers_kept`.
///
/// A HandshakeAcceptor reads no clock. Only one thread at a time may use it.
class HandshakeAcceptor {
 public:
  using Admission = std::function<bool(const PublicKey& peer)>;

  /// `own` must outlive the acceptor.
  HandshakeAcceptor(const Identity& own, Admission is_admitted, HandshakeRule rule = {},
                    RekeyRule rekey = {});

  struct Answer {
    Bytes second;                    ///< the second message, to be sent back
    std::optional<Channel> channel;  ///< nothing when the first message was repeated
    Bytes payload;  ///< the client's payload; empty when the first message was repeated
  };
  struct Refused {
    Refusal why;
    std::optional<PublicKey> who;  ///< the client's key, if the client proved that it owns it
  };
  /// Checks the first message `first` and returns the answer to it. The answer contains `payload`,
  /// encrypted for the client. For `context`, see HandshakeInitiator.
  tl::expected<Answer, Refused> answer(ByteView first, ByteView context, ByteView payload,
                                       TimePoint now);

  std::size_t remembered() const { return known_.size(); }

 private:
  using Digest = std::array<std::byte, 16>;
  struct Known {
    TimePoint when;
    Bytes second;  // the answer; empty when older than `answers_kept`
  };
  bool may_look(TimePoint now);
  void remember(const Digest& digest, Known known);
  void forget_answers(TimePoint now);

  const Identity& own_;
  const Admission is_admitted_;
  const HandshakeRule rule_;
  const RekeyRule rekey_;
  double budget_;  // how many first messages may be checked now
  std::optional<TimePoint> budgeted_;
  std::map<Digest, Known> known_;
  std::deque<Digest> order_;   // the keys of known_, oldest first
  std::size_t forgotten_ = 0;  // how many of the oldest in order_ have lost their answer
};

}  // namespace gecos::crypto
