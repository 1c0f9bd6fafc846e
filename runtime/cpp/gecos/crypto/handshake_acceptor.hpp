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
  /// First messages that are looked at: so many at once, and so many per second after that. Each
  /// costs up to .2 ms, so a flood of them takes a bounded share of the thread that also serves
  /// calls.
  std::uint32_t burst = 256;
  std::uint32_t per_second = 200;
  /// How long a repeated first message gets the same answer again.
  Duration answers_kept = std::chrono::seconds{5};
  /// First messages that are known again, and refused, when somebody plays them back later.
  std::size_t remembered = 4096;
};

enum class Refusal : std::uint8_t {
  Busy,         ///< too many at a time; an honest client repeats its message
  Malformed,    ///< no first message, not for this key and context, or altered
  NotAdmitted,  ///< proved who it is, and is not let in
  Replayed,     ///< answered long ago
};
std::string_view to_string(Refusal refusal);

/// A server's side of opening channels. Nothing is kept of a first message before it has proved who
/// wrote it and that one is admitted.
///
/// A recorded first message that comes again after `remembered` others, or to the server's next
/// life, does make a channel, of which the player has no key: until Channel::in.opened_any()
/// the holder of the channel must not let it displace another, must not act on its payload, and has
/// to drop it when nothing was opened within `answers_kept`.
///
/// Reads no clock; one thread at a time.
class HandshakeAcceptor {
 public:
  using Admission = std::function<bool(const PublicKey& peer)>;

  /// `own` must outlive it.
  HandshakeAcceptor(const Identity& own, Admission is_admitted, HandshakeRule rule = {},
                    RekeyRule rekey = {});

  struct Answer {
    Bytes second;                    ///< to be sent back
    std::optional<Channel> channel;  ///< nothing when the first message was a repetition
    Bytes payload;                   ///< the client's; empty when repeated
  };
  struct Refused {
    Refusal why;
    std::optional<PublicKey> who;  ///< where it is proved
  };
  /// `context`: see HandshakeInitiator. `payload` goes back to the client, encrypted.
  tl::expected<Answer, Refused> answer(ByteView first, ByteView context, ByteView payload,
                                       TimePoint now);

  std::size_t remembered() const { return known_.size(); }

 private:
  using Digest = std::array<std::byte, 16>;
  struct Known {
    TimePoint when;
    Bytes second;  // empty once it was kept long enough
  };
  bool may_look(TimePoint now);
  void remember(const Digest& digest, Known known);
  void forget_answers(TimePoint now);

  const Identity& own_;
  const Admission is_admitted_;
  const HandshakeRule rule_;
  const RekeyRule rekey_;
  double budget_;  // number of first messages that may still be checked
  std::optional<TimePoint> budgeted_;
  std::map<Digest, Known> known_;
  std::deque<Digest> order_;   // the keys of known_, oldest first
  std::size_t forgotten_ = 0;  // so many of order_ have no answer any more
};

}  // namespace gecos::crypto
