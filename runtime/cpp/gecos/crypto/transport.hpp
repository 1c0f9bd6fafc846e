#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/result.hpp"
#include "gecos/crypto/aead.hpp"
#include "gecos/crypto/replay_window.hpp"

/// One direction of a channel. Packets may be lost, repeated or reordered on their way; each is
/// delivered at most once, and unaltered.
///
/// A frame is a counter (8 bytes, big-endian), the packet encrypted, and a tag (16 bytes). The
/// upper half of the counter is the generation of the key, the lower half numbers the packets of a
/// generation from 0. The key of a generation is Noise's REKEY of the previous key, so stolen keys
/// cannot decrypt earlier packets, and a new key needs no message. The whole counter is the nonce;
/// in generation 0 the encryption is that of Noise's transport messages.
///
///     Bytes frame(Sealer::overhead + packet.size());
///     std::ranges::copy(packet, frame.begin() + Sealer::text_at);
///     sealer.seal(header, frame);               // header is sent in clear, but authenticated
///     …
///     if (auto packet = opener.open(header, frame)) deliver(*packet);  // lies within `frame`
///
/// Sealer and Opener do not allocate, lock or read a clock. Only one thread at a time may use each
/// of them. A forked child must not use an inherited Sealer: two packets under one counter reveal
/// their contents.
namespace gecos::crypto {

/// When one direction of a channel changes to its next key: after this time or this number of
/// packets, whichever is reached first.
struct RekeyRule {
  Duration after = std::chrono::minutes{2};
  std::uint32_t packets = 1U << 24;  ///< at least 1
};

class Sealer {
 public:
  static constexpr std::size_t text_at = 8;
  static constexpr std::size_t overhead = text_at + tag_bytes;

  Sealer(const Key& key, TimePoint now, RekeyRule rule = {});
  Sealer(Sealer&&) = default;
  Sealer(const Sealer&) = delete;  // a copy would use the same counters again

  /// Seals in place the packet in `frame`, which begins at text_at and is followed by tag_bytes
  /// bytes. `associated` is not sent; the opener must pass identical associated data. @pre `frame`
  /// has at least `overhead` bytes.
  void seal(ByteView associated, std::span<std::byte> frame);

  /// Must be called regularly, at least every tenth of RekeyRule::after.
  void on_tick(TimePoint now);

  std::uint32_t generation() const { return generation_; }

 private:
  void next_generation();

  const RekeyRule rule_;
  Key key_;
  TimePoint since_;
  std::uint32_t generation_ = 0;
  std::uint32_t number_ = 0;  // number of the next packet
};

enum class OpenProblem : std::uint8_t {
  TooShort,  ///< shorter than a frame
  Replayed,  ///< the packet was delivered already
  TooOld,    ///< over a thousand numbers behind the newest packet, or its key is erased
  TooNew,    ///< the peer cannot use this generation of the key yet
  Forged,    ///< not from the peer, not for this channel, or altered
};
std::string_view to_string(OpenProblem problem);

class Opener {
 public:
  /// How many successive generations may be lost with all their packets. The limit bounds the cost
  /// of a forged frame.
  static constexpr std::uint32_t most_lost_generations = 8;
  /// How long packets under the previous key are still opened after the key changed.
  static constexpr Duration previous_kept = std::chrono::seconds{1};

  explicit Opener(const Key& key);

  /// Opens `frame` in place and returns the packet, which lies within `frame`. A failure leaves the
  /// Opener unchanged and `frame` unusable.
  tl::expected<std::span<std::byte>, OpenProblem> open(ByteView associated,
                                                       std::span<std::byte> frame);

  /// Call this at every heartbeat. The first call after a key change starts a period of
  /// `previous_kept`; a call after that period erases the previous key.
  void on_tick(TimePoint now);

  /// True when a packet was opened. This proves that the peer has the keys, and that the handshake
  /// was not a replay.
  bool opened_any() const { return opened_any_; }
  std::uint32_t generation() const { return current_.number; }

 private:
  struct Generation {
    std::uint32_t number = 0;
    Key key;
    ReplayWindow seen;
  };
  tl::expected<std::span<std::byte>, OpenProblem> open_with(Generation& generation,
                                                            std::uint64_t counter,
                                                            ByteView associated,
                                                            std::span<std::byte> frame);
  tl::expected<std::span<std::byte>, OpenProblem> open_newer(std::uint64_t counter,
                                                             ByteView associated,
                                                             std::span<std::byte> frame);

  Generation current_;
  std::optional<Generation> previous_;
  std::optional<TimePoint> previous_since_;
  bool opened_any_ = false;
};

}  // namespace gecos::crypto
